"""Throws in a free direction for N picks at once, quick enough to plan every pick of a cell.

Per pick: choose a release, plan the throw to it and the return from it as two fast transfers, and check the whole
motion against limits and rules. A pick without such a motion is thrown straight, as Hassan et al. 2022 do. The optimum
of `free_optimum` is a few percent faster and a thousand times slower to find; `benchmarks/bench_free_direction.py`
measures both.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, NamedTuple, final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.planning.arrays import Bools, Floats, Ints, finite_points, finite_rows, same_count
from pnt_gym.planning.free_check import keeps_rules
from pnt_gym.planning.free_legs import return_leg, throw_leg
from pnt_gym.planning.free_release import BOLD, CAUTIOUS, TIMID, free_releases, top
from pnt_gym.planning.free_rules import HandRules
from pnt_gym.planning.limits import MotionLimits
from pnt_gym.planning.plan import ReleaseBatch
from pnt_gym.planning.release import plan_release_batch
from pnt_gym.planning.segments import accelerate, brake, brake_distance, coast, rest_to_rest
from pnt_gym.planning.trajectory import JerkTrajectory, Segments
from pnt_gym.planning.transfer import PIECES
from pnt_gym.rows import take

STRAIGHT_WINDOWS: Final = (0.0, 0.02, 0.04, 0.08)
"""Windows tried for a straight throw until its hand does not meet the object again [s]."""
COLUMNS: Final = 2 * PIECES + 5


@final
@dataclass(frozen=True, eq=False)
class FreeThrows:
    """N throws from rest at the pick to rest at the next pick; NaN in rows without one.

    Attributes:
        path: the motion of the hand, N rows; rows without a throw hold still at their pick.
        release_time: when the object is let go (N,) [s].
        position: where (N, 3) [m].
        velocity: with which velocity (N, 3) [m/s].
        flight_time: from release to target (N,) [s].
        straight: which rows fell back to the straight throw (N,).
        feasible: which rows hold a throw (N,).
    """

    path: JerkTrajectory
    release_time: Floats
    position: Floats
    velocity: Floats
    flight_time: Floats
    straight: Bools
    feasible: Bools


def plan_free_throws(
    picks: ArrayLike,
    targets: ArrayLike,
    next_picks: ArrayLike,
    limits: MotionLimits,
    *,
    ceiling: ArrayLike,
    tolerance: ArrayLike = 0.0,
    rules: HandRules | None = None,
) -> FreeThrows:
    """Plan N throws that keep limits and rules at all times.

    Args:
        picks: where the hands rest with their objects (N, 3) [m].
        targets: where the objects have to come down (N, 3) [m].
        next_picks: where the hands come to rest (N, 3) [m].
        limits: largest speed, acceleration and jerk.
        ceiling: greatest height of the release [m], one number or (N,).
        tolerance: the throw is aimed that much short of the target, as in `plan_release` [m].
        rules: what binds the hand; the defaults when not given.

    Raises:
        ValueError: an input is NaN or infinite, shapes disagree, or a pick or next pick is outside the workspace.
    """
    rules = HandRules() if rules is None else rules
    start, goal = finite_points(picks, "picks"), finite_points(next_picks, "next_picks")
    same_count("picks", len(start), "next_picks", len(goal))
    for name, points in (("picks", start), ("next_picks", goal)):
        if rules.workspace is not None and not rules.workspace.contains(points).all():
            row = int(np.argmin(rules.workspace.contains(points)))
            raise ValueError(f"{name} row {row}, {points[row].tolist()}, lies outside the workspace")
    task = _Task(start, goal, limits, finite_rows(ceiling, len(start), "ceiling"), rules)
    rows = _chosen(task, targets, tolerance, BOLD)
    left = np.flatnonzero(~rows.good)
    for caution in (CAUTIOUS, TIMID):
        if left.size > 0:
            aims = np.asarray(targets, dtype=np.float64)[left]
            slack = finite_rows(tolerance, len(start), "tolerance")[left]
            _replace(rows, left, _chosen(task.take(left), aims, slack, caution))
            left = np.flatnonzero(~rows.good)
    if left.size > 0:
        plan = plan_release_batch(
            start, targets, limits, ceiling=task.ceiling, tolerance=tolerance, workspace=rules.workspace
        )
        for extra in STRAIGHT_WINDOWS:
            _replace(rows, left, _straight(task.take(left), take(plan, left), rules.window + extra))
            left = np.flatnonzero(~rows.good)
    return rows.throws(start)


class _Task(NamedTuple):
    """N picks and next picks (N, 3) [m], with what binds the motion between them."""

    picks: Floats
    goal: Floats
    limits: MotionLimits
    ceiling: Floats
    rules: HandRules

    def take(self, rows: Ints) -> _Task:
        return _Task(self.picks[rows], self.goal[rows], self.limits.take(rows), self.ceiling[rows], self.rules)

    @property
    def roof(self) -> Floats:
        """Greatest height of the hand (N,) [m]."""
        return top(self.ceiling, self.rules)

    def keeps(self, durations: Floats, jerks: Floats, time: Floats) -> Bools:
        """Which motions keep limits and rules."""
        path = JerkTrajectory(self.picks, durations, jerks)
        floor = self.picks[:, 2], np.minimum(self.goal[:, 2], self.picks[:, 2])
        return keeps_rules(path, time, self.limits, self.roof, self.rules, floor)


class _Rows(NamedTuple):
    """What is known of N throws; rows that are not good hold no throw."""

    durations: Floats
    jerks: Floats
    time: Floats
    position: Floats
    velocity: Floats
    flight: Floats
    straight: Bools
    good: Bools

    def throws(self, picks: Floats) -> FreeThrows:
        gap = np.where(self.good, 0.0, np.nan)
        path = JerkTrajectory(picks, self.durations * self.good[:, None], self.jerks * self.good[:, None, None])
        return FreeThrows(
            path=path,
            release_time=self.time + gap,
            position=self.position + gap[:, None],
            velocity=self.velocity + gap[:, None],
            flight_time=self.flight + gap,
            straight=self.straight & self.good,
            feasible=self.good,
        )


def _replace(rows: _Rows, index: Ints, other: _Rows) -> None:
    for old, new in zip(rows, other, strict=True):
        old[index] = new


def _chosen(task: _Task, targets: ArrayLike, tolerance: ArrayLike, caution: float) -> _Rows:
    """Throw, window, return and approach joined and checked."""
    count, rules, roof = len(task.picks), task.rules, task.roof
    release = free_releases(
        task.picks,
        targets,
        task.limits,
        ceiling=task.ceiling,
        tolerance=tolerance,
        next_picks=task.goal,
        rules=rules,
        caution=caution,
    )
    few = caution > BOLD
    first = throw_leg(task.picks, release.position, release.velocity, task.limits, roof, few=few)
    # Without a throw there is nothing to return from: NaN is no work.
    start = np.where(first.feasible[:, None], release.position + rules.window * release.velocity, np.nan)
    second, down = return_leg(start, release.velocity, task.goal, task.limits, roof, rules, few=few)
    found = first.feasible & second.feasible
    parts = [first.segments, coast(np.full(count, rules.window)), second.segments, down]
    durations = np.concatenate([part.durations for part in parts], axis=1) * found[:, None]
    jerks = np.concatenate([part.jerks for part in parts], axis=1)
    time = np.where(found, first.duration, 0.0)
    good = found & task.keeps(durations, jerks, time)
    never = np.zeros(count, dtype=np.bool_)
    return _Rows(durations, jerks, time, release.position, release.velocity, release.flight_time, never, good)


def _straight(task: _Task, plan: ReleaseBatch, window: float) -> _Rows:
    """Throw along a line, window, stop on it, return above the next pick, approach."""
    count, known = len(task.picks), plan.feasible
    ahead = np.where(known[:, None], plan.direction, np.array([1.0, 0.0, 0.0]))
    way, speed = np.where(known, plan.distance, 1e-3), np.where(known, plan.speed, 0.0)
    stop = task.picks + ahead * (way + window * speed + brake_distance(speed, task.limits))[:, None]
    above = task.goal + np.array([0.0, 0.0, task.rules.approach])
    parts = [
        accelerate(ahead, way, task.limits),
        coast(np.full(count, window)),
        brake(ahead, speed, task.limits),
        rest_to_rest(above - stop, task.limits),
        rest_to_rest(task.goal - above, task.limits),
    ]
    spare = COLUMNS - sum(part.durations.shape[1] for part in parts)
    parts.append(Segments(np.zeros((count, spare)), np.zeros((count, spare, 3))))
    durations = np.concatenate([part.durations for part in parts], axis=1) * known[:, None]
    jerks = np.concatenate([part.jerks for part in parts], axis=1)
    time = np.where(known, plan.time, 0.0)
    good = known & task.keeps(durations, jerks, time)
    always = np.ones(count, dtype=np.bool_)
    return _Rows(durations, jerks, time, plan.position, plan.velocity, plan.flight_time, always, good)
