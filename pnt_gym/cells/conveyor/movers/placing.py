"""Movers that put objects down, on a rectangle or over an ellipse; and the level throw that they are compared with.

Where a throw lets go in flight, these bring the object over its bin, stand still for the window of the follow-through
while the vacuum decays, and go on. A bin out of the hand's reach is out of theirs. Their residual is a shift of the
place where the object is let go: `release_point` and `virtual_goal` both shift the target, `release_xyz` shifts the
hand itself. Nothing flies, so the three differ in their scales only.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from dataclasses import replace
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, joined, length, replaced, take
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.movers.straight import Meeting, Mover, StraightMover, ThrowMotion
from pnt_gym.constants import GRAVITY
from pnt_gym.planning.motion.limits import EllipticWorkspace, Limits
from pnt_gym.planning.motion.scurve import coast, rest_to_rest, stroke_time
from pnt_gym.planning.motion.trajectory import Segments
from pnt_gym.planning.paths.arcs import PIECES, arc_segments
from pnt_gym.planning.straight.plan import MIN_REACH, Reason, ReleaseBatch
from pnt_gym.planning.straight.release import release_at_elevation, release_at_point

NARROW: Final = 0.05
"""Ways shorter than this from above to above are no ellipse [m]."""
CHASES: Final = 9
"""Looks at how long the hand takes to a moving object; what is left after them is waited for."""


@final
class HorizontalMover(StraightMover):
    """Lifts straight up to the ceiling, throws level, and returns at that height (Hassan et al. 2022, IV-B2).

    The hand brakes on the line of the throw, and comes down on the next pick from as high as it lifted.

    Args:
        config: the cell.
        workspace: where the hand may be.
    """

    def __init__(self, config: ConveyorConfig, workspace: EllipticWorkspace) -> None:
        lift = config.motion.model_copy(update={"clearance": config.motion.ceiling})
        super().__init__(config.model_copy(update={"motion": lift}), workspace)

    def plan(self, pick: Floats, target: Floats, limits: Limits, ceiling: Floats) -> ReleaseBatch:
        """The level throw from the ceiling."""
        return _after_lift(pick, release_at_elevation(_at_height(pick, ceiling), target, limits, 0.0), limits)

    def aimed(self, context: Context, goal: Floats, slack: float) -> ReleaseBatch:
        """The same at moved targets."""
        return self.plan(context.pick, goal, context.throw_limits, context.ceiling)

    def moved(self, context: Context, point: Floats) -> ReleaseBatch:
        """Level releases at the points, from above the pick at their heights."""
        pick, limits = context.pick, context.throw_limits
        start = _at_height(pick, point[:, 2])
        return _after_lift(pick, release_at_point(start, point, limits, plane_z=context.target[:, 2]), limits)

    def is_feasible(self, pick: Floats, release: ReleaseBatch, limits: Limits) -> Bools:
        """Which throws exist and stay inside the workspace until the hand has stopped."""
        lifted = _lifted(pick, release)
        good = super().is_feasible(lifted, release, limits)
        return good & self._workspace.contains(pick) & (lifted[:, 2] >= pick[:, 2])

    def throw(self, pick: Floats, release: ReleaseBatch, limits: Limits, ceiling: Floats) -> ThrowMotion:
        """Up, along the level line to the release, the window, and the stop on that line."""
        lifted = _lifted(pick, release)
        up, thrown = rest_to_rest(lifted - pick, limits), super().throw(lifted, release, limits, ceiling)
        time = up.durations.sum(axis=1)
        return replace(
            thrown,
            pick=pick,
            segments=joined([up, thrown.segments], axis=1),
            release_time=time + thrown.release_time,
            stop_time=time + thrown.stop_time,
        )


class PlacingMover(Mover):
    """Abstract: brings objects over their bins, lets go at rest, and returns the way it came.

    Subclasses say on which path the hand gets from rest to rest over what lies between.

    Args:
        config: the cell.
        workspace: where the hand may be.
    """

    def __init__(self, config: ConveyorConfig, workspace: EllipticWorkspace) -> None:
        self._belt = config.belt
        self._lift = config.motion.ceiling
        self._window = config.motion.follow_through.window
        self._workspace = workspace
        self.rules = config.motion.placing
        self.rim = config.bins.rim

    @abstractmethod
    def over(self, start: Floats, end: Floats, heights: tuple[Floats, Floats], limits: Limits) -> Segments:
        """Motions from rest to rest, vertical at both ends.

        Args:
            start: (N, 3) [m].
            end: (N, 3) [m].
            heights: at which the hand may begin, and at which it must have ended, to move sideways (N,) each [m].
            limits: norms that hold at all times.
        """

    @abstractmethod
    def top(self, heights: tuple[Floats, Floats]) -> Floats:
        """Greatest height of the hand on such motions (N,) [m]."""

    @abstractmethod
    def heights(self, pick: Floats, place: Floats, over_rims: Floats) -> tuple[Floats, Floats]:
        """At which heights the hand may move sideways near a pick and near a place (N,) each [m].

        Args:
            pick: (N, 3) [m].
            place: where it lets go (N, 3) [m].
            over_rims: height at which it, or what it carries, is clear of the rims (N,) [m].
        """

    def plan(self, pick: Floats, target: Floats, limits: Limits, ceiling: Floats) -> ReleaseBatch:
        """Places over the middles of the bins, the object's lowest point as high above the rim as the rules say."""
        return self._placed(pick, _at_height(target, target[:, 2] + self.rules.over_rim + self._hang(pick)), limits)

    def aimed(self, context: Context, goal: Floats, slack: float) -> ReleaseBatch:
        """The same over moved targets."""
        return self.plan(context.pick, goal, context.throw_limits, context.ceiling)

    def moved(self, context: Context, point: Floats) -> ReleaseBatch:
        """Places where the hand is told to let go."""
        return self._placed(context.pick, point, context.throw_limits)

    def reserve(self, release: ReleaseBatch) -> Floats:
        """The same for all."""
        return np.full(len(release.speed), self.rules.reserve)

    def is_feasible(self, pick: Floats, release: ReleaseBatch, limits: Limits) -> Bools:
        """Which places exist and are reached inside the workspace."""
        place = np.where(release.feasible[:, None], release.position, pick)
        return release.feasible & self._inside(pick, place)

    def throw(self, pick: Floats, release: ReleaseBatch, limits: Limits, ceiling: Floats) -> ThrowMotion:
        """Over to the place, and the window at rest there."""
        way = self._carry(pick, release.position, limits)
        time, window = way.durations.sum(axis=1), np.full(len(pick), self._window)
        return ThrowMotion(
            pick=pick,
            segments=joined([way, coast(window)], axis=1),
            release_time=time,
            stop=release.position,
            stop_time=time + window,
            velocity=np.zeros_like(pick),
            roof=np.full(len(pick), np.inf),
            placed=np.full(len(pick), True),
        )

    def back(self, motion: ThrowMotion, next_pick: Floats, limits: Limits) -> Segments:
        """Over to the next pick with nothing under the cup."""
        near, far = self.heights(next_pick, motion.stop, np.full(len(next_pick), self.rim + self.rules.clear))
        return self.over(motion.stop, next_pick, (far, near), limits)

    def meet(self, motion: ThrowMotion, place: Floats, limits: Limits) -> Meeting:
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
        return Meeting(position, np.where(good, time, 0.0), wait, good, joined([coast(wait), back], axis=1))

    def _hang(self, pick: Floats) -> Floats:
        """How far objects reach below the planner's points (N,) [m]: at their picks they lie on the belt."""
        return pick[:, 2] - self._belt.height

    def _carry(self, pick: Floats, place: Floats, limits: Limits) -> Segments:
        """Motions of hands with objects under their cups."""
        return self.over(pick, place, self._carried(pick, place), limits)

    def _carried(self, pick: Floats, place: Floats) -> tuple[Floats, Floats]:
        return self.heights(pick, place, self.rim + self.rules.clear + self._hang(pick))

    def _inside(self, pick: Floats, place: Floats) -> Bools:
        """Which motions stay inside the workspace: it is convex, and they lie in rectangles with these corners."""
        top, inside = self.top(self._carried(pick, place)), self._workspace.contains
        return inside(pick) & inside(place) & inside(_at_height(pick, top)) & inside(_at_height(place, top))

    def _placed(self, pick: Floats, place: Floats, limits: Limits) -> ReleaseBatch:
        """Objects let go at rest; NaN where the hand does not get there."""
        way = _at_height(place - pick, np.zeros(len(pick)))
        apart = length(way) > MIN_REACH
        good = self._inside(pick, place) & apart
        reason = np.where(apart, int(Reason.WORKSPACE), int(Reason.NO_REACH))
        segments = self._carry(pick, np.where(good[:, None], place, pick + np.array([0.1, 0.0, 0.0])), limits)
        return ReleaseBatch.alone(
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

    def over(self, start: Floats, end: Floats, heights: tuple[Floats, Floats], limits: Limits) -> Segments:
        """Up, across and down: 21 segments."""
        return rectangle_segments(start, end, self.top(heights), limits)

    def top(self, heights: tuple[Floats, Floats]) -> Floats:
        """The height of the level part."""
        return np.maximum(*heights)

    def heights(self, pick: Floats, place: Floats, over_rims: Floats) -> tuple[Floats, Floats]:
        """As high above the pick as the ceiling of a throw, over all rims."""
        return pick[:, 2] + self._lift, np.maximum(over_rims, place[:, 2])


@final
class EllipseMover(PlacingMover):
    """Straight up, over half an ellipse that runs vertically at both ends, straight down (Choe et al. 2023).

    The hand rests where the straight parts meet the ellipse: the curvature jumps there, and with it the acceleration of
    any hand that moves.
    """

    def over(self, start: Floats, end: Floats, heights: tuple[Floats, Floats], limits: Limits) -> Segments:
        """Up, over and down; where both ends lie above each other as good as, up, across and down."""
        first, last = _at_height(start, heights[0]), _at_height(end, heights[1])
        top, columns = self.top(heights), PIECES + 14
        found = rectangle_segments(start, end, top, limits).padded(columns)
        way = last - first
        wide = np.flatnonzero(np.sqrt(way[:, 0] ** 2 + way[:, 1] ** 2) >= NARROW)
        if wide.size == 0:
            return found
        own = take(limits.arrays(len(start)), wide)
        up, down = rest_to_rest((first - start)[wide], own), rest_to_rest((end - last)[wide], own)
        arc = arc_segments(way[wide], (top - first[:, 2])[wide], own)
        return replaced(found, wide, joined([up, arc, down], axis=1))

    def top(self, heights: tuple[Floats, Floats]) -> Floats:
        """The highest point of the ellipse."""
        return np.maximum(*heights) + self.rules.crest

    def heights(self, pick: Floats, place: Floats, over_rims: Floats) -> tuple[Floats, Floats]:
        """Where the straight parts end."""
        vertical = self.rules.vertical
        return pick[:, 2] + vertical, np.maximum(over_rims, place[:, 2] + vertical)


def placed(release: ReleaseBatch) -> Bools:
    """Which releases put an object down at rest (N,)."""
    return release.feasible & (release.speed == 0.0)


def rectangle_segments(start: Floats, end: Floats, top: Floats, limits: Limits) -> Segments:
    """Motions straight up to a height (N,) [m], level, and straight down, from rest to rest each: 21 segments."""
    first, last = _at_height(start, top), _at_height(end, top)
    moves = [rest_to_rest(way, limits) for way in (first - start, last - first, end - last)]
    return joined(moves, axis=1)


def first_not_late(late: Callable[[Floats], Floats], low: Floats, high: Floats) -> tuple[Floats, Bools]:
    """Times (N,) in brackets (N,) from which on a lateness is not above 0 any more, and where there is one.

    By false position, in the Illinois form. It ends on the side where nothing is late, and a row's result does not
    depend on the other rows.

    Args:
        late: lateness (N,) at times (N,), near to a line.
        low: earliest times (N,).
        high: latest times (N,).
    """
    before, after = late(low), late(high)
    at_once, reached = before <= 0.0, after <= 0.0
    high, side = np.where(at_once, low, high), np.zeros_like(low)
    for _ in range(CHASES):
        rise = np.where(before > after, before - after, 1.0)
        middle = low + np.where(before > after, before / rise, 0.5) * (high - low)
        value = late(middle)
        good = value <= 0.0
        # An end that stays twice counts half, or false position would creep up from one side.
        before = np.where(good, np.where(side > 0.0, before / 2.0, before), value)
        after = np.where(good, value, np.where(side < 0.0, after / 2.0, after))
        low, high, side = np.where(good, low, middle), np.where(good, middle, high), np.where(good, 1.0, -1.0)
    return high, at_once | reached


def _at_height(points: Floats, height: Floats) -> Floats:
    """Points (N, 3) brought to heights (N,) [m]."""
    return np.concatenate([points[:, :2], height[:, None]], axis=1)


def _after_lift(pick: Floats, release: ReleaseBatch, limits: Limits) -> ReleaseBatch:
    """Releases of throws that begin above the picks."""
    rise = np.abs(_lifted(pick, release)[:, 2] - pick[:, 2])
    time = release.time + stroke_time(rise, *limits.arrays(len(pick)))
    return replace(release, time=time, straight=np.zeros(len(pick), dtype=np.bool_))


def _lifted(pick: Floats, release: ReleaseBatch) -> Floats:
    """Picks raised to the heights of their releases, where there are such (N, 3) [m]."""
    return _at_height(pick, np.where(release.feasible, release.position[:, 2], pick[:, 2]))
