"""Minimum-time motion under norm limits as a nonlinear programme: legs of piecewise constant jerk, joined in a row.

Each leg is K equal intervals of constant jerk whose common length is free. Speeds are bounded at the control points of
every interval, not only at its ends. A quadratic stays within the hull of its three Bernstein coefficients and a cubic
within the hull of its four, so the bounds hold at all times and not just at the nodes. Acceleration is linear and jerk
constant in an interval, so bounds at the interval's ends are enough.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Final, TypeAlias, final

import numpy as np

from papers.choe.planning.casadi_module import QUIET, load_casadi
from pnt_gym.arrays import Floats, length
from pnt_gym.planning.motion.limits import EllipticWorkspace
from pnt_gym.planning.motion.rows import Segments

SHORTEST: Final = 1e-3
LONGEST: Final = 30.0
"""Bounds of a leg's duration [s], never active at a solution."""

Numbers: TypeAlias = tuple[float, float, float]


@final
@dataclass(frozen=True)
class Leg:
    """Unknowns of one leg: duration, and states at K + 1 nodes as (3, K + 1) matrices in SI units."""

    duration: Any
    step: Any
    position: Any
    velocity: Any
    acceleration: Any
    jerk: Any
    vertical: bool

    @property
    def axes(self) -> slice:
        """Axes whose motion is unknown: z alone in a vertical leg."""
        return slice(2, 3) if self.vertical else slice(0, 3)

    def control_points(self, axis: int) -> Any:
        """Inner Bernstein coefficients (1, 2 K) of one coordinate of the position, which bound that coordinate."""
        ca, p, v = load_casadi(), self.position[axis, :], self.velocity[axis, :]
        # The inner Bernstein coefficients of a cubic lie a third of the interval along the tangents at both ends.
        return ca.horzcat(p[:, :-1] + self.step * v[:, :-1] / 3.0, p[:, 1:] - self.step * v[:, 1:] / 3.0)

    def values(self, solution: Any) -> Segments:
        """The leg as one row of segments."""
        jerk = np.asarray(solution.value(self.jerk), dtype=np.float64)
        count = jerk.shape[1]
        duration = float(solution.value(self.duration))
        return Segments(np.full((1, count), duration / count), np.ascontiguousarray(jerk.T)[None])


def add_leg(opti: Any, intervals: int, limits: Numbers, *, line: tuple[float, float] | None = None) -> Leg:
    """Add a leg to the programme: its unknowns, its motion, and the norm limits.

    Args:
        opti: the programme (casadi.Opti).
        intervals: K.
        limits: speed [m/s], acceleration [m/s2] and jerk [m/s3].
        line: x and y of a vertical leg [m]; None for a leg in space.
    """
    ca = load_casadi()
    duration = opti.variable()
    step = duration / intervals
    axes = 3 if line is None else 1
    # The solver's unknowns are of the order of one; velocity, acceleration and jerk in SI units are multiples.
    p = opti.variable(axes, intervals + 1)
    v = limits[0] * opti.variable(axes, intervals + 1)
    a = limits[1] * opti.variable(axes, intervals + 1)
    j = limits[2] * opti.variable(axes, intervals)
    opti.subject_to(opti.bounded(SHORTEST, duration, LONGEST))
    # The states at the nodes integrate the constant jerk exactly, so the nodes add no error of discretization.
    opti.subject_to(ca.vec(a[:, 1:] - a[:, :-1] - step * j) / limits[1] == 0)
    opti.subject_to(ca.vec(v[:, 1:] - v[:, :-1] - step * (a[:, :-1] + step * j / 2.0)) / limits[0] == 0)
    cubic = a[:, :-1] / 2.0 + step * j / 6.0
    opti.subject_to(ca.vec(p[:, 1:] - p[:, :-1] - step * (v[:, :-1] + step * cubic)) == 0)
    # The velocity is quadratic in an interval; this is the coefficient between those at the two nodes.
    middle = v[:, :-1] + step * a[:, :-1] / 2.0
    for vectors, bound in ((v, limits[0]), (middle, limits[0]), (a, limits[1]), (j, limits[2])):
        opti.subject_to(ca.vec(ca.sum1((vectors / bound) ** 2)) <= 1.0)
    if line is None:
        return Leg(duration, step, p, v, a, j, vertical=False)
    still, place = ca.DM.zeros(2, intervals + 1), ca.repmat(ca.DM(line), 1, intervals + 1)
    return Leg(
        duration,
        step,
        ca.vertcat(place, p),
        ca.vertcat(still, v),
        ca.vertcat(still, a),
        ca.vertcat(still[:, 1:], j),
        vertical=True,
    )


def set_guess(opti: Any, leg: Leg, duration: float, position: Floats, limits: Numbers) -> None:
    """Start the solver at a path: velocities, accelerations and jerks by differences, shortened to the limits.

    The path has a duration [s] and positions (K + 1, 3) [m] at the nodes.
    """
    step = duration / (len(position) - 1)
    velocity = _shorten(np.gradient(position, step, axis=0), limits[0])
    acceleration = _shorten(np.gradient(velocity, step, axis=0), limits[1])
    jerk = _shorten(np.diff(acceleration, axis=0) / step, limits[2])
    opti.set_initial(leg.duration, duration)
    for unknown, value in (
        (leg.position, position),
        (leg.velocity, velocity),
        (leg.acceleration, acceleration),
        (leg.jerk, jerk),
    ):
        opti.set_initial(unknown[leg.axes, :], value.T[leg.axes])


def join(opti: Any, first: Leg, second: Leg) -> None:
    """Let the second leg begin with the position, velocity and acceleration at the end of the first leg."""
    for name in ("position", "velocity", "acceleration"):
        opti.subject_to(getattr(first, name)[:, -1] == getattr(second, name)[:, 0])


def add_rest(opti: Any, leg: Leg, node: int) -> None:
    """Let a leg have no velocity and no acceleration at one of its nodes."""
    opti.subject_to(leg.velocity[leg.axes, node] == 0)
    opti.subject_to(leg.acceleration[leg.axes, node] == 0)


def keep_inside(opti: Any, leg: Leg, workspace: EllipticWorkspace) -> None:
    """Keep the control points of a leg, and with them the leg, inside the convex workspace."""
    x, y, z = (leg.control_points(axis).T for axis in range(3))
    opti.subject_to((x / workspace.semi_x) ** 2 + (y / workspace.semi_y) ** 2 <= 1.0)
    if np.isfinite(workspace.z_min):
        opti.subject_to(z >= workspace.z_min)
    if np.isfinite(workspace.z_max):
        opti.subject_to(z <= workspace.z_max)


def solve(opti: Any, legs: Iterable[Leg], iterations: int) -> Any | None:
    """Minimise the time of all legs: the solution, or None where the solver finds no solution.

    Unknowns are of the order of one. A solve whose unknowns diverge, or that takes far longer than any solve that
    succeeds, is given up.
    """
    opti.minimize(sum(leg.duration for leg in legs))
    limits = {"ipopt.max_iter": iterations, "ipopt.diverging_iterates_tol": 1e3, "ipopt.max_cpu_time": 20.0}
    opti.solver("ipopt", {**QUIET, **limits})
    try:
        return opti.solve()
    except RuntimeError:
        return None


def hermite(
    first: Floats, velocity: Floats, last: Floats, last_velocity: Floats, duration: float, intervals: int
) -> Floats:
    """Positions (K + 1, 3) of the cubic with the given ends and end velocities."""
    s = np.linspace(0.0, 1.0, intervals + 1)[:, None]
    # Hermite basis: h01 blends the positions, h10 and h11 carry the velocities at the ends.
    blend = s * s * (3.0 - 2.0 * s)
    bend = s * (1.0 - s) ** 2 * velocity - s * s * (1.0 - s) * last_velocity
    return first + blend * (last - first) + duration * bend


def _shorten(vectors: Floats, bound: float) -> Floats:
    """Vectors (M, 3) shortened to nine tenths of a bound, so that the solver starts inside the bound."""
    return vectors * np.minimum(1.0, 0.9 * bound / np.maximum(length(vectors), 1e-12))[:, None]
