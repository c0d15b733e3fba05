"""Motions that keep the limits of a throw and maximise nothing, by the Gauss-Newton method.

Miyashita et al. solve Eqs. 29 to 32 in this way for their Fig. 7b. The unknowns are the control points and Delta t
of Eqs. 13 and 14. A limit is an equation while it is broken, so a motion that comes from outside ends on its limits.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from pnt_gym.arrays import Floats, Ints
from pnt_gym.planning.one_joint.grasp import braking_acceleration
from pnt_gym.planning.one_joint.motion import ArmMotion
from pnt_gym.planning.one_joint.parameters import Arm, Block
from pnt_gym.planning.one_joint.shapes import INTERVALS

from .programme import ForceCoefficients, Throw, limit_rows

ITERATIONS: Final = 200
NEAR: Final = 1e-8
"""Largest residual of a solution, as a share of a limit, or of the release's angle [rad] and speed."""
HALVINGS: Final = 12
"""Number of halvings of a step that does not lessen the residuals."""
SHORTEST: Final = 1e-4
"""Shortest Delta t on the way [s]."""
_CONTROLS: Final = INTERVALS + 3
_KNOTS: Final[Ints] = np.arange(INTERVALS + 1)[:, None] + np.arange(3)


def _at_knots(values: tuple[float, float, float]) -> Floats:
    """Matrix (n + 1, n + 3) that gives a derivative of the spline at the knots from its control points."""
    matrix = np.zeros((INTERVALS + 1, _CONTROLS))
    np.put_along_axis(matrix, _KNOTS, np.array([values]), axis=1)
    return matrix


# Uniform cubic B-splines at a knot, their slopes times Delta t, and their second derivatives times Delta t^2.
_ANGLE: Final = _at_knots((1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0))
_SPEED: Final = _at_knots((-0.5, 0.0, 0.5))
_RATE: Final = _at_knots((1.0, -2.0, 1.0))


class _Residuals(NamedTuple):
    """Equations and broken limits (R,), and their slopes (R, n + 4) by control points and Delta t."""

    values: Floats
    slopes: Floats


def random_unknowns(arm: Arm, generator: np.random.Generator) -> Floats:
    """A first guess (n + 4,): control points anywhere in the arm's range [rad], then Delta t up to its limit [s]."""
    low, high = (
        np.append(np.full(_CONTROLS, end), step) for end, step in zip(arm.angle, (0.0, arm.time_step), strict=True)
    )
    return np.maximum(low + (high - low) * generator.random(low.size), SHORTEST)


def careless_motion(throw: Throw, arm: Arm, block: Block, unknowns: Floats) -> ArmMotion | None:
    """Motion to a release by Gauss-Newton steps from a first guess; None where the steps lead to no motion.

    Args:
        throw: the release, which solves Eq. 29.
        arm: the arm, whose limits are kept at the knots (Eqs. 15 to 20 without margins).
        block: the block on the arm.
        unknowns: first guess (n + 4,): control points [rad] and Delta t [s].
    """
    forces = ForceCoefficients.of(throw.radius, arm, block)
    residuals = _residuals(unknowns, throw, arm, forces)
    for _ in range(ITERATIONS):
        if float(np.abs(residuals.values).max()) < NEAR:
            braking = braking_acceleration(np.array([throw.speed]), arm)
            return ArmMotion(unknowns[None, :-1], unknowns[-1:], braking)
        step = np.asarray(np.linalg.lstsq(residuals.slopes, -residuals.values)[0], dtype=np.float64)
        size = float(residuals.values @ residuals.values)
        for halving in range(HALVINGS):
            place = unknowns + 0.5**halving * step
            if place[-1] < SHORTEST:
                continue
            residuals = _residuals(place, throw, arm, forces)
            if residuals.values @ residuals.values < size:
                break
        else:
            return None
        unknowns = place
    return None


def _residuals(unknowns: Floats, throw: Throw, arm: Arm, forces: ForceCoefficients) -> _Residuals:
    controls, step = unknowns[:-1], float(unknowns[-1])
    angle, speed, rate = _ANGLE @ controls, _SPEED @ controls / step, _RATE @ controls / step**2
    by_angle, by_speed, by_rate = (
        np.column_stack(columns)
        for columns in (
            (_ANGLE, np.zeros_like(angle)),
            (_SPEED / step, -speed / step),
            (_RATE / step**2, -2.0 * rate / step),
        )
    )
    rows, partial = limit_rows(angle, speed, rate, forces, arm)
    slopes = partial[0][..., None] * by_angle + partial[1][..., None] * by_speed + partial[2][..., None] * by_rate
    broken = rows < 0.0
    # Eq. 22; only its upper end can be broken, as Delta t stays above SHORTEST.
    room = 1.0 - step / arm.time_step
    by_step = np.append(np.zeros(_CONTROLS), -1.0 / arm.time_step)
    return _Residuals(
        np.concatenate(
            [
                rows[broken],
                [min(room, 0.0)],
                [angle[-1] - throw.angle, speed[-1] / throw.speed - 1.0, speed[0] / throw.speed],
            ]
        ),
        np.concatenate(
            [
                slopes[broken],
                by_step[None] * (room < 0.0),
                [by_angle[-1], by_speed[-1] / throw.speed, by_speed[0] / throw.speed],
            ]
        ),
    )
