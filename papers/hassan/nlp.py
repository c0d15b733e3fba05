"""The two methods of Hassan et al. 2022 for the optimal release, to check and to time the exact solver.

Method 1 (section III-D) is a nonlinear programme in speed, acceleration and release point. Method 2 (section III-E)
minimises the release distance over the elevation. Both methods are local solvers: with a ceiling, Method 1 can stop at
a wrong optimum and still report success, and Method 2 has no ceiling.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias, cast, final

import numpy as np
from scipy.optimize import brentq, minimize

from pnt_gym.arrays import Floats, Point, of_kind
from pnt_gym.constants import GRAVITY
from pnt_gym.errors import PlanningError
from pnt_gym.planning.motion.limits import MotionLimits
from pnt_gym.planning.straight.frame import point_of
from pnt_gym.planning.straight.release import check_bounds

Solver: TypeAlias = Literal["SLSQP", "trust-constr"]
OPTIONS: Final[dict[Solver, dict[str, float]]] = {
    "SLSQP": {"ftol": 1e-10, "maxiter": 300},
    "trust-constr": {"maxiter": 3000, "gtol": 1e-10, "xtol": 1e-12},
}
"""Tolerances and iteration limits of the solvers."""
FEASIBILITY: Final = 1e-6
"""Largest violation of a constraint, in units of its scale, at which an answer still counts as a solution."""


@final
@dataclass(frozen=True, eq=False)
class NlpRelease:
    """Answer of a nonlinear solver for one throw.

    Attributes:
        success: whether the solver reports success and all constraints hold at its answer.
        position: release point (3,) [m].
        speed: release speed [m/s].
        distance: way from the pick to the release [m].
        time: time from the pick to the release [s] (Eq. 12).
        violation: largest violation of a constraint, scaled by the limits and the reach.
    """

    success: bool
    position: Floats
    speed: float
    distance: float
    time: float
    violation: float


@final
class _Problem:
    """A throw in variables scaled to the order of one: V / Vmax, A / Amax, (P_r - P_0) / X.

    The programme differs from the printed form in three points. The bounds of x and y take the pick and the target in
    either order. The argument of the square root of Eq. 18 is constrained. With no tolerance the landing is one
    equation along the throw.
    """

    def __init__(
        self, pick: Point, target: Point, limits: MotionLimits, ceiling: float | None = None, tolerance: float = 0.0
    ) -> None:
        self.pick = np.array(point_of(pick, "pick"))
        self.vector = np.array(point_of(target, "target")) - self.pick
        self.velocity, self.acceleration, self.jerk = of_kind(limits, MotionLimits, "limits").numbers()
        check_bounds(ceiling, tolerance)
        self.reach = math.hypot(self.vector[0], self.vector[1])
        if self.reach == 0.0:
            raise PlanningError("the target lies straight above or below the pick: there is no direction to throw in")
        self.tolerance = tolerance
        self.roof = math.inf if ceiling is None else (ceiling - self.pick[2]) / self.reach

    def bounds(self) -> list[tuple[float, float]]:
        """Lower and upper bound of each variable."""
        sides = [(min(way, 0.0), max(way, 0.0)) for way in (self.vector[:2] / self.reach).tolist()]
        return [(1e-6, 1.0), (1e-6, 1.0), *sides, (0.0, self.roof)]

    def guess(self, share: float, elevation: float) -> Floats:
        """First guess: a release at ``share`` of the way to the target and ``elevation`` [rad], near the limits."""
        flat = share * self.vector[:2] / self.reach
        return np.array([0.9, 0.9, flat[0], flat[1], min(share * math.tan(elevation), self.roof)])

    def time(self, x: Floats) -> float:
        """Release time t_r [s] (Eq. 12)."""
        speed, peak = x[0] * self.velocity, x[1] * self.acceleration
        return float(0.5 * (2.0 * self.distance(x) / speed + speed / peak + peak / self.jerk))

    def distance(self, x: Floats) -> float:
        """Release distance P_r [m], differentiable at 0."""
        return self.reach * math.sqrt(float(x[2] ** 2 + x[3] ** 2 + x[4] ** 2) + 1e-18)

    def inequalities(self, x: Floats) -> Floats:
        """Values that must not be negative: Eqs. 14, 15, the root's argument in Eq. 18, with tolerance Eqs. 16, 17."""
        speed, peak = x[0] * self.velocity, x[1] * self.acceleration
        plateau = speed / peak - peak / self.jerk
        cruise = 2.0 * self.distance(x) / speed - speed / peak - peak / self.jerk
        unit = self.velocity / self.acceleration
        values = [plateau / unit, cruise / unit, self._root_argument(x)]
        if self.tolerance > 0.0:
            miss = self._miss(x)
            values += [*(self.tolerance - miss) / self.reach, *(self.tolerance + miss) / self.reach]
        return np.array(values)

    def equalities(self, x: Floats) -> Floats:
        """Values that must be zero: the release point's distance from the throw's plane, with no tolerance the miss."""
        side = (x[3] * self.vector[0] - x[2] * self.vector[1]) / self.reach
        if self.tolerance > 0.0:
            return np.array([side])
        along = self._miss(x) @ self.vector[:2] / self.reach**2
        return np.array([side, along])

    def violation(self, x: Floats) -> float:
        """Largest violation of a constraint or a bound, scaled."""
        sides = np.array(self.bounds())
        worst = [np.abs(self.equalities(x)).max(), -self.inequalities(x).min()]
        return float(max(0.0, *worst, (sides[:, 0] - x).max(), (x - sides[:, 1]).max()))

    def answer(self, x: Floats, *, solved: bool) -> NlpRelease:
        """The solver's answer, a success only if every constraint holds."""
        violation = self.violation(x)
        return NlpRelease(
            success=solved and violation <= FEASIBILITY,
            position=self.pick + self.reach * x[2:],
            speed=float(x[0] * self.velocity),
            distance=self.distance(x),
            time=self.time(x),
            violation=violation,
        )

    def _rise_speed(self, x: Floats) -> float:
        """Vertical component of the release velocity [m/s]."""
        return float(x[0] * self.velocity * x[4] * self.reach / self.distance(x))

    def _root_argument(self, x: Floats) -> float:
        """Argument of the square root in Eq. 18: (V sin / g)^2 + 2 (z - Z_f) / g [s2]."""
        drop = x[4] * self.reach - self.vector[2]
        return float((self._rise_speed(x) / GRAVITY) ** 2 + 2.0 * drop / GRAVITY)

    def _miss(self, x: Floats) -> Floats:
        """Landing point less target in x and y (2,) [m], with the flight time of Eq. 18."""
        flight = self._rise_speed(x) / GRAVITY + math.sqrt(max(self._root_argument(x), 0.0))
        run = x[0] * self.velocity * flight / self.distance(x)
        return self.reach * x[2:4] * (1.0 + run) - self.vector[:2]


def method_1(
    pick: Point,
    target: Point,
    limits: MotionLimits,
    *,
    ceiling: float | None = None,
    tolerance: float = 0.0,
    solver: Solver = "SLSQP",
    start: tuple[float, float] = (0.4, 0.5),
) -> NlpRelease:
    """Solve the five-variable nonlinear programme (Hassan et al. 2022, Eqs. 13-18).

    Args:
        pick: start of the hand (3,) [m].
        target: point to hit (3,) [m].
        limits: one set of limits.
        ceiling: greatest height of the release point [m], None for no bound.
        tolerance: delta of Eqs. 16 and 17 [m].
        solver: method of `scipy.optimize.minimize`.
        start: share of the way to the target and elevation [rad] of the first guess.

    Raises:
        ValueError: if an input is not finite or the target lies straight above or below the pick.
    """
    problem = _Problem(pick, target, limits, ceiling, tolerance)
    first = problem.guess(*start)
    unit = problem.time(first)
    solution = minimize(
        lambda x: problem.time(x) / unit,
        first,
        method=solver,
        bounds=problem.bounds(),
        constraints=[{"type": "ineq", "fun": problem.inequalities}, {"type": "eq", "fun": problem.equalities}],
        options=OPTIONS[solver],
    )
    return problem.answer(np.asarray(solution.x, dtype=np.float64), solved=bool(solution.success))


def method_2(pick: Point, target: Point, limits: MotionLimits) -> NlpRelease:
    """Minimise the release distance over the elevation, at a fixed speed (Eq. 21) or on the S-curve (Eq. 22).

    The method has no ceiling, no workspace and no tolerance.

    Raises:
        ValueError: if an input is not finite or the target lies straight above or below the pick.
    """
    problem = _Problem(pick, target, limits)
    velocity, acceleration, jerk = problem.velocity, problem.acceleration, problem.jerk
    knee = min(acceleration * acceleration / jerk, velocity)
    theta, distance = _least_distance(problem, velocity)
    if distance >= _acceleration_distance(velocity, acceleration, jerk):
        return problem.answer(_variables(problem, theta, distance, velocity), solved=True)
    if knee < velocity:
        theta, distance = _least_distance(problem, knee)
        if distance > _acceleration_distance(knee, acceleration, jerk):
            return _solve_on_curve(problem, theta, (knee, velocity))
    return _solve_on_curve(problem, theta, (0.0, knee))


def _flight_line(problem: _Problem, theta: float) -> tuple[float, float]:
    """Length [m] of the line at elevation ``theta`` to above the target, and time [s] to fall from there (Eq. 20)."""
    drop = max(problem.reach * math.tan(theta) - problem.vector[2], 0.0)
    return problem.reach / math.cos(theta), math.sqrt(2.0 * drop / GRAVITY)


def _least_distance(problem: _Problem, speed: float) -> tuple[float, float]:
    """Elevation [rad] and value [m] of the least release distance at a fixed speed, from dP/dtheta = 0 (Eq. 21)."""

    def slope(theta: float) -> float:
        # dP/dtheta times cos^2 / X: sin(theta) - V / (g t_f).
        return math.sin(theta) * _flight_line(problem, theta)[1] - speed / GRAVITY

    low = max(math.atan2(problem.vector[2], problem.reach), 0.0)
    theta = cast(float, brentq(slope, low, 0.5 * math.pi - 1e-9, xtol=1e-14))
    length, flight = _flight_line(problem, theta)
    return theta, length - speed * flight


def _acceleration_distance(speed: float, acceleration: float, jerk: float) -> float:
    """Distance [m] from rest to ``speed``: the S-curve's V(P) of section II-C solved for P."""
    if jerk * speed <= acceleration * acceleration:
        return math.sqrt(speed**3 / jerk)
    return (jerk * speed**2 + speed * acceleration**2) / (2.0 * jerk * acceleration)


def _solve_on_curve(problem: _Problem, theta: float, speeds: tuple[float, float]) -> NlpRelease:
    """Eq. 22 in speed and elevation: the least release distance on one segment of the S-curve that hits the target."""
    velocity, acceleration, jerk, reach = problem.velocity, problem.acceleration, problem.jerk, problem.reach

    def way(x: Floats) -> float:
        return _acceleration_distance(max(float(x[0]), 0.0) * velocity, acceleration, jerk) / reach

    def hit(x: Floats) -> float:
        length, flight = _flight_line(problem, float(x[1]))
        return (way(x) * reach + x[0] * velocity * flight - length) / reach

    low = max(math.atan2(problem.vector[2], reach), 0.0)
    length, flight = _flight_line(problem, theta)
    first = np.array([min(max(length / (flight * velocity), speeds[0] / velocity), speeds[1] / velocity), theta])
    bounds = [(speeds[0] / velocity, speeds[1] / velocity), (low, 0.5 * math.pi - 1e-6)]
    constraints = [{"type": "eq", "fun": hit}]
    options = {"ftol": 1e-11, "maxiter": 300}
    solution = minimize(way, first, method="SLSQP", bounds=bounds, constraints=constraints, options=options)
    solved = bool(solution.success) and abs(hit(solution.x)) <= FEASIBILITY
    speed, theta = float(solution.x[0]) * velocity, float(solution.x[1])
    return problem.answer(_variables(problem, theta, reach * way(solution.x), speed), solved=solved)


def _variables(problem: _Problem, theta: float, distance: float, speed: float) -> Floats:
    """The variables of method 1 at a release of method 2, with the least acceleration that reaches the speed."""
    peak = min(math.sqrt(problem.jerk * speed), problem.acceleration)
    flat = problem.vector[:2] / problem.reach * math.cos(theta)
    way = distance / problem.reach * np.array([*flat, math.sin(theta)])
    return np.array([speed / problem.velocity, peak / problem.acceleration, *way])
