"""The mover, which plans the hand's motion in a cycle, and the mover on straight lines of Hassan et al. 2022.

A mover plans the nominal release, the releases of corrected throws, the motion to a release, and the motion from the
end of the throw to the next pick. Cell, planner and action modes use only the class `Mover`; `planner` in the cell's
config chooses the subclass.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cached_property
from typing import Any, ClassVar, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, take
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.planning.motion.hunt import meet
from pnt_gym.planning.motion.intercept import HORIZON
from pnt_gym.planning.motion.kernel import go_back
from pnt_gym.planning.motion.limits import EllipticWorkspace, LimitRows, Space
from pnt_gym.planning.motion.rows import Hunt, Intercept, Segments
from pnt_gym.planning.motion.scurve import coast
from pnt_gym.planning.motion.trajectory import JerkTrajectory
from pnt_gym.planning.straight.kernel import choose_targets, stops_inside, throw_motions
from pnt_gym.planning.straight.plan import ReleaseBatch, TargetChoice
from pnt_gym.planning.straight.release import aim_lines, lower_elevation, plan_release_batch, release_at_point
from pnt_gym.planning.straight.rows import StopRules
from pnt_gym.rows import Columns, Triple, field


@final
class ThrowMotion(Columns):
    """Motions of N hands in a throw, from the pick to the point where the return begins.

    Args:
        rows: the motions, without their segments.
        segments: acceleration, window and braking.
        pick_velocity: velocity of the hand at the lift (N, 3) [m/s]; None where all hands begin at rest.
    """

    pick: Triple = field("m", "start")
    release_time: Floats = field("s", "time of the planned release")
    stop: Triple = field("m", "point where the throw ends and the return begins")
    stop_time: Floats = field("s", "time at which the return begins")
    velocity: Triple = field("m/s", "velocity of the hand at that time; zero after a stop")
    roof: Floats = field("m", "greatest height of the hand on the return")
    placed: Bools = field("-", "whether the object is put down at rest, at its bin")

    _fields: ClassVar = ("rows", "segments", "pick_velocity")

    def __init__(self, rows: NDArray[Any], segments: Segments, pick_velocity: Floats | None = None) -> None:
        super().__init__(rows)
        self.segments, self.pick_velocity = segments, pick_velocity

    @cached_property
    def path(self) -> JerkTrajectory:
        """Path of the hand until the return begins, from rest or with its first velocity."""
        return JerkTrajectory.concatenate(self.pick, [self.segments], self.pick_velocity)

    @classmethod
    def resting(cls, place: Floats) -> ThrowMotion:
        """Motions of hands that rest at `place` (N, 3) [m] and throw nothing."""
        return cls(cls.zeros(len(place), pick=place, stop=place, roof=np.inf), coast(np.zeros(len(place))))


@final
class Meeting(Columns):
    """Times and places at which N hands meet objects on the belt; infeasible rows have placeholders.

    Args:
        rows: the meetings.
        back: motions from the ends of throws to the meetings; None where these motions are not planned yet.
    """

    position: Triple = field("m", "point where the hand lifts the object")
    end: Triple = field("m", "point where a motion to rest would end; upstream of `position` for a hand that rides")
    time: Floats = field("s", "time from the end of the throw until the hand touches the object")
    wait: Floats = field("s", "standstill above the pick")
    feasible: Bools = field("-", "whether the object can be picked")

    _fields: ClassVar = ("rows", "back")

    def __init__(self, rows: NDArray[Any], back: Segments | None = None) -> None:
        super().__init__(rows)
        self.back = back

    @classmethod
    def at(cls, position: Floats, time: Floats, wait: Floats, feasible: Bools, back: Segments | None) -> Meeting:
        """Meetings at the ends of motions to rest."""
        rows = cls.zeros(len(time), position=position, end=position, time=time, wait=wait, feasible=feasible)
        return cls(rows, back)


class Mover(ABC):
    """Abstract: plans the hand's motion for N picks at once; a row's result does not depend on the other rows.

    A mover is made from the config of a cell and from the workspace, the positions that the hand can reach.
    """

    @abstractmethod
    def plan(self, pick: Floats, target: Floats, limits: LimitRows, ceiling: Floats) -> ReleaseBatch:
        """Nominal releases for picks and targets (N, 3), below the ceilings (N,) [m]."""

    @abstractmethod
    def aim_at(self, context: Context, goal: Floats, slack: float) -> ReleaseBatch:
        """Releases for moved targets (N, 3) [m], as close to the nominal releases as possible.

        `slack` is the height by which a release may exceed the ceiling [m].
        """

    @abstractmethod
    def release_at(self, context: Context, point: Floats) -> ReleaseBatch:
        """Releases at given points (N, 3) [m]."""

    @abstractmethod
    def reserve(self, release: ReleaseBatch) -> Floats:
        """Distances by which targets may move along the throw with a feasible plan, for accepted releases (N,) [m]."""

    @abstractmethod
    def is_feasible(self, pick: Floats, release: ReleaseBatch, limits: LimitRows) -> Bools:
        """Which releases the robot can execute (N,)."""

    def accepts(self, context: Context, shift: Floats | None) -> Bools:
        """Which nominal plans the robot can execute, also for targets moved by `shift` (N, 3) [m], forth and back."""
        pick, limits = context.pick, context.throw_limits
        good = self.is_feasible(pick, context.plan, limits)
        for goal in () if shift is None else (context.target - shift, context.target + shift):
            good &= self.is_feasible(pick, self.aim_at(context, goal, np.inf), limits)
        return good

    def choose_targets(
        self, pick: Floats, targets: Floats, limits: LimitRows, ceiling: Floats, origin: Floats, may_throw: Bools
    ) -> TargetChoice | None:
        """The first accepted throws into targets in turn (N, T, 3) [m], which have a reserve as seen from `origin`.

        None where the mover has no compiled choice; then `plan` and `accepts` try one target after the other.
        """
        return None

    @abstractmethod
    def throw(self, pick: Floats, release: ReleaseBatch, limits: LimitRows, ceiling: Floats) -> ThrowMotion:
        """Motions from the pick through feasible releases to the points where the return begins."""

    @abstractmethod
    def back(self, motion: ThrowMotion, next_pick: Floats, limits: LimitRows) -> Segments:
        """Motions from the end of a throw to next picks (N, 3) [m], which end at rest."""

    @abstractmethod
    def reach(self, motion: ThrowMotion, place: Floats, limits: LimitRows) -> Meeting:
        """The earliest meetings with objects on the belt.

        `place` (N, 3) [m] are the pick points of the objects at the moment when the throw ends.
        """

    def approach(self, motion: ThrowMotion, meeting: Meeting, limits: LimitRows) -> Segments:
        """Motions from the end of a throw to meetings as of `reach`."""
        assert meeting.back is not None
        return meeting.back

    def meet(self, motion: ThrowMotion, place: Floats, limits: LimitRows) -> tuple[Meeting, Segments]:
        """The earliest meetings as `reach`, and the motions as `approach`."""
        meeting = self.reach(motion, place, limits)
        return meeting, self.approach(motion, meeting, limits)


class StraightMover(Mover):
    """Throws along the line from pick to release, stops on that line, and returns on straight lines.

    The throw is that of Hassan et al. 2022, the motion after it is not. The paper brakes at the release, and its moves
    overlap at corners (section III-C), which exceeds the jerk limit. Here the hand keeps its velocity for the window,
    so that the cup leaves the object alone, and stops at every corner. `FlyingMover` returns without these stops.
    """

    def __init__(self, config: ConveyorConfig, workspace: EllipticWorkspace) -> None:
        follow, (low, high) = config.motion.follow_through, config.belt.pick_x
        self._clearance = config.motion.clearance
        # What all hunts have in common.
        belt = [config.belt.speed, 0.0, 0.0]
        self._hunt = Hunt.zeros(1, low=low, high=high, belt=belt, clearance=self._clearance)
        self._workspace = workspace
        self._rules = StopRules(follow.window, follow.gravity_share or 0.0, config.motion.reserve)
        self._space = Space.of(workspace)

    def plan(self, pick: Floats, target: Floats, limits: LimitRows, ceiling: Floats) -> ReleaseBatch:
        """Minimum-time releases: the exact optimum of the problem in Hassan et al. 2022."""
        return plan_release_batch(pick, target, limits, ceiling=ceiling)

    def aim_at(self, context: Context, goal: Floats, slack: float) -> ReleaseBatch:
        """Releases at the nominal elevation, or at a lower one where the release would exceed ceiling and slack."""
        limits, top = context.throw_limits, context.ceiling + slack
        angle = np.where(context.plan.feasible, context.plan.angle, 0.0)
        release = aim_lines(context.pick, goal, limits, angle)
        rows = (release.feasible & (release.position[:, 2] > top)).nonzero()[0]
        if rows.size == 0:
            return release
        angle[rows] = lower_elevation(context.pick[rows], goal[rows], take(limits, rows), angle[rows], top[rows])
        return aim_lines(context.pick, goal, limits, angle)

    def release_at(self, context: Context, point: Floats) -> ReleaseBatch:
        """Releases at given points, at the speed that the hand can reach on the way."""
        return release_at_point(context.pick, point, context.throw_limits, plane_z=context.target[:, 2])

    def reserve(self, release: ReleaseBatch) -> Floats:
        """The reserve of the config, for all releases (N,) [m]."""
        return np.full(len(release.speed), self._rules.reserve)

    def is_feasible(self, pick: Floats, release: ReleaseBatch, limits: LimitRows) -> Bools:
        """Which throws have a plan and stay inside the workspace until the hand has stopped."""
        shift = np.zeros_like(pick)
        return stops_inside(pick, release.position, limits, release.rows, shift, self._rules, self._space)

    def accepts(self, context: Context, shift: Floats | None) -> Bools:
        """Which nominal plans stay inside the workspace, also at the same elevation to moved targets."""
        pick, shift = context.pick, np.zeros_like(context.pick) if shift is None else shift
        releases, limits = context.plan.rows, context.throw_limits
        return stops_inside(pick, context.target, limits, releases, shift, self._rules, self._space)

    def choose_targets(
        self, pick: Floats, targets: Floats, limits: LimitRows, ceiling: Floats, origin: Floats, may_throw: Bools
    ) -> TargetChoice | None:
        """The first accepted throws, in machine code."""
        rules, space = self._rules, self._space
        attempt, plan, good = choose_targets(pick, targets, limits, ceiling, rules, space, origin, may_throw)
        return TargetChoice(attempt, ReleaseBatch(plan), good)

    def throw(self, pick: Floats, release: ReleaseBatch, limits: LimitRows, ceiling: Floats) -> ThrowMotion:
        """Motions along the line from pick to release, through the window at constant velocity, and to a stop."""
        segments, ends = throw_motions(pick, release.rows, limits, self._rules)
        return ThrowMotion(ThrowMotion.zeros(len(pick), pick=pick, roof=np.inf, **ends._asdict()), segments)

    def back(self, motion: ThrowMotion, next_pick: Floats, limits: LimitRows) -> Segments:
        """Motions straight to the point above the next pick, then down."""
        return go_back(motion.stop, next_pick, np.zeros(len(next_pick)), limits, self._clearance)

    def reach(self, motion: ThrowMotion, place: Floats, limits: LimitRows) -> Meeting:
        """The earliest meetings of hands that move from rest to rest, without motions."""
        hunts = take(self._hunt, np.zeros(len(place), dtype=np.int64))
        hunts["hand"], hunts["place"] = motion.stop, place
        hunts["velocity"], hunts["acceleration"], hunts["jerk"] = limits
        intercept = Intercept(meet(hunts, 0, HORIZON))
        met = intercept.feasible
        position = np.where(met[:, None], intercept.position, place)
        return Meeting.at(position, np.where(met, intercept.time, 0.0), np.where(met, intercept.wait, 0.0), met, None)

    def approach(self, motion: ThrowMotion, meeting: Meeting, limits: LimitRows) -> Segments:
        """Motions straight to the points above the picks, the waits, and the descents."""
        return go_back(motion.stop, meeting.end, meeting.wait, limits, self._clearance)
