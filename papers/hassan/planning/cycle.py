"""Whole cycles from one pick to the next: pick-and-place, horizontal throw, minimum-time throw.

The module plans the three motions that Hassan et al. 2022 compare (section IV-B), N rows at a time, each as one path of
the hand from rest at a pick to rest at the next pick. The paper leaves open the lift height, the vertical approach, the
overlap of moves and the place where the hand turns back: ``CycleRules`` sets them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, final, get_args

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Bools, Floats, Ints, finite_points
from pnt_gym.errors import PlanningError
from pnt_gym.names import unknown_name
from pnt_gym.planning.motion.limits import EllipticWorkspace, MotionLimits
from pnt_gym.planning.motion.rows import Segments
from pnt_gym.planning.motion.scurve import brake_distance, rest_to_rest
from pnt_gym.planning.motion.trajectory import JerkTrajectory, PeakRatios
from pnt_gym.planning.straight.plan import CONTACT, MIN_REACH, InfeasibleThrow, Reason, ReleaseBatch
from pnt_gym.planning.straight.release import plan_release_batch, release_at_elevation

from .blend import Overlap, throw_move
from .outline import Outline, straight_return

SAMPLE_RATE = 2500.0
"""Samples per second: the control rate of the T3KR (Hassan et al. 2022, section IV-A) [Hz]."""


@final
@dataclass(frozen=True)
class CycleRules:
    """Rules of a cycle besides its points and limits.

    Attributes:
        lift: height of the vertical moves of pick-and-place and of the horizontal throw [m].
        rise: greatest height of a release above its pick [m]; None for no bound.
        approach: vertical way down to the next pick after a minimum-time throw, Z_off [m].
        tolerance: half width delta of the box around the target in which a landing is a hit [m] (Eqs. 16-17).
        overlap: overlap of neighbouring straight moves; never across the place or the next pick.

    Raises:
        ValueError: if a length is negative or not finite, or a rule is unknown.
    """

    lift: float = 0.10
    rise: float | None = 0.10
    approach: float = 0.05
    tolerance: float = 0.005
    overlap: Overlap = "ramp"

    def __post_init__(self) -> None:
        for name in ("lift", "approach", "tolerance"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value >= 0.0):
                raise PlanningError(f"{name} must be finite and not negative [m], got {value}")
        if self.rise is not None and not np.isfinite(self.rise):
            raise PlanningError(f"rise must be finite, or None for no bound [m], got {self.rise}")
        if self.overlap not in get_args(Overlap):
            raise PlanningError(unknown_name("overlap", self.overlap, get_args(Overlap)))


class CycleSamples(NamedTuple):
    """Motion of N cycles at M times, each (N, M, 3); time [s] and grip, True before the release, are (N, M)."""

    time: Floats
    position: Floats
    velocity: Floats
    acceleration: Floats
    jerk: Floats
    grip: Bools


@final
@dataclass(frozen=True, eq=False)
class Cycle:
    """N cycles of the hand, each from rest at a pick to rest at the next pick.

    Attributes:
        path: the motion of the hand; in an infeasible row the hand rests at its pick.
        phases: names of the P phases.
        phase_ends: end time of each phase (N, P) [s]; an overlapping phase begins before the previous phase ends.
        release_time: time of the release (N,) [s].
        release_position: position of the hand at the release (N, 3) [m].
        release_velocity: velocity of the hand at the release (N, 3) [m/s].
        feasible: whether the row holds a plan (N,); times, release and duration are NaN in infeasible rows.
        reason: ``Reason`` codes (N,), 0 where feasible; WORKSPACE also where the hand's stop lies outside.
    """

    path: JerkTrajectory
    phases: tuple[str, ...]
    phase_ends: Floats
    release_time: Floats
    release_position: Floats
    release_velocity: Floats
    feasible: Bools
    reason: Ints

    def __len__(self) -> int:
        return int(self.feasible.shape[0])

    @property
    def duration(self) -> Floats:
        """Time from pick to pick (N,) [s], NaN in infeasible rows."""
        return np.where(self.feasible, self.path.duration, np.nan)

    def require(self) -> Cycle:
        """Return the cycles if every row is feasible.

        Raises:
            InfeasibleThrow: if a row is infeasible, with the reason of the first such row.
        """
        if not self.feasible.all():
            row = int(np.argmin(self.feasible))
            reason = Reason(int(self.reason[row]))
            detail = ", or the hand leaves it" if reason == Reason.WORKSPACE else ""
            raise InfeasibleThrow(reason, f"{detail} (row {row})")
        return self

    def sample(self, times: ArrayLike | None = None, rate: float = SAMPLE_RATE) -> CycleSamples:
        """Return the motion at ``times`` [s], (M,) or (N, M); without times at ``rate`` [Hz] until all cycles end.

        Raises:
            ValueError: if the rate is not positive and finite, or the shape of ``times`` does not fit.
        """
        if times is None:
            if not (np.isfinite(rate) and rate > 0.0):
                raise PlanningError(f"rate must be positive and finite [Hz], got {rate}")
            times = np.arange(int(np.ceil(self.path.duration.max(initial=0.0) * rate)) + 1) / rate
        motion, jerk = self.path.sample(times), self.path.jerk(times)
        time = np.broadcast_to(np.asarray(times, dtype=np.float64), jerk.shape[:2])
        return CycleSamples(time, *motion, jerk, time < self.release_time[:, None])

    def peak_ratios(self, limits: MotionLimits) -> PeakRatios:
        """Return each cycle's largest speed, acceleration and jerk as shares of ``limits``, NaN in infeasible rows."""
        gap = np.where(self.feasible, 0.0, np.nan)
        return PeakRatios(*(ratio + gap for ratio in self.path.peak_ratios(limits)))


class CycleTask(NamedTuple):
    """Points, limits and rules of N cycles to plan.

    Attributes:
        picks: starts of the hand at rest (N, 3) [m].
        targets: points at which the objects are placed or land (N, 3) [m].
        next_picks: ends of the cycles (N, 3) [m].
        limits: largest speed, acceleration and jerk; one set or one per row.
        rules: lift height and overlap.
        workspace: region in which the hand stays; None for no bound.
    """

    picks: Floats
    targets: Floats
    next_picks: Floats
    limits: MotionLimits
    rules: CycleRules
    workspace: EllipticWorkspace | None

    @classmethod
    def of(
        cls,
        picks: ArrayLike,
        targets: ArrayLike,
        next_picks: ArrayLike,
        limits: MotionLimits,
        rules: CycleRules | None = None,
        workspace: EllipticWorkspace | None = None,
    ) -> CycleTask:
        """Return the task of checked inputs; without ``rules`` the paper's defaults hold.

        Raises:
            ValueError: if an input is not finite, shapes disagree, or a pick lies outside the workspace.
        """
        first = finite_points(picks, "picks")
        last = finite_points(next_picks, "next_picks", len(first))
        middle = finite_points(targets, "targets", len(first))
        limits.arrays(len(first))
        for name, points in (("pick", first), ("next pick", last)):
            outside = np.zeros(len(points), np.bool_) if workspace is None else ~workspace.contains(points)
            if outside.any():
                raise PlanningError(f"{name} {points[outside][0].tolist()} lies outside the workspace {workspace}")
        return cls(first, middle, last, limits, CycleRules() if rules is None else rules, workspace)

    def is_inside(self, *points: Floats) -> Bools:
        """Return the rows (N,) whose points all lie in the workspace."""
        rows_inside = np.ones(len(self.picks), dtype=np.bool_)
        for group in points:
            rows_inside &= True if self.workspace is None else self.workspace.contains(group)
        return rows_inside

    def move(self, way: Floats, reason: Ints) -> Segments:
        """Return the straight move along ``way`` (N, 3) or (3,) [m]; infeasible rows rest."""
        return rest_to_rest(np.where(_is_planned(reason)[:, None], way, 0.0), self.limits)


def pick_and_place(task: CycleTask) -> Cycle:
    """Return cycles that lift, carry and set the object down, then lift, return and descend (section IV-B1).

    A row whose target lies outside the workspace is infeasible.
    """
    lift = task.rules.lift
    up = np.array([0.0, 0.0, lift])
    reason = np.where(task.is_inside(task.targets, task.targets + up), int(Reason.FEASIBLE), int(Reason.WORKSPACE))
    moves = {"lift": up, "carry": task.targets - task.picks, "place": -up}
    back = {"leave": up, "return": task.next_picks - task.targets, "approach": -up}
    outline = Outline(
        task.picks,
        {name: task.move(way, reason) for name, way in moves.items()},
        {name: task.move(way, reason) for name, way in back.items()},
        is_throw=False,
        position=task.targets,
        velocity=np.zeros_like(task.targets),
        feasible=_is_planned(reason),
    )
    return _cycle(task, outline, reason)


def horizontal_throw(task: CycleTask) -> Cycle:
    """Return cycles that lift, throw horizontally and return at the same height (sections IV-B2 and [12] there).

    The release is the first point of the horizontal move from which the object hits the target: P_h + V_S(P_h) t = X
    with t the time to fall to the target and X shortened by the tolerance. A row is infeasible where the target is
    not below the lifted hand or is within the tolerance of the pick, the lift exceeds the greatest rise, or the hand
    would leave the workspace.
    """
    up = np.array([0.0, 0.0, task.rules.lift])
    release = _level_release(task, task.picks + up)
    low = task.rules.rise is not None and task.rules.lift > task.rules.rise + CONTACT
    reason = np.where((release.reason == Reason.FEASIBLE) & low, int(Reason.CEILING), release.reason)
    return _throw_cycle(task, release, reason, lift=task.rules.lift, approach=task.rules.lift)


def min_time_throw(task: CycleTask) -> Cycle:
    """Return cycles that throw on a straight line from the pick in minimum time and return (section IV-B3).

    The hand brakes on the line of the throw right after the release. The hand does not run the whole stroke 2 P_r,
    whose end lies beyond far targets. A row is infeasible where no throw exists or the hand would leave the workspace.
    """
    roof = None if task.rules.rise is None else task.picks[:, 2] + task.rules.rise
    release = plan_release_batch(task.picks, task.targets, task.limits, roof, task.rules.tolerance, task.workspace)
    return _throw_cycle(task, release, release.reason, lift=0.0, approach=task.rules.approach)


def _is_planned(reason: Ints) -> Bools:
    return reason == int(Reason.FEASIBLE)


def _level_release(task: CycleTask, starts: Floats) -> ReleaseBatch:
    """Release of the horizontal throw from ``starts`` (N, 3) [m], the target moved closer by the tolerance."""
    way = task.targets - starts
    full = np.sqrt(way[:, 0] * way[:, 0] + way[:, 1] * way[:, 1])
    unit = np.where(full > 0.0, 1.0 / np.where(full > 0.0, full, 1.0), 0.0)[:, None] * way * np.array([1.0, 1.0, 0.0])
    widest = np.maximum(np.abs(unit[:, 0]), np.abs(unit[:, 1]))
    shorter = task.rules.tolerance / np.where(widest > 0.0, widest, 1.0)
    # A target within the tolerance of the pick needs no throw: its reach becomes 0, which is infeasible.
    shorter = np.where(full - shorter > MIN_REACH, shorter, full)
    return release_at_elevation(starts, task.targets - shorter[:, None] * unit, task.limits, 0.0)


def _throw_cycle(task: CycleTask, release: ReleaseBatch, reason: Ints, *, lift: float, approach: float) -> Cycle:
    """Cycles that lift (if at all), throw, brake on the line, return to above the next pick, and descend."""
    stop = release.position + brake_distance(np.nan_to_num(release.speed), task.limits)[:, None] * release.direction
    inside = task.is_inside(release.position, stop)
    reason = np.where(_is_planned(reason) & ~inside, int(Reason.WORKSPACE), reason)
    planned = _is_planned(reason)
    direction = np.where(planned[:, None], release.direction, 0.0)
    up, down = np.array([0.0, 0.0, lift]), np.array([0.0, 0.0, approach])
    moves = {"lift": task.move(up, reason)} if lift > 0.0 else {}
    moves["throw"] = throw_move(direction, np.where(planned, release.distance, 0.0), task.limits)
    outline = Outline(
        task.picks,
        moves,
        {"return": task.move(task.next_picks + down - stop, reason), "approach": task.move(-down, reason)},
        is_throw=True,
        position=release.position,
        velocity=release.velocity,
        feasible=planned,
    )
    return _cycle(task, outline, reason)


def _cycle(task: CycleTask, outline: Outline, reason: Ints) -> Cycle:
    timed = straight_return(outline, task.rules.overlap)
    gap = np.where(outline.feasible, 0.0, np.nan)
    return Cycle(
        path=timed.path,
        phases=timed.phases,
        phase_ends=timed.phase_ends + gap[:, None],
        release_time=timed.release_time + gap,
        release_position=outline.position + gap[:, None],
        release_velocity=outline.velocity + gap[:, None],
        feasible=outline.feasible,
        reason=np.asarray(reason, dtype=np.int64),
    )
