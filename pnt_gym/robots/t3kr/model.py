"""The T3KR-class robot as a closed chain in a MuJoCo model specification.

Four arms hang from the base, rods hang from the arms by U joints, the platform rides on three slides, and
`connect` equalities close the loops between rod ends and platform. With four rods each parallelogram is one
rod of double mass and the slides keep the platform level; with eight rods the platform may also turn, and
only the parallelograms hold it.
"""

from dataclasses import dataclass
from typing import Literal, final

import numpy as np

from pnt_gym.engine import MjsBody, MjSpec, mujoco
from pnt_gym.errors import ConfigError
from pnt_gym.planning.arrays import Floats
from pnt_gym.robots.specification import add_motor, close_loop, set_inertia
from pnt_gym.robots.t3kr.geometry import N_ARMS, T3KR, T3krGeometry
from pnt_gym.robots.t3kr.visuals import dress_arm, dress_base, dress_platform, dress_rod

Rods = Literal["four", "eight"]

_PLATFORM_INERTIA = (0.006, 0.006, 0.010)
"""A 2 kg disc of 0.10 m radius, kg m^2."""
_ARM_TWIST_INERTIA = 1e-3
"""Of an arm about its long axis, kg m^2; an arm never turns about it."""
_ROD_RADIUS = 0.008
"""Carbon tube, m; only its small inertia about its own axis depends on it."""

_SLIDES = ("platform_x", "platform_y", "platform_z")
_SITE_SIZE = (0.006, 0.006, 0.006)
_HIDDEN = 4


@final
@dataclass(frozen=True)
class T3krHandles:
    """Names of what `add_t3kr` added, in the order of the compiled model's arrays."""

    rods: Rods
    geometry: T3krGeometry
    joints: tuple[str, ...]
    """Every joint, in the order of `closed_pose`: per arm its hinge and its rods', then the platform's."""
    arm_joints: tuple[str, ...]
    actuators: tuple[str, ...]
    """Motors; each takes three consecutive controls: position, velocity, feed-forward torque."""
    equalities: tuple[str, ...]
    """Loop closures. All must stay active."""
    platform: str = "platform"
    """Body whose origin is the TCP."""
    tcp: str = "tcp"
    """Site at the TCP."""


def rod_names(arm: int, rods: Rods) -> tuple[str, ...]:
    """Names of one arm's rods."""
    return (f"rod_{arm}",) if rods == "four" else (f"rod_{arm}_left", f"rod_{arm}_right")


def add_t3kr(spec: MjSpec, geometry: T3krGeometry = T3KR, rods: Rods = "four") -> T3krHandles:
    """Add the robot to a model specification.

    Args:
        spec: a mujoco.MjSpec; its world's z = 0 is the top of the robot's workspace.
        geometry: the robot.
        rods: "four" (fast, the default) or "eight" (complete parallelograms, for validation).

    Returns:
        The names of everything added.

    Raises:
        ConfigError: (a ValueError) rods is neither "four" nor "eight".
    """
    if rods not in ("four", "eight"):
        raise ConfigError(f'rods must be "four" or "eight", got {rods!r}')
    dress_base(spec, geometry)
    joints: list[str] = []
    for arm in range(N_ARMS):
        joints += _add_arm(spec, geometry, arm, rods)
    joints += _add_platform(spec, geometry, rods)
    loops = _close_loops(spec, rods)
    arms, motors = (tuple(f"{part}_{arm}" for arm in range(N_ARMS)) for part in ("arm", "motor"))
    for motor, arm in zip(motors, arms, strict=True):
        add_motor(spec, motor, arm, geometry.torque_limit, geometry.kp, geometry.kv)
    return T3krHandles(rods, geometry, tuple(joints), arms, motors, loops)


def _rod_sides(geometry: T3krGeometry, rods: Rods) -> tuple[float, ...]:
    """Where the rods of one arm sit along the motor axis, m from its middle."""
    half = geometry.rod_spacing / 2
    return (0.0,) if rods == "four" else (half, -half)


def _add_arm(spec: MjSpec, geometry: T3krGeometry, arm: int, rods: Rods) -> list[str]:
    half = float(geometry.arms.azimuth[arm]) / 2
    body = spec.worldbody.add_body(
        name=f"arm_{arm}", pos=geometry.arms.pivot[arm], quat=[np.cos(half), 0, 0, np.sin(half)]
    )
    # A positive angle lifts the arm: right-handed about -y of the arm frame.
    body.add_joint(name=f"arm_{arm}", axis=[0, -1, 0], armature=geometry.armature)
    inertia = (_ARM_TWIST_INERTIA, geometry.arm_inertia, geometry.arm_inertia)
    set_inertia(body, geometry.arm_mass, (geometry.arm_com, 0, 0), inertia)
    dress_arm(body, geometry, axle=rods == "eight")
    joints = [f"arm_{arm}"]
    for name, side in zip(rod_names(arm, rods), _rod_sides(geometry, rods), strict=True):
        joints += _add_rod(body, geometry, name, side)
    return joints


def _add_rod(arm: MjsBody, geometry: T3krGeometry, name: str, side: float) -> list[str]:
    """A rod along -z of its frame; hinges about the motor axis, then about x, never lock below 90 degrees."""
    length, single = geometry.rod_length, side != 0.0
    mass = geometry.rod_mass * (1.0 if single else 2.0)
    body = arm.add_body(name=name, pos=[geometry.arm_length, side, 0])
    body.add_joint(name=f"{name}_swing", axis=[0, -1, 0])
    body.add_joint(name=f"{name}_tilt", axis=[1, 0, 0])
    across = mass * length**2 / 12.0
    set_inertia(body, mass, (0, 0, -length / 2), (across, across, mass * _ROD_RADIUS**2))
    body.add_site(name=f"{name}_end", pos=[0, 0, -length], size=_SITE_SIZE, group=_HIDDEN)
    dress_rod(body, geometry, single)
    return [f"{name}_swing", f"{name}_tilt"]


def _add_platform(spec: MjSpec, geometry: T3krGeometry, rods: Rods) -> list[str]:
    body = spec.worldbody.add_body(name="platform")
    joints: list[str] = [*_SLIDES]
    for name, axis in zip(_SLIDES, np.eye(3), strict=True):
        body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)
    if rods == "eight":
        body.add_joint(name="platform_turn", type=mujoco.mjtJoint.mjJNT_BALL)
        joints.append("platform_turn")
    set_inertia(body, geometry.platform_mass, (0, 0, geometry.attach_height), _PLATFORM_INERTIA)
    body.add_site(name="tcp", size=_SITE_SIZE, group=_HIDDEN)
    frames = geometry.arms
    for arm in range(N_ARMS):
        axis = np.array([-frames.sin[arm, 0], frames.cos[arm, 0], 0.0])
        for name, side in zip(rod_names(arm, rods), _rod_sides(geometry, rods), strict=True):
            place: Floats = frames.attach[arm] + side * axis
            body.add_site(name=f"{name}_attach", pos=place, size=_SITE_SIZE, group=_HIDDEN)
    dress_platform(body, geometry, axles=rods == "eight")
    return joints


def _close_loops(spec: MjSpec, rods: Rods) -> tuple[str, ...]:
    names: list[str] = []
    for rod in (name for arm in range(N_ARMS) for name in rod_names(arm, rods)):
        names.append(f"loop_{rod.removeprefix('rod_')}")
        close_loop(spec, names[-1], f"{rod}_end", f"{rod}_attach")
    return tuple(names)
