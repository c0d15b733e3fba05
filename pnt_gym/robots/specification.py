"""Parts that all robots share in a MuJoCo model specification: options, inertias, motors and loops of closed chains."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import numpy as np

from pnt_gym.arrays import Point
from pnt_gym.constants import AIR_DENSITY, AIR_VISCOSITY, GRAVITY
from pnt_gym.engine import MjsBody, MjSpec, mujoco
from pnt_gym.errors import ConfigError

LOOP_SOLREF: Final = (0.002, 1.0)
"""Time constant (s) and damping ratio of the loops; MuJoCo's slower default opens the loops by 2.5 mm."""
LOOP_SOLIMP: Final = (0.99, 0.999, 0.001, 0.5, 2.0)
"""Impedance of the loops: nearly rigid from the first micrometre on."""
LOOP: Final[Mapping[str, Point]] = {"solref": LOOP_SOLREF, "solimp": LOOP_SOLIMP}
LONGEST_STEP: Final = 0.002
"""Longest physics step [s] at which loops and motors are accurate.

The one-joint thrower's release error then stays below its repeatability.
"""


def set_options(spec: MjSpec, timestep: float, density: float = AIR_DENSITY, viscosity: float = AIR_VISCOSITY) -> None:
    """Set the physics options that all robots need.

    Explicit Euler is deliberate: implicit integrators apply the motors' damping after the constraints are solved and
    open the loops ten times wider. Explicit Euler is also a leapfrog of second order: velocities belong to the middle
    of the step before, which the one-joint thrower's references and release count on. The Jacobian is dense because
    MuJoCo 4.0.0 has a bug in its sparse Newton factor.

    Args:
        spec: a mujoco.MjSpec.
        timestep: physics step, s; 0.4 ms to evaluate (the T3KR's 2500 Hz), 1 ms to train, at most 2 ms.
        density: of the air, kg/m^3; 0 for flight without drag.
        viscosity: of the air, Pa s.

    Raises:
        ConfigError: (a ValueError) the timestep is outside (0, 2 ms], or the density or the viscosity is negative.
    """
    if not 0.0 < timestep <= LONGEST_STEP:
        raise ConfigError(f"timestep must be above 0 and at most {LONGEST_STEP} s, got {timestep}")
    if not (0.0 <= density < np.inf and 0.0 <= viscosity < np.inf):
        raise ConfigError(f"density and viscosity must be finite and not negative, got {density} and {viscosity}")
    option = spec.option
    option.timestep, option.density, option.viscosity = timestep, density, viscosity
    option.gravity = np.array([0.0, 0.0, -GRAVITY])
    option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    option.solver = mujoco.mjtSolver.mjSOL_NEWTON
    option.tolerance, option.iterations = 1e-10, 50
    option.cone, option.impratio = mujoco.mjtCone.mjCONE_ELLIPTIC, 10.0
    option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    option.enableflags = int(option.enableflags) | int(mujoco.mjtEnableBit.mjENBL_SPECULATIVE.value)
    option.disableflags = int(option.disableflags) | int(mujoco.mjtDisableBit.mjDSBL_AUTORESET.value)


def set_inertia(
    body: MjsBody, mass: float, centre: tuple[float, float, float], inertia: tuple[float, float, float]
) -> None:
    """Set mass [kg], centre of mass [m], and inertia about that centre along the body's axes [kg m2].

    The values are explicit because the drawn geoms have no mass.
    """
    body.explicitinertial = True
    body.mass, body.ipos, body.inertia = mass, np.array(centre), np.array(inertia)


def add_motor(spec: MjSpec, name: str, joint: str, torque: float, kp: float, kv: float) -> None:
    """Add a motor: a joint PD with torque feed-forward inside the engine, so that a rollout needs no Python controller.

    The motor takes three consecutive controls: angle, speed, feed-forward torque. The motor's torque is at most
    `torque` [N m] in both directions; its gains are in N m/rad and N m s/rad.
    """
    inputs = mujoco.mjtCtrlInput.mjINPUT_POS, mujoco.mjtCtrlInput.mjINPUT_VEL, mujoco.mjtCtrlInput.mjINPUT_FF
    motor = spec.add_actuator(
        name=name,
        trntype=mujoco.mjtTrn.mjTRN_JOINT,
        target=joint,
        forcelimited=mujoco.mjtLimited.mjLIMITED_TRUE,
        forcerange=[-torque, torque],
    )
    motor.set_to_pid(kp=kp, kv=kv, ctrlspec=sum(int(bit.value) for bit in inputs))


def add_arm(spec: MjSpec, name: str, pivot: Point, azimuth: float, armature: float, damping: float = 0.0) -> MjsBody:
    """Add an arm along x of its frame, on a hinge of the same name about -y: a positive angle lifts the arm."""
    half = azimuth / 2
    body = spec.worldbody.add_body(name=name, pos=pivot, quat=[np.cos(half), 0, 0, np.sin(half)])
    body.add_joint(name=name, axis=[0, -1, 0], armature=armature, damping=np.array([damping, 0.0, 0.0]))
    return body


def add_rod(arm: MjsBody, name: str, place: Point, length: float, mass: float, radius: float) -> MjsBody:
    """Hang a slender rod from an arm by a U joint, along -z of the rod's frame, with the site "NAME_end" at its end.

    Hinges "NAME_swing" about the motor axis, then "NAME_tilt" about x, never lock below 90 degrees. Only the inertia
    about the rod's own axis depends on the radius.
    """
    body = arm.add_body(name=name, pos=place)
    body.add_joint(name=f"{name}_swing", axis=[0, -1, 0])
    body.add_joint(name=f"{name}_tilt", axis=[1, 0, 0])
    across = mass * length**2 / 12.0
    set_inertia(body, mass, (0, 0, -length / 2.0), (across, across, mass * radius**2))
    add_site(body, f"{name}_end", (0, 0, -length))
    return body


def add_level_platform(spec: MjSpec) -> tuple[MjsBody, list[str]]:
    """Add the body "platform", which three slide joints keep level; return the body and the joints' names."""
    body, slides = spec.worldbody.add_body(name="platform"), [f"platform_{axis}" for axis in "xyz"]
    for name, axis in zip(slides, np.eye(3), strict=True):
        body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)
    return body, slides


def add_site(body: MjsBody, name: str, place: Point = (0.0, 0.0, 0.0)) -> None:
    """Add a named point in a body's frame [m], in a group that is not drawn."""
    body.add_site(name=name, pos=place, size=[0.003] * 3, group=4)


def join_sites(spec: MjSpec, name: str, first: str, second: str, softness: Mapping[str, Point] = LOOP) -> None:
    """Add an equality that holds two sites together.

    The equality joins sites, not bodies: a loop then does not depend on a closed pose at compile time.
    """
    kinds = {"type": mujoco.mjtEq.mjEQ_CONNECT, "objtype": mujoco.mjtObj.mjOBJ_SITE}
    spec.add_equality(name=name, name1=first, name2=second, **kinds, **softness)


def join_angles(spec: MjSpec, name: str, first: str, second: str, softness: Mapping[str, Point] = LOOP) -> None:
    """Add an equality that keeps two joints at the same angle."""
    kinds = {"type": mujoco.mjtEq.mjEQ_JOINT, "objtype": mujoco.mjtObj.mjOBJ_JOINT}
    spec.add_equality(name=name, name1=first, name2=second, data=np.eye(12)[1], **kinds, **softness)
