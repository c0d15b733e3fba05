"""The T3KR-class robot as a closed chain in a MuJoCo model specification.

Four arms hang from the base, rods hang from the arms by U joints, the platform rides on three slides, and
`connect` equalities close the loops between rod ends and platform. With four rods each parallelogram is one
rod of double mass and the slides keep the platform level; with eight rods the platform may also turn, and
only the parallelograms hold it.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, Self, final

from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats
from pnt_gym.engine import MjSpec, mujoco
from pnt_gym.errors import ConfigError
from pnt_gym.robots.joints import JointMotion, MotorLimits, Place
from pnt_gym.robots.specification import (
    add_arm,
    add_level_platform,
    add_motor,
    add_rod,
    add_site,
    join_sites,
    set_inertia,
)
from pnt_gym.robots.t3kr.geometry import N_ARMS, T3KR, T3krGeometry
from pnt_gym.robots.t3kr.kinematics import closed_pose, closed_velocity, joint_knots
from pnt_gym.robots.t3kr.visuals import dress_arm, dress_base, dress_platform, dress_rod

Rods = Literal["four", "eight"]
_LISTS = ("joints", "arm_joints", "actuators", "equalities")

_PLATFORM_INERTIA = (0.006, 0.006, 0.010)
"""A 2 kg disc of 0.10 m radius, kg m^2."""
_ARM_TWIST_INERTIA = 1e-3
"""Inertia of an arm about its long axis, about which an arm never turns, kg m^2."""
_ROD_RADIUS = 0.008
"""Carbon tube, m."""


@final
@dataclass(frozen=True)
class T3krHandles:
    """Names of the elements that `add_t3kr` added, in the order of the compiled model's arrays."""

    rods: Rods
    geometry: T3krGeometry
    joints: tuple[str, ...]
    """Joints in the order of `closed_pose`: each arm's hinge and rod joints, then the platform's."""
    arm_joints: tuple[str, ...]
    actuators: tuple[str, ...]
    """Motors; each motor takes three consecutive controls: position, velocity, feed-forward torque."""
    equalities: tuple[str, ...]
    """Loop closures; all of them must stay active."""
    platform: str = "platform"
    """Body whose origin is the TCP."""
    tcp: str = "tcp"
    """Site at the TCP."""

    @cached_property
    def rods_per_arm(self) -> int:
        """Rods per arm, 1 or 2."""
        return len(self.equalities) // N_ARMS

    @property
    def motor_joints(self) -> tuple[str, ...]:
        """Joints that the motors drive."""
        return self.arm_joints

    @property
    def limits(self) -> MotorLimits:
        """Limits of the motors; ranges and speeds are not known."""
        return MotorLimits.of_torque(self.geometry.torque_limit, N_ARMS)

    @property
    def mount(self) -> Place:
        """Middle of the motors' axes, above the workspace [m]."""
        return 0.0, 0.0, self.geometry.pivot_z

    def pose(self, hand: ArrayLike) -> Floats:
        """Joint positions with the TCP at points (N, 3) [m], see `closed_pose`."""
        return closed_pose(hand, self.rods_per_arm, self.geometry)

    def rates(self, hand: ArrayLike, velocity: ArrayLike) -> Floats:
        """Joint velocities while the TCP moves, see `closed_velocity`."""
        return closed_velocity(hand, velocity, self.rods_per_arm, self.geometry)

    def motion(self, position: Floats, velocity: Floats, acceleration: Floats) -> JointMotion:
        """Motion and torques of the arms for the TCP's motion (..., 3), see `joint_knots`."""
        return joint_knots(position, velocity, acceleration, geometry=self.geometry)

    def with_prefix(self, prefix: str) -> Self:
        """The names of the robot's elements after its specification is attached to another one with a prefix."""
        lists = {name: tuple(prefix + entry for entry in getattr(self, name)) for name in _LISTS}
        return replace(self, platform=prefix + self.platform, tcp=prefix + self.tcp, **lists)


def add_t3kr(spec: MjSpec, geometry: T3krGeometry = T3KR, rods: Rods = "four") -> T3krHandles:
    """Add the robot to a model specification and return the names; z = 0 is the top of the robot's workspace.

    The model with four rods is fast; the model with eight rods, complete parallelograms, is for validation.

    Raises:
        ConfigError: (a ValueError) rods is neither "four" nor "eight".
    """
    if rods not in ("four", "eight"):
        raise ConfigError(f'rods must be "four" or "eight", got {rods!r}')
    dress_base(spec, geometry)
    single, joints, loops = rods == "eight", list[str](), list[str]()
    inertia = (_ARM_TWIST_INERTIA, geometry.arm_inertia, geometry.arm_inertia)
    mass = geometry.rod_mass * (1.0 if single else 2.0)
    for arm, (pivot, azimuth) in enumerate(zip(geometry.arms.pivot, geometry.arms.azimuth, strict=True)):
        joints.append(f"arm_{arm}")
        body = add_arm(spec, joints[-1], pivot, float(azimuth), geometry.armature)
        set_inertia(body, geometry.arm_mass, (geometry.arm_com, 0, 0), inertia)
        dress_arm(body, geometry, axle=single)
        for name, side in _rods(geometry, arm, rods).items():
            rod = add_rod(body, name, (geometry.arm_length, side, 0), geometry.rod_length, mass, _ROD_RADIUS)
            dress_rod(rod, geometry, single)
            joints += [f"{name}_swing", f"{name}_tilt"]
    joints += _add_platform(spec, geometry, rods)
    for rod in (name for arm in range(N_ARMS) for name in _rods(geometry, arm, rods)):
        loops.append(f"loop_{rod.removeprefix('rod_')}")
        join_sites(spec, loops[-1], f"{rod}_end", f"{rod}_attach")
    arms, motors = (tuple(f"{part}_{arm}" for arm in range(N_ARMS)) for part in ("arm", "motor"))
    for motor, arm in zip(motors, arms, strict=True):
        add_motor(spec, motor, arm, geometry.torque_limit, geometry.kp, geometry.kv)
    return T3krHandles(rods, geometry, tuple(joints), arms, motors, tuple(loops))


def _rods(geometry: T3krGeometry, arm: int, rods: Rods) -> dict[str, float]:
    """Names of an arm's rods, with each rod's offset along the motor axis from the elbow's middle [m]."""
    half = geometry.rod_spacing / 2
    return {f"rod_{arm}": 0.0} if rods == "four" else {f"rod_{arm}_left": half, f"rod_{arm}_right": -half}


def _add_platform(spec: MjSpec, geometry: T3krGeometry, rods: Rods) -> list[str]:
    body, joints = add_level_platform(spec)
    if rods == "eight":
        body.add_joint(name="platform_turn", type=mujoco.mjtJoint.mjJNT_BALL)
        joints.append("platform_turn")
    set_inertia(body, geometry.platform_mass, (0, 0, geometry.attach_height), _PLATFORM_INERTIA)
    add_site(body, "tcp")
    frames = geometry.arms
    for arm in range(N_ARMS):
        for name, side in _rods(geometry, arm, rods).items():
            add_site(body, f"{name}_attach", frames.attach[arm] + side * frames.motor_axis[arm])
    dress_platform(body, geometry, axles=rods == "eight")
    return joints
