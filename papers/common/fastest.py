"""The fastest motion between two points under norm limits, as one optimum: a bound for every path between the points.

Hassan et al. 2022 and Choe et al. 2023 choose a path by its shape and time it afterwards. Here one programme finds path
and timing together within given bounds: vertical departure and approach, floor, roof, workspace, and the limits of
speed, acceleration and jerk as Euclidean norms. IPOPT solves the programme locally from two first guesses: the solution
obeys every bound, and no proof shows that a faster motion does not exist.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any, Final, NamedTuple

import numpy as np

from pnt_gym.arrays import Floats, Point, vector
from pnt_gym.errors import PlanningError, PntGymError
from pnt_gym.planning.motion.limits import EllipticWorkspace, MotionLimits
from pnt_gym.planning.motion.scurve import stroke_time
from pnt_gym.planning.motion.trajectory import JerkTrajectory

from .casadi_module import load_casadi
from .legs import Leg, add_leg, add_rest, hermite, join, keep_inside, set_guess, solve

FREE: Final = 40
"""Intervals of the free part."""
STRAIGHT: Final = 10
"""Intervals of a vertical part."""
ROUNDING: Final = 1e-9
"""Excess of a height over a bound that counts as rounding [m]."""
ITERATIONS: Final = 500
"""Most iterations of a solve."""


class NoMotionFound(PntGymError):
    """No motion within the bounds exists, or the solver finds none."""


class _MotionTask(NamedTuple):
    start: Floats
    end: Floats
    velocity: Floats
    lift: float
    drop: float
    floor: float
    roof: float | None
    workspace: EllipticWorkspace | None
    limits: tuple[float, float, float]

    @property
    def free_ends(self) -> dict[str, Floats]:
        """First and last point of the free part, each (3,) [m]."""
        up = np.array([0.0, 0.0, 1.0])
        return {"start": self.start + self.lift * up, "end": self.end + self.drop * up}

    @property
    def still(self) -> bool:
        """Whether the motion rests at one point."""
        return not (self.lift or self.drop or self.velocity.any() or (self.start != self.end).any())


def fastest_motion(
    start: Point,
    end: Point,
    limits: MotionLimits,
    *,
    lift: float = 0.0,
    drop: float = 0.0,
    start_velocity: Point | None = None,
    floor: float | None = None,
    roof: float | None = None,
    workspace: EllipticWorkspace | None = None,
) -> JerkTrajectory:
    """Return the fastest motion that IPOPT finds from start to rest at end, as one row.

    Args:
        start: first point (3,) [m].
        end: last point (3,) [m].
        limits: one set of limits, kept as norms at all times.
        lift: vertical part at the start [m].
        drop: vertical part at the end [m], entered without stopping.
        start_velocity: velocity at the start (3,) [m/s], with no acceleration; rest when not given.
        floor: least height of the free part [m], not above its lower end; the height of its lower end when not given.
        roof: greatest height of the whole motion [m].
        workspace: region in which the hand stays; None for no bound.

    From rest to the same point without lift and drop the motion takes no time.

    Raises:
        ValueError: a point, lift or drop is not finite, floor or roof is not a number, lift or drop is negative, both
            a lift and a velocity are given, or an end of the motion or of its free part lies outside the workspace,
            above the roof or below the floor.
        NoMotionFound: the solver found no motion that keeps the bounds.
        PntGymError: casadi is not installed.
    """
    first, last = vector(start, "start"), vector(end, "end")
    velocity = np.zeros(3) if start_velocity is None else vector(start_velocity, "start_velocity")
    low = min(first[2] + lift, last[2] + drop)
    lowest = low if floor is None else floor
    task = _MotionTask(first, last, velocity, lift, drop, lowest, roof, workspace, limits.numbers())
    _check_numbers(task)
    _check_room(task)
    # A floor that rounding puts above the lower end would exclude that end.
    task = task._replace(floor=float(min(low, task.floor)))
    if task.still:
        return JerkTrajectory(task.start[None], np.zeros((1, FREE)), np.zeros((1, FREE, 3)))
    paths = [path for guess in _guesses(task) if (path := _solve(task, guess)) is not None]
    if not paths:
        bounds = [f"above {task.floor:.3f} m"]
        bounds += [] if task.roof is None else [f"below {task.roof:.3f} m"]
        bounds += [] if task.workspace is None else ["inside the workspace"]
        raise NoMotionFound(
            f"no motion from {task.start.tolist()} to {task.end.tolist()} was found that stays {' and '.join(bounds)}"
        )
    return min(paths, key=lambda path: float(path.duration[0]))


def _check_numbers(task: _MotionTask) -> None:
    """Check lengths, speed and heights, each value alone.

    Raises:
        PlanningError: a value is out of its range.
    """
    for name, value in (("lift", task.lift), ("drop", task.drop)):
        if not (np.isfinite(value) and value >= 0.0):
            raise PlanningError(f"{name} must be finite and not negative [m], got {value}")
    if task.lift > 0.0 and task.velocity.any():
        raise PlanningError(
            f"a motion that starts at {task.velocity.tolist()} m/s cannot be lifted vertically; leave lift at 0"
        )
    speed, fastest = float(np.sqrt(task.velocity @ task.velocity)), task.limits[0]
    if speed > fastest * (1.0 + 1e-9):
        raise PlanningError(f"start_velocity is {speed:.4g} m/s; the limit is {fastest:.4g} m/s")
    for name, height in (("floor", task.floor), ("roof", task.roof)):
        if height is not None and np.isnan(height):
            raise PlanningError(f"{name} must be a height [m], got {height}")


def _check_room(task: _MotionTask) -> None:
    """Check that the ends of the motion and of its free part lie within workspace, roof and floor.

    Raises:
        PlanningError: an end lies outside.
    """
    ends = {"start": task.start, "end": task.end}
    free = {f"{name} + {way}": task.free_ends[name] for name, way in (("start", "lift"), ("end", "drop"))}
    for name, point in (ends | free).items():
        if task.workspace is not None and task.workspace.margin(point) < -ROUNDING:
            raise PlanningError(f"{name} {point.tolist()} lies outside the workspace")
        if task.roof is not None and point[2] > task.roof + ROUNDING:
            raise PlanningError(f"{name} lies at z = {point[2]:.4g} m, above the roof at {task.roof:.4g} m")
    if any(point[2] < task.floor - ROUNDING for point in free.values()):
        heights = " and ".join(f"{name} at z = {point[2]:.4g} m" for name, point in free.items())
        raise PlanningError(f"floor {task.floor:.4g} m must not lie above either end of the free part: {heights}")


def _guesses(task: _MotionTask) -> list[float]:
    """First guesses of the free part's duration [s]: the time of a straight stroke, and a slower motion."""
    gap = task.end - task.start
    way = float(np.sqrt(gap @ gap)) + task.lift + task.drop
    reach = float(stroke_time(np.array([way]), *(np.array([value]) for value in task.limits))[0])
    _, acceleration, jerk = task.limits
    # Time to stop at full acceleration, plus the rise and fall of the acceleration.
    stop = float(np.sqrt(task.velocity @ task.velocity)) / acceleration + acceleration / jerk
    return [reach + stop * bool(task.velocity.any()), 1.6 * (reach + stop)]


def _solve(task: _MotionTask, duration: float) -> JerkTrajectory | None:
    ca = load_casadi()
    opti: Any = ca.Opti()
    legs = _add_legs(opti, task)
    _add_bounds(opti, task, legs)
    _set_first_guess(opti, task, legs, duration)
    solution = solve(opti, legs.values(), ITERATIONS)
    if solution is None:
        return None
    parts = [leg.values(solution) for leg in legs.values()]
    return JerkTrajectory.concatenate(task.start[None], parts, task.velocity[None])


def _add_legs(opti: Any, task: _MotionTask) -> dict[str, Leg]:
    """Lift, free part and drop by name, joined and fixed at start and end."""
    legs: dict[str, Leg] = {}
    if task.lift > 0.0:
        legs["lift"] = add_leg(opti, STRAIGHT, task.limits, line=(task.start[0], task.start[1]))
    # Without a lift the free part begins with the given velocity.
    legs["free"] = add_leg(opti, FREE, task.limits, moving=task.lift == 0.0)
    if task.drop > 0.0:
        legs["drop"] = add_leg(opti, STRAIGHT, task.limits, line=(task.end[0], task.end[1]))
    order = list(legs.values())
    begin = order[0]
    opti.subject_to(begin.position[begin.axes, 0] == task.start[begin.axes])
    opti.subject_to(begin.velocity[begin.axes, 0] == task.velocity[begin.axes])
    opti.subject_to(begin.acceleration[begin.axes, 0] == 0)
    for first, second in pairwise(order):
        join(opti, first, second)
    last = order[-1]
    opti.subject_to(last.position[last.axes, -1] == task.end[last.axes])
    add_rest(opti, last, -1)
    return legs


def _add_bounds(opti: Any, task: _MotionTask, legs: dict[str, Leg]) -> None:
    """Bound heights and workspace, and fix the heights where vertical and free parts meet."""
    free = legs["free"]
    if task.lift > 0.0:
        opti.subject_to(free.position[2, 0] == task.free_ends["start"][2])
    if task.drop > 0.0:
        opti.subject_to(free.position[2, -1] == task.free_ends["end"][2])
    # The curve lies in the hull of its control points, so the floor holds at all times.
    opti.subject_to(task.floor <= free.control_points(2).T)
    for leg in legs.values():
        if task.roof is not None:
            opti.subject_to(task.roof >= leg.control_points(2).T)
    if task.workspace is not None:
        keep_inside(opti, free, task.workspace)


def _set_first_guess(opti: Any, task: _MotionTask, legs: dict[str, Leg], duration: float) -> None:
    """Set the first guess: straight vertical parts, and between them a cubic with the velocity of the start."""
    below, above = task.free_ends["start"], task.free_ends["end"]
    zero = np.zeros(3)
    times = {"lift": 0.4 * duration, "free": duration, "drop": 0.4 * duration}
    paths = {
        "lift": hermite(task.start, task.velocity, below, zero, times["lift"], STRAIGHT),
        "free": hermite(below, task.velocity, above, zero, duration, FREE),
        "drop": hermite(above, zero, task.end, zero, times["drop"], STRAIGHT),
    }
    for name, leg in legs.items():
        set_guess(opti, leg, times[name], paths[name], task.limits)
