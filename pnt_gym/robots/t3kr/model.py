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
from pnt_gym.robots.t3kr.geometry import GRAVITY, N_ARMS, T3KR, T3krGeometry
from pnt_gym.robots.t3kr.visuals import dress_arm, dress_base, dress_platform, dress_rod

Rods = Literal["four", "eight"]

LOOP_SOLREF = (0.002, 1.0)
"""Time constant (s) and damping ratio of the loops; MuJoCo's slower default opens them by 2.5 mm."""
LOOP_SOLIMP = (0.99, 0.999, 0.001, 0.5, 2.0)
"""Impedance of the loops: nearly rigid from the first micrometre on."""

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
    motors = tuple(_add_motor(spec, geometry, arm) for arm in range(N_ARMS))
    return T3krHandles(rods, geometry, tuple(joints), tuple(f"arm_{arm}" for arm in range(N_ARMS)), motors, loops)


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
    _set_inertia(body, geometry.arm_mass, (geometry.arm_com, 0, 0), inertia)
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
    _set_inertia(body, mass, (0, 0, -length / 2), (across, across, mass * _ROD_RADIUS**2))
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
    _set_inertia(body, geometry.platform_mass, (0, 0, geometry.attach_height), _PLATFORM_INERTIA)
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
        # Sites, not bodies: the loop then does not depend on a closed pose at compile time.
        spec.add_equality(
            name=names[-1],
            type=mujoco.mjtEq.mjEQ_CONNECT,
            objtype=mujoco.mjtObj.mjOBJ_SITE,
            name1=f"{rod}_end",
            name2=f"{rod}_attach",
            solref=LOOP_SOLREF,
            solimp=LOOP_SOLIMP,
        )
    return tuple(names)


def _add_motor(spec: MjSpec, geometry: T3krGeometry, arm: int) -> str:
    """Joint PD with torque feed-forward inside the engine, so that a rollout needs no Python controller."""
    inputs = mujoco.mjtCtrlInput.mjINPUT_POS, mujoco.mjtCtrlInput.mjINPUT_VEL, mujoco.mjtCtrlInput.mjINPUT_FF
    motor = spec.add_actuator(
        name=f"motor_{arm}",
        trntype=mujoco.mjtTrn.mjTRN_JOINT,
        target=f"arm_{arm}",
        forcelimited=mujoco.mjtLimited.mjLIMITED_TRUE,
        forcerange=[-geometry.torque_limit, geometry.torque_limit],
    )
    motor.set_to_pid(kp=geometry.kp, kv=geometry.kv, ctrlspec=sum(int(bit.value) for bit in inputs))
    return f"motor_{arm}"


def _set_inertia(
    body: MjsBody, mass: float, centre: tuple[float, float, float], inertia: tuple[float, float, float]
) -> None:
    """Explicit inertia: what the body looks like has no mass."""
    body.explicitinertial = True
    body.mass, body.ipos, body.inertia = mass, np.array(centre), np.array(inertia)


def set_options(spec: MjSpec, timestep: float, density: float = 1.2, viscosity: float = 1.8e-5) -> None:
    """Set the physics options that this closed chain needs.

    Explicit Euler is deliberate: implicit integrators apply the motors' damping after the constraints are
    solved and open the loops ten times wider. The Jacobian is dense because MuJoCo 4.0.0 has a bug in its
    sparse Newton factor.

    Args:
        spec: a mujoco.MjSpec.
        timestep: physics step, s; 0.4 ms to evaluate (the robot's 2500 Hz), 1 ms to train, at most 2 ms.
        density: of the air, kg/m^3; 0 for free flight.
        viscosity: of the air, Pa s.

    Raises:
        ConfigError: (a ValueError) the timestep is outside (0, 2 ms], where loops and motors are accurate, or
            the density or the viscosity is negative.
    """
    if not 0.0 < timestep <= 0.002:
        raise ConfigError(f"timestep must be above 0 and at most 0.002 s, got {timestep}")
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
