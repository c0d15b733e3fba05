"""The 4-DoF gripper robot as a closed chain in a MuJoCo model specification.

Four arms turn about horizontal axes, a forearm hangs from each arm by a U joint, and `connect` equalities close the
loops to the platform. A parallelogram is modelled by one rod of double mass, since the three slides that carry the
platform keep the platform level. The platform's halves turn about their own hinges, coupled one to one by a joint
equality, the gear. Each half carries a finger on a torsion spring.

World z = 0 is the plane of the motor axes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.engine import MjsBody, MjSpec, mujoco
from pnt_gym.errors import ConfigError
from pnt_gym.palette import RUBBER
from pnt_gym.robots.gripper.build import PROTOTYPE_BUILD, Build
from pnt_gym.robots.gripper.geometry import N_ARMS, PROTOTYPE, Dimensions
from pnt_gym.robots.gripper.visuals import dress_arm, dress_base, dress_finger, dress_half, dress_middle, dress_rod
from pnt_gym.robots.specification import (
    add_arm,
    add_level_platform,
    add_motor,
    add_rod,
    add_site,
    join_angles,
    join_sites,
    set_inertia,
)
from pnt_gym.robots.specification import set_options as set_chain_options

PAD_BIT: Final = 2
"""Contact bit of the pads, for objects that may be gripped."""
PAD_SOLREF: Final = (0.004, 1.0)
PAD_SOLIMP: Final = (0.9, 0.99, 0.0005, 0.5, 2.0)
"""Impedance of the pads: they give by some tenths of a millimetre, so that a face and not an edge carries."""
LONGEST_STEP: Final = 0.001
"""Longest physics step [s]: loops stay closed to 0.01 mm; beyond, the servos' damping nears its limit of stability."""

_SIDES = (("right", 1.0), ("left", -1.0))
_ROD_RADIUS = 0.003
_THIN = 0.1
"""Inertia of slender parts about their long axis over that across."""


@final
@dataclass(frozen=True)
class Gripper4Handles:
    """Names of the elements that `add_gripper` added, in the order of the compiled model's arrays."""

    joints: tuple[str, ...]
    """In the order of `closed_pose`: each arm's hinge, forearm swing and forearm tilt, then the platform's seven."""
    actuators: tuple[str, ...]
    """Motors; each motor takes three consecutive controls: angle, speed, feed-forward torque."""
    pads: tuple[str, str] = ("pad_right", "pad_left")
    """Geoms on the side of +y and of -y."""
    grip: str = "grip"
    """Site midway between the pads."""


def add_gripper(spec: MjSpec, dimensions: Dimensions = PROTOTYPE, build: Build = PROTOTYPE_BUILD) -> Gripper4Handles:
    """Add the robot to a model specification and return the names; positions agree with the kinematics."""
    dress_base(spec, dimensions)
    joints: list[str] = []
    servo, r = build.servo, dimensions.r
    across = build.arm_mass * r**2 / 12.0
    for arm in range(N_ARMS):
        azimuth = arm * np.pi / 2.0
        pivot = (dimensions.k * np.cos(azimuth), dimensions.k * np.sin(azimuth), 0.0)
        body = add_arm(spec, f"arm_{arm}", pivot, azimuth, servo.armature, servo.damping)
        set_inertia(body, build.arm_mass, (r / 2.0, 0, 0), (_THIN * across, across, across))
        dress_arm(body, dimensions)
        dress_rod(add_rod(body, f"rod_{arm}", (r, 0, 0), dimensions.l, build.rod_mass, _ROD_RADIUS), dimensions)
        joints += [f"arm_{arm}", f"rod_{arm}_swing", f"rod_{arm}_tilt"]
    joints += _add_platform(spec, dimensions, build)
    # Four loops and the gear; all must stay active.
    for arm in range(N_ARMS):
        join_sites(spec, f"loop_{arm}", f"rod_{arm}_end", f"attach_{arm}")
    join_angles(spec, "gear", "half_right", "half_left")
    motors = tuple(f"motor_{arm}" for arm in range(N_ARMS))
    for arm, motor in enumerate(motors):
        add_motor(spec, motor, f"arm_{arm}", servo.stall_torque, servo.kp, servo.kv)
    return Gripper4Handles(tuple(joints), motors)


def set_options(spec: MjSpec, timestep: float, density: float = 0.0, viscosity: float = 0.0) -> None:
    """Set the physics options that the robot needs: the options of all robots, with explicit joint damping.

    Implicit damping is added after the constraints are solved and would open the loops. Arguments as
    `pnt_gym.robots.specification.set_options`.

    Raises:
        ConfigError: (a ValueError) the timestep is outside (0, 1 ms], or the density or the viscosity is negative.
    """
    if not 0.0 < timestep <= LONGEST_STEP:
        raise ConfigError(f"timestep must be above 0 and at most {LONGEST_STEP} s, got {timestep}")
    set_chain_options(spec, timestep, density, viscosity)
    # Objects of this robot are slow, 2 mm a step at most: looking ahead for contacts would cost a tenth of the time.
    spec.option.enableflags = int(spec.option.enableflags) & ~int(mujoco.mjtEnableBit.mjENBL_SPECULATIVE.value)
    spec.option.disableflags = int(spec.option.disableflags) | int(mujoco.mjtDisableBit.mjDSBL_EULERDAMP.value)


def _add_platform(spec: MjSpec, dims: Dimensions, build: Build) -> list[str]:
    body, joints = add_level_platform(spec)
    about = build.platform_mass * dims.u**2 / 3.0
    set_inertia(body, build.platform_mass, (0, 0, 0), (_THIN * about, about, about))
    add_site(body, "attach_0", (dims.u, 0, 0))
    add_site(body, "attach_2", (-dims.u, 0, 0))
    add_site(body, "grip", (0, 0, -build.claws.length))
    dress_middle(body, dims)
    for side, sign in _SIDES:
        joints += _add_half(body, dims, build, side, sign)
    return joints


def _add_half(platform: MjsBody, dims: Dimensions, build: Build, side: str, sign: float) -> list[str]:
    """Add a platform half with its finger; the angles of half and finger are positive when the claws open."""
    half = platform.add_body(name=f"half_{side}", pos=[0, sign * dims.v, 0])
    half.add_joint(name=f"half_{side}", axis=[sign, 0, 0])
    across = build.half_mass * dims.w**2 / 12.0
    set_inertia(half, build.half_mass, (0, sign * dims.w / 2.0, 0), (across, _THIN * across, across))
    add_site(half, f"attach_{1 if sign > 0 else 3}", (0, sign * dims.w, 0))
    dress_half(half, dims, sign)
    claws = build.claws
    turn = -sign * claws.theta / 2.0
    finger = half.add_body(name=f"finger_{side}", quat=[np.cos(turn), np.sin(turn), 0, 0])
    finger.add_joint(
        name=f"finger_{side}",
        axis=[sign, 0, 0],
        stiffness=np.array([claws.stiffness, 0.0, 0.0]),
        damping=np.array([claws.damping, 0.0, 0.0]),
    )
    across = build.finger_mass * claws.length**2 / 12.0
    set_inertia(finger, build.finger_mass, (0, 0, -claws.length / 2.0), (across, across, _THIN * across))
    _add_pad(finger, dims, build, side, sign)
    return [f"half_{side}", f"finger_{side}"]


def _add_pad(finger: MjsBody, dims: Dimensions, build: Build, side: str, sign: float) -> None:
    claws = build.claws
    face = sign * (claws.width / 2.0 - dims.v)
    centre = (0.0, face + sign * claws.pad[1] / 2.0, -claws.length)
    finger.add_geom(
        name=f"pad_{side}",
        type=mujoco.mjtGeom.mjGEOM_BOX,
        pos=centre,
        size=np.array(claws.pad) / 2.0,
        mass=0,
        contype=PAD_BIT,
        conaffinity=0,
        priority=1,
        condim=4,
        friction=[claws.friction, 0.005, 0.0001],
        solref=PAD_SOLREF,
        solimp=PAD_SOLIMP,
        rgba=RUBBER,
        group=2,
    )
    dress_finger(finger, claws, centre, sign)
