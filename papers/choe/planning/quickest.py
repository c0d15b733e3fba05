"""The quickest motion along one smooth run of a path, as a nonlinear programme for IPOPT.

A run is a part of a path that the hand passes without a stop. The run is cut at fixed arc lengths. Unknown are speed
and acceleration along the path at the cuts, and the time and jerk of each interval, within which the third derivative
s''' of the arc length is constant. The programme reads the geometry as numbers: the curvature and its derivative on
either side of each cut, with a cubic between them.

With T along the path, N across it and k the curvature, the hand has the velocity s' T, the acceleration
s'' T + k s'^2 N and the jerk (s''' - k^2 s'^3) T + (3 k s' s'' + k' s'^3) N.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from pnt_gym.arrays import Floats, Ints
from pnt_gym.errors import PntGymError
from pnt_gym.planning.motion.limits import MotionLimits

from .casadi_module import load_casadi
from .curves import CurvePoints
from .plane import PlanePath

# Intervals of the first solution, which only places the cuts of the second; the next number is tried where IPOPT fails.
ROUGH = (60, 90, 45)
# The second solution starts this much slower than the first, inside the limits.
SLOWER = 1.05
# A joint replaces the cuts that are nearer to the joint than this share of an interval.
NEAR = 0.4
# Weight of a run's whole turn in the measure that spaces the cuts; the run's whole duration weighs 1.
TURN_WEIGHT = 0.5
# Places in each interval where the programme bounds the limits, as shares of the interval's time.
SHARES = (0.0, 0.5, 1.0)
# Each interval's time stays within this factor of its first guess; without that bound IPOPT can get stuck near a rest.
TIME_FACTOR = 20.0
# Factor by which the curvature between two cuts may exceed the curvature at the cuts.
BEND_ROOM = 1.5
# Samples of the first guess.
PLACES = 2000
# Share of the limits that the first guess uses.
SHARE = 0.6
# Window of the moving average as a share of the whole duration; three averages in a row make the jerk continuous.
WINDOW = 0.07


class Progress(NamedTuple):
    """Motion along a run: K intervals of constant third derivative of the arc length.

    Attributes:
        s: arc length at the borders (K + 1,) [m].
        speed: (K + 1,) [m/s].
        acceleration: along the path (K + 1,) [m/s2].
        durations: (K,) [s].
        jerks: third derivatives of s (K,) [m/s3].
        pieces: piece of the path in which each interval lies (K,).
    """

    s: Floats
    speed: Floats
    acceleration: Floats
    durations: Floats
    jerks: Floats
    pieces: Ints

    def course(self, shares: Floats) -> Course:
        """The motion (K M,) at ``shares`` (M,) of each interval, interval after interval."""
        begin = np.concatenate([[0.0], np.cumsum(self.durations)[:-1]])
        t = self.durations[:, None] * shares
        s0, v0, a0, jerk = self.s[:-1, None], self.speed[:-1, None], self.acceleration[:-1, None], self.jerks[:, None]
        way = s0 + t * (v0 + t * (0.5 * a0 + t * jerk / 6.0))
        columns = begin[:, None] + t, way, v0 + t * (a0 + 0.5 * t * jerk), a0 + t * jerk
        return Course(*(column.ravel() for column in columns))


def quickest_progress(path: PlanePath, run: tuple[int, int], limits: MotionLimits, intervals: int) -> Progress:
    """Return the quickest motion from rest to rest through the pieces ``run[0]`` to ``run[1] - 1``.

    Raises:
        PntGymError: if CasADi is missing or IPOPT finds no solution.
    """
    start = careful_course(path, run, limits)
    reason = ""
    for count in ROUGH:
        rough, reason = _solve(path, _cut(path, run, start, count), limits)
        if reason:
            continue
        course = rough.course(np.linspace(0.0, 1.0, 65)).slower(SLOWER)
        progress, reason = _solve(path, _cut(path, run, course, intervals), limits)
        if not reason:
            return progress
    raise PntGymError(f"IPOPT found no timing for a path of {path.length:.3f} m: {reason}")


def _cut(path: PlanePath, run: tuple[int, int], course: Course, count: int) -> Progress:
    """``course`` cut into about ``count`` intervals, as a first guess for IPOPT.

    The cuts lie at the joints and at even steps of a measure that counts time and, where the path is bent, the turn.
    """
    borders = path.borders[run[0] : run[1] + 1]
    bend = np.abs(run_points(path, run, course.s).curvature)
    turn = np.concatenate([[0.0], np.cumsum(0.5 * (bend[1:] + bend[:-1]) * np.diff(course.s))])
    measure = course.time / course.time[-1] + TURN_WEIGHT * turn / max(float(turn[-1]), 1.0)
    even = np.interp(np.linspace(0.0, float(measure[-1]), count + 1)[1:-1], measure, course.s)
    clear = np.abs(even[:, None] - borders).min(axis=1) > NEAR * np.gradient(even)
    s = np.sort(np.concatenate([borders, even[clear]]))
    pieces = run[0] + np.searchsorted(borders, 0.5 * (s[1:] + s[:-1]), side="right").astype(np.int64) - 1
    durations = np.diff(np.interp(s, course.s, course.time))
    acceleration = np.interp(s, course.s, course.acceleration)
    return Progress(
        s, np.interp(s, course.s, course.speed), acceleration, durations, np.diff(acceleration) / durations, pieces
    )


def _solve(path: PlanePath, guess: Progress, limits: MotionLimits) -> tuple[Progress, str]:
    """The quickest motion on the cuts of ``guess``, and IPOPT's reason if the solve failed ("" if not)."""
    ca = load_casadi()
    count = guess.jerks.size
    # Units of the run's length and the guess's duration.
    way, time = float(guess.s[-1] - guess.s[0]), float(guess.durations.sum())
    units = way / time ** np.array([1.0, 2.0, 3.0])
    maxima = np.array(limits.numbers()) / units
    v, a = ca.SX.sym("v", count + 1), ca.SX.sym("a", count + 1)
    j, dt = ca.SX.sym("j", count), ca.SX.sym("dt", count)
    equal, below = _step_equations(guess, way, (v, a, j, dt)), _limit_shares(path, guess, way, (v, a, j, dt), maxima)
    low, high = _bounds(path, guess, way, maxima)
    start = np.concatenate([guess.speed / units[0], guess.acceleration / units[1], guess.jerks / units[2]])
    options = {"print_time": False, "ipopt": {"print_level": 0, "sb": "yes", "tol": 1e-8, "max_iter": 500}}
    problem = {"x": ca.vertcat(v, a, j, dt), "f": ca.sum1(dt), "g": ca.vertcat(equal, below)}
    solver = ca.nlpsol("timing", "ipopt", problem, options)
    zeros = np.zeros(equal.numel())
    solution = solver(
        x0=np.clip(np.concatenate([start, guess.durations / time]), low, high),
        lbx=low,
        ubx=high,
        lbg=np.concatenate([zeros, np.full(below.numel(), -np.inf)]),
        ubg=np.concatenate([zeros, np.ones(below.numel())]),
    )
    state = solver.stats()
    x = np.asarray(solution["x"], dtype=np.float64).ravel()
    speed, rise, jerk, durations = np.split(x, [count + 1, 2 * count + 2, 3 * count + 2])
    motion = Progress(guess.s, speed * units[0], rise * units[1], durations * time, jerk * units[2], guess.pieces)
    return motion, "" if state["success"] else str(state["return_status"])


def _interval_travel(v: Any, a: Any, j: Any, t: Any) -> Any:
    """Arc length passed in each interval after the times ``t``."""
    return t * (v[:-1] + t * (0.5 * a[:-1] + t * j / 6.0))


def _step_equations(cuts: Progress, way: float, unknown: tuple[Any, ...]) -> Any:
    """Residuals of position, speed and acceleration between neighbouring intervals, zero for a continuous motion."""
    v, a, j, dt = unknown
    step = np.diff(cuts.s) / way
    return load_casadi().vertcat(
        (_interval_travel(v, a, j, dt) - step) / step.mean(),
        v[1:] - v[:-1] - dt * (a[:-1] + 0.5 * dt * j),
        a[1:] - a[:-1] - dt * j,
    )


def _bounds(path: PlanePath, cuts: Progress, way: float, maxima: Floats) -> tuple[Floats, Floats]:
    """Bounds of speed, acceleration, jerk and time; the run starts and ends at rest."""
    v_max, a_max, j_max = maxima
    ends = (path.at(cuts.s[:-1], cuts.pieces), path.at(cuts.s[1:], cuts.pieces))
    bend = way * np.maximum(*(np.abs(points.curvature) for points in ends))
    # From |s''' - k^2 s'^3| <= J and k s'^2 <= A.
    jerk = j_max + np.sqrt(BEND_ROOM * bend * a_max**3)
    moving = np.ones(cuts.s.size)
    moving[[0, -1]] = 0.0
    guess = cuts.durations / cuts.durations.sum()
    low = np.concatenate([0.0 * moving, -a_max * moving, -jerk, guess / TIME_FACTOR])
    high = np.concatenate([v_max * moving, a_max * moving, jerk, guess * TIME_FACTOR])
    return low, high


def _limit_shares(path: PlanePath, cuts: Progress, way: float, unknown: tuple[Any, ...], maxima: Floats) -> Any:
    """Squares of speed, acceleration and jerk as shares of the limits, at several places of each interval."""
    v, a, j, dt = unknown
    v_max, a_max, j_max = maxima
    step = np.diff(cuts.s) / way
    ends = [path.at(s, cuts.pieces) for s in (cuts.s[:-1], cuts.s[1:])]
    rows: list[Any] = []
    for share in SHARES:
        t = share * dt
        along = _interval_travel(v, a, j, t) / step if 0.0 < share < 1.0 else share
        bend, slope = _cubic([(p.curvature * way, p.slope * way**2) for p in ends], step, along)
        speed, rise = v[:-1] + t * (a[:-1] + 0.5 * t * j), a[:-1] + t * j
        # Across the path: acceleration kappa v^2, and jerk 3 kappa v a + kappa' v^3; along it the jerk loses kappa^2
        # v^3.
        cross = bend * speed**2
        aside = speed * (3.0 * bend * rise + slope * speed**2)
        rows.append((speed / v_max) ** 2)
        rows.append((rise**2 + cross**2) / a_max**2)
        rows.append(((j - bend * cross * speed) ** 2 + aside**2) / j_max**2)
    return load_casadi().vertcat(*rows)


def _cubic(ends: list[tuple[Floats, Floats]], step: Floats, x: Any) -> tuple[Any, Any]:
    """Curvature and its derivative at the share ``x`` of each step, by a cubic Hermite polynomial of both ends."""
    (k0, d0), (k1, d1) = ends
    rise = k1 - k0
    # k0 + step d0 x + c2 x^2 + c3 x^3.
    c2, c3 = 3.0 * rise - step * (2.0 * d0 + d1), step * (d0 + d1) - 2.0 * rise
    return k0 + x * (step * d0 + x * (c2 + x * c3)), d0 + x * (2.0 * c2 + 3.0 * x * c3) / step


class Course(NamedTuple):
    """A motion along a run at many moments: time, arc length, speed and acceleration along the path, each (M,)."""

    time: Floats
    s: Floats
    speed: Floats
    acceleration: Floats

    def slower(self, factor: float) -> Course:
        """The same motion slowed down to ``factor`` times its time."""
        return Course(factor * self.time, self.s, self.speed / factor, self.acceleration / factor**2)


def run_points(path: PlanePath, run: tuple[int, int], s: Floats) -> CurvePoints:
    """Points at ``s`` (M,), read from the pieces ``run[0]`` to ``run[1] - 1``."""
    return path.at(s, np.clip(path.piece_at(s), run[0], run[1] - 1))


def careful_course(path: PlanePath, run: tuple[int, int], limits: MotionLimits) -> Course:
    """Return a motion from rest to rest within all limits, slow in bends, as a first guess."""
    s = np.linspace(float(path.borders[run[0]]), float(path.borders[run[1]]), PLACES)
    speed = _speed_bound(run_points(path, run, s), s, limits)
    course = _smooth_course(s, speed)
    return course.slower(_slowdown(run_points(path, run, course.s), course, limits) / SHARE)


def _speed_bound(points: CurvePoints, s: Floats, limits: MotionLimits) -> Floats:
    """Speed (M,) [m/s] at which the hand can pass each place, with rises and falls at a share of the acceleration."""
    velocity, acceleration, jerk = limits.numbers()
    bend, slope = np.maximum(np.abs(points.curvature), 1e-9), np.maximum(np.abs(points.slope), 1e-9)
    fastest = np.minimum(np.sqrt(acceleration / bend), np.minimum(jerk / bend**2, jerk / slope) ** (1.0 / 3.0))
    square = np.minimum(velocity, SHARE * fastest) ** 2
    square[[0, -1]] = 0.0
    # The least of w(s*) + 2 a |s - s*| over all s*: no rise or fall of w = v^2 is steeper than 2 a.
    gain = 2.0 * SHARE * acceleration * s
    square = np.minimum.accumulate(square - gain) + gain
    square = np.minimum.accumulate((square + gain)[::-1])[::-1] - gain
    return np.sqrt(np.maximum(square, 0.0))


def _smooth_course(s: Floats, speed: Floats) -> Course:
    """The course with its speed averaged over a window of time, so that acceleration and jerk are finite."""
    moments = np.concatenate([[0.0], np.cumsum(2.0 * np.diff(s) / (speed[1:] + speed[:-1]))])
    step = float(moments[-1]) / (PLACES - 1)
    width = int(WINDOW * PLACES)
    window = np.full(width, 1.0 / width)
    # Three moving averages as one convolution.
    window = np.convolve(np.convolve(window, window), window)
    rate = np.convolve(np.interp(step * np.arange(PLACES), moments, speed), window)
    way = np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]))])
    scale = (s[-1] - s[0]) / (way[-1] * step)
    time = step * np.arange(rate.size, dtype=np.float64)
    return Course(time, s[0] + scale * step * way, scale * rate, scale * np.gradient(rate, step))


def _slowdown(points: CurvePoints, course: Course, limits: MotionLimits) -> float:
    """Factor of time at which the course just keeps all limits; below 1 the course could be quicker."""
    velocity, acceleration, jerk = limits.numbers()
    cross = points.curvature * course.speed**2
    along = np.gradient(course.acceleration, course.time) - points.curvature * cross * course.speed
    aside = 3.0 * points.curvature * course.speed * course.acceleration + points.slope * course.speed**3
    return max(
        float(course.speed.max()) / velocity,
        float(np.hypot(course.acceleration, cross).max() / acceleration) ** 0.5,
        float(np.hypot(along, aside).max() / jerk) ** (1.0 / 3.0),
    )
