"""Movers that put objects down, on a rectangle or over an ellipse; and the horizontal throw of the same paper.

A placing mover brings the object over its bin, rests there for the window of the follow-through while the vacuum
decays, and returns. So it cannot use a bin out of the hand's reach. A residual moves the place of the release:
`release_point` and `virtual_goal` both move the target, `release_xyz` moves the hand. Without a flight these three
modes differ only in their scales.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, concatenate_records, length, replace_rows, take
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.movers.straight import Meeting, Mover, StraightMover, ThrowMotion
from pnt_gym.constants import GRAVITY
from pnt_gym.planning.motion.kernel import strokes
from pnt_gym.planning.motion.limits import EllipticWorkspace, LimitRows
from pnt_gym.planning.motion.rows import Segments
from pnt_gym.planning.motion.scurve import coast, rest_to_rest
from pnt_gym.planning.paths.arcs import PIECES, arc_segments
from pnt_gym.planning.straight.plan import MIN_REACH, Reason, ReleaseBatch, TargetChoice
from pnt_gym.planning.straight.release import release_at_elevation, release_at_point

SMALLEST_ELLIPSE: Final = 0.05
"""Horizontal distance below which a rectangle replaces the ellipse [m]."""
ARRIVAL_ITERATIONS: Final = 9
"""Iterations for the hand's arrival time at a moving object; the hand waits for the remaining difference."""


@final
class HorizontalMover(StraightMover):
    """Lifts straight up to the ceiling, throws horizontally, and returns at that height (Hassan et al. 2022, IV-B2).

    The hand brakes on the line of the throw, and descends to the next pick from the height of the lift.
    """

    def __init__(self, config: ConveyorConfig, workspace: EllipticWorkspace) -> None:
        lift = config.motion.model_copy(update={"clearance": config.motion.ceiling})
        super().__init__(config.model_copy(update={"motion": lift}), workspace)

    def plan(self, pick: Floats, target: Floats, limits: LimitRows, ceiling: Floats) -> ReleaseBatch:
        """Horizontal releases at the height of the ceiling."""
        return _after_lift(pick, release_at_elevation(_at_height(pick, ceiling), target, limits, 0.0), limits)

    def aim_at(self, context: Context, goal: Floats, slack: float) -> ReleaseBatch:
        """Horizontal releases at the height of the ceiling, for moved targets."""
        return self.plan(context.pick, goal, context.throw_limits, context.ceiling)

    def release_at(self, context: Context, point: Floats) -> ReleaseBatch:
        """Horizontal releases at given points; the throw starts above the pick at the point's height."""
        pick, limits = context.pick, context.throw_limits
        start = _at_height(pick, point[:, 2])
        return _after_lift(pick, release_at_point(start, point, limits, plane_z=context.target[:, 2]), limits)

    def is_feasible(self, pick: Floats, release: ReleaseBatch, limits: LimitRows) -> Bools:
        """Which throws have a plan and stay inside the workspace until the hand has stopped."""
        start = _lift_points(pick, release)
        good = super().is_feasible(start, release, limits)
        return good & self._workspace.contains(pick) & (start[:, 2] >= pick[:, 2])

    def accepts(self, context: Context, shift: Floats | None) -> Bools:
        """Which nominal plans the robot can execute, also for moved targets."""
        return Mover.accepts(self, context, shift)

    def choose_targets(
        self, pick: Floats, targets: Floats, limits: LimitRows, ceiling: Floats, origin: Floats, may_throw: Bools
    ) -> TargetChoice | None:
        """None: the compiled choice is of throws without a lift."""
        return None

    def throw(self, pick: Floats, release: ReleaseBatch, limits: LimitRows, ceiling: Floats) -> ThrowMotion:
        """Motions up, along the horizontal line to the release, through the window, and to a stop on that line."""
        start = _lift_points(pick, release)
        up, motion = rest_to_rest(start - pick, limits), super().throw(start, release, limits, ceiling)
        time = up.durations.sum(axis=1)
        return motion.replace(
            pick=pick,
            segments=concatenate_records([up, motion.segments], axis=1),
            release_time=time + motion.release_time,
            stop_time=time + motion.stop_time,
        )


class PlacingMover(Mover):
    """Abstract: brings objects over their bins, releases them at rest, and returns on the same kind of path.

    Subclasses define the path from rest to rest over obstacles.
    """

    def __init__(self, config: ConveyorConfig, workspace: EllipticWorkspace) -> None:
        self._belt = config.belt
        self._lift = config.motion.ceiling
        self._window = config.motion.follow_through.window
        self._workspace = workspace
        self.rules = config.motion.placing
        self.rim = config.bins.rim

    @abstractmethod
    def over(self, start: Floats, end: Floats, heights: tuple[Floats, Floats], limits: LimitRows) -> Segments:
        """Motions from rest to rest, vertical at both ends.

        Args:
            start: first points (N, 3) [m].
            end: last points (N, 3) [m].
            heights: heights above which the hand may move sideways, near the start and near the end (N,) each [m].
            limits: bounds of the norms of velocity, acceleration and jerk.
        """

    @abstractmethod
    def top(self, heights: tuple[Floats, Floats]) -> Floats:
        """Greatest height of the hand in the motions of `over` (N,) [m]."""

    @abstractmethod
    def heights(self, pick: Floats, place: Floats, over_rims: Floats) -> tuple[Floats, Floats]:
        """Heights above which the hand may move sideways, near a pick and near a place (N,) each [m].

        Args:
            pick: pick points (N, 3) [m].
            place: points of the release (N, 3) [m].
            over_rims: height at which the hand, or the object that it carries, is clear of the rims (N,) [m].
        """

    def plan(self, pick: Floats, target: Floats, limits: LimitRows, ceiling: Floats) -> ReleaseBatch:
        """Releases at rest over the bins' middles, with the object's lowest point `over_rim` above the rim."""
        return self._release_at_rest(
            pick, _at_height(target, target[:, 2] + self.rules.over_rim + self._hang(pick)), limits
        )

    def aim_at(self, context: Context, goal: Floats, slack: float) -> ReleaseBatch:
        """Releases at rest over moved targets."""
        return self.plan(context.pick, goal, context.throw_limits, context.ceiling)

    def release_at(self, context: Context, point: Floats) -> ReleaseBatch:
        """Releases at rest at given points."""
        return self._release_at_rest(context.pick, point, context.throw_limits)

    def reserve(self, release: ReleaseBatch) -> Floats:
        """The reserve of the config's placing rules, for all releases (N,) [m]."""
        return np.full(len(release.speed), self.rules.reserve)

    def is_feasible(self, pick: Floats, release: ReleaseBatch, limits: LimitRows) -> Bools:
        """Which releases have a plan whose motion stays inside the workspace."""
        place = np.where(release.feasible[:, None], release.position, pick)
        return release.feasible & self._inside(pick, place)

    def throw(self, pick: Floats, release: ReleaseBatch, limits: LimitRows, ceiling: Floats) -> ThrowMotion:
        """Motions to the place of the release, with the window at rest there."""
        way = self._carry(pick, release.position, limits)
        time, window = way.durations.sum(axis=1), np.full(len(pick), self._window)
        rows = ThrowMotion.zeros(
            len(pick),
            pick=pick,
            release_time=time,
            stop=release.position,
            stop_time=time + window,
            roof=np.inf,
            placed=True,
        )
        return ThrowMotion(rows, concatenate_records([way, coast(window)], axis=1))

    def back(self, motion: ThrowMotion, next_pick: Floats, limits: LimitRows) -> Segments:
        """Motions to the next pick with an empty cup."""
        near, far = self.heights(next_pick, motion.stop, np.full(len(next_pick), self.rim + self.rules.clear))
        return self.over(motion.stop, next_pick, (far, near), limits)

    def reach(self, motion: ThrowMotion, place: Floats, limits: LimitRows) -> Meeting:
        """The earliest meetings, by false position between the times at which objects enter and leave the window."""
        low, high = self._belt.pick_x

        def at(time: Floats) -> Floats:
            return place + time[:, None] * np.array([self._belt.speed, 0.0, 0.0])

        def late(time: Floats) -> Floats:
            return self.back(motion, at(time), limits).durations.sum(axis=1) - time

        enter = np.maximum((low - place[:, 0]) / self._belt.speed, 0.0)
        leave = np.maximum((high - place[:, 0]) / self._belt.speed, 0.0)
        time, good = first_not_late(late, enter, leave)
        good &= place[:, 0] <= high
        position = at(np.where(good, time, 0.0))
        back = self.back(motion, position, limits)
        wait = np.where(good, np.maximum(time - back.durations.sum(axis=1), 0.0), 0.0)
        return Meeting.at(position, np.where(good, time, 0.0), wait, good, back.delay(wait))

    def _hang(self, pick: Floats) -> Floats:
        """Extents of objects below the planner's points (N,) [m]: at the pick the object lies on the belt."""
        return pick[:, 2] - self._belt.height

    def _carry(self, pick: Floats, place: Floats, limits: LimitRows) -> Segments:
        """Motions to the place with objects under the cups."""
        return self.over(pick, place, self._carry_heights(pick, place), limits)

    def _carry_heights(self, pick: Floats, place: Floats) -> tuple[Floats, Floats]:
        return self.heights(pick, place, self.rim + self.rules.clear + self._hang(pick))

    def _inside(self, pick: Floats, place: Floats) -> Bools:
        """Which motions stay inside the convex workspace: each motion lies in a rectangle with these corners."""
        top, inside = self.top(self._carry_heights(pick, place)), self._workspace.contains
        return inside(pick) & inside(place) & inside(_at_height(pick, top)) & inside(_at_height(place, top))

    def _release_at_rest(self, pick: Floats, place: Floats, limits: LimitRows) -> ReleaseBatch:
        """Releases at rest; infeasible where the hand does not reach the place."""
        way = _at_height(place - pick, np.zeros(len(pick)))
        is_distant = length(way) > MIN_REACH
        good = self._inside(pick, place) & is_distant
        reason = np.where(is_distant, int(Reason.WORKSPACE), int(Reason.NO_REACH))
        segments = self._carry(pick, np.where(good[:, None], place, pick + np.array([0.1, 0.0, 0.0])), limits)
        return ReleaseBatch.from_velocities(
            pick,
            place,
            np.zeros_like(place),
            way,
            acceleration=segments.greatest_acceleration(),
            time=segments.durations.sum(axis=1),
            flight_time=np.sqrt(2.0 / GRAVITY * np.maximum(place[:, 2] - self.rim, 0.0)),
            ceiling_active=np.zeros_like(good),
            reason=np.where(good, int(Reason.FEASIBLE), reason),
        )


@final
class PlaceMover(PlacingMover):
    """Straight up, level across, straight down, with a stop at every corner (Hassan et al. 2022, IV-B1)."""

    def over(self, start: Floats, end: Floats, heights: tuple[Floats, Floats], limits: LimitRows) -> Segments:
        """Motions up, across and down: 21 segments."""
        return rectangle_segments(start, end, self.top(heights), limits)

    def top(self, heights: tuple[Floats, Floats]) -> Floats:
        """The height of the horizontal part (N,) [m]."""
        return np.maximum(*heights)

    def heights(self, pick: Floats, place: Floats, over_rims: Floats) -> tuple[Floats, Floats]:
        """Heights of the ceiling above the pick, and over all rims (N,) each [m]."""
        return pick[:, 2] + self._lift, np.maximum(over_rims, place[:, 2])


@final
class EllipseMover(PlacingMover):
    """Straight up, over half an ellipse that runs vertically at both ends, straight down (Choe et al. 2023).

    The hand rests where the straight parts meet the ellipse: the curvature jumps there, and with the curvature the
    acceleration of a moving hand.
    """

    def over(self, start: Floats, end: Floats, heights: tuple[Floats, Floats], limits: LimitRows) -> Segments:
        """Motions up, over an ellipse and down; and as a rectangle where the way is shorter than `SMALLEST_ELLIPSE`."""
        first, last = _at_height(start, heights[0]), _at_height(end, heights[1])
        top, columns = self.top(heights), PIECES + 14
        motions = rectangle_segments(start, end, top, limits).pad(columns)
        way = last - first
        wide = np.flatnonzero(np.sqrt(way[:, 0] ** 2 + way[:, 1] ** 2) >= SMALLEST_ELLIPSE)
        if wide.size == 0:
            return motions
        wide_limits = take(limits, wide)
        up, down = rest_to_rest((first - start)[wide], wide_limits), rest_to_rest((end - last)[wide], wide_limits)
        arc = arc_segments(way[wide], (top - first[:, 2])[wide], wide_limits)
        return replace_rows(motions, wide, concatenate_records([up, arc, down], axis=1))

    def top(self, heights: tuple[Floats, Floats]) -> Floats:
        """The highest point of the ellipse (N,) [m]."""
        return np.maximum(*heights) + self.rules.crest

    def heights(self, pick: Floats, place: Floats, over_rims: Floats) -> tuple[Floats, Floats]:
        """Heights at which the vertical parts end, near pick and place (N,) each [m]."""
        vertical = self.rules.vertical
        return pick[:, 2] + vertical, np.maximum(over_rims, place[:, 2] + vertical)


def is_at_rest(release: ReleaseBatch) -> Bools:
    """Which releases put an object down at rest (N,)."""
    return release.feasible & (release.speed == 0.0)


def rectangle_segments(start: Floats, end: Floats, top: Floats, limits: LimitRows) -> Segments:
    """Motions straight up to a height (N,) [m], horizontal, and straight down, each from rest to rest: 21 segments."""
    first, last = _at_height(start, top), _at_height(end, top)
    moves = [rest_to_rest(way, limits) for way in (first - start, last - first, end - last)]
    return concatenate_records(moves, axis=1)


def first_not_late(late: Callable[[Floats], Floats], low: Floats, high: Floats) -> tuple[Floats, Bools]:
    """Times (N,) in brackets (N,) at which a lateness falls to 0 or below, and which brackets contain such a time.

    The method is false position in the Illinois form. The result lies on the side where the lateness is not above 0,
    and the result of a row does not depend on the other rows.

    Args:
        late: function from times (N,) to lateness (N,), nearly linear.
        low: earliest times (N,).
        high: latest times (N,).
    """
    before, after = late(low), late(high)
    at_once, reached = before <= 0.0, after <= 0.0
    high, side = np.where(at_once, low, high), np.zeros_like(low)
    for _ in range(ARRIVAL_ITERATIONS):
        rise = np.where(before > after, before - after, 1.0)
        middle = low + np.where(before > after, before / rise, 0.5) * (high - low)
        value = late(middle)
        good = value <= 0.0
        # Illinois: the value of an end that stays twice is halved, or false position would creep up from one side.
        before = np.where(good, np.where(side > 0.0, before / 2.0, before), value)
        after = np.where(good, value, np.where(side < 0.0, after / 2.0, after))
        low, high, side = np.where(good, low, middle), np.where(good, middle, high), np.where(good, 1.0, -1.0)
    return high, at_once | reached


def _at_height(points: Floats, height: Floats) -> Floats:
    """Points (N, 3) with their heights replaced (N,) [m]."""
    return np.concatenate([points[:, :2], height[:, None]], axis=1)


def _after_lift(pick: Floats, release: ReleaseBatch, limits: LimitRows) -> ReleaseBatch:
    """Releases with the time of the lift added, for throws that begin above the picks."""
    rise = np.abs(_lift_points(pick, release)[:, 2] - pick[:, 2])
    time = release.time + strokes(rise, limits)["time"]
    return release.replace(time=time, straight=np.zeros(len(pick), dtype=np.bool_))


def _lift_points(pick: Floats, release: ReleaseBatch) -> Floats:
    """Picks raised to the heights of their releases, unchanged where the release is infeasible (N, 3) [m]."""
    return _at_height(pick, np.where(release.feasible, release.position[:, 2], pick[:, 2]))
