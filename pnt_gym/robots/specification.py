"""What the robots share in a MuJoCo model specification: options, inertias, motors and loops of closed chains."""

from __future__ import annotations

from typing import Final

import numpy as np

from pnt_gym.engine import MjsBody, MjSpec, mujoco
from pnt_gym.errors import ConfigError
from pnt_gym.planning.ballistics import GRAVITY

LOOP_SOLREF: Final = (0.002, 1.0)
"""Time constant (s) and damping ratio of the loops; MuJoCo's slower default opens them by 2.5 mm."""
LOOP_SOLIMP: Final = (0.99, 0.999, 0.001, 0.5, 2.0)
"""Impedance of the loops: nearly rigid from the first micrometre on."""
LONGEST_STEP: Final = 0.002
"""Up to here loops and motors are accurate, and the one-joint thrower releases no worse than it repeats [s]."""


def set_options(spec: MjSpec, timestep: float, density: float = 1.2, viscosity: float = 1.8e-5) -> None:
    """Set the physics options that all robots need.

    Explicit Euler is deliberate: implicit integrators apply the motors' damping after the constraints are solved and
    open the loops ten times wider. It is a leapfrog, too: velocities belong to the middle of the step before, which the
    one-joint thrower's references and release count on, and then it is of second order. The Jacobian is dense because
    MuJoCo 4.0.0 has a bug in its sparse Newton factor.

    Args:
        spec: a mujoco.MjSpec.
        timestep: physics step, s; 0.4 ms to evaluate (the T3KR's 2500 Hz), 1 ms to train, at most 2 ms.
        density: of the air, kg/m^3; 0 for free flight.
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
    """Explicit inertia: what the body looks like has no mass.

    Args:
        body: of a mujoco.MjSpec.
        mass: [kg]
        centre: of mass in the body's frame [m].
        inertia: about the centre along the body's axes [kg m2].
    """
    body.explicitinertial = True
    body.mass, body.ipos, body.inertia = mass, np.array(centre), np.array(inertia)


def add_motor(spec: MjSpec, name: str, joint: str, torque: float, kp: float, kv: float) -> None:
    """Joint PD with torque feed-forward inside the engine, so that a rollout needs no Python controller.

    The motor takes three consecutive controls: angle, speed, feed-forward torque.

    Args:
        spec: a mujoco.MjSpec.
        name: of the actuator.
        joint: that it turns.
        torque: largest, either way [N m].
        kp: [N m/rad]
        kv: [N m s/rad]
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


def close_loop(spec: MjSpec, name: str, end: str, attach: str) -> None:
    """Hold two sites together.

    Sites, not bodies: the loop then does not depend on a closed pose at compile time.
    """
    spec.add_equality(
        name=name,
        type=mujoco.mjtEq.mjEQ_CONNECT,
        objtype=mujoco.mjtObj.mjOBJ_SITE,
        name1=end,
        name2=attach,
        solref=LOOP_SOLREF,
        solimp=LOOP_SOLIMP,
    )
