"""Options of a line's robots: every object that a robot can meet, into every bin that takes the object, as planned.

Times and feasibility come from the conveyor's planner, so a chosen option is executed with the same values.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, NamedTuple, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, concatenate_records, take
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.movers.straight import ThrowMotion
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.cells.line.state import PicksAndThrows
from pnt_gym.planning.motion.limits import LimitRows

UNAVAILABLE_X: Final = 1e6
"""Position along the belt of objects that the robot cannot take [m]."""


@final
@dataclass(frozen=True)
class Options(PicksAndThrows):
    """Possible picks and throws, S = (C,)."""

    row: Ints
    """Index of the line among K lines."""
    place: Ints
    """Index of the object among the line's objects in sight."""


class Sight(NamedTuple):
    """Objects that camera and encoder know in K lines: W objects each, the most downstream first."""

    line: Ints
    """Indices of the lines (K,)."""
    object_index: Ints
    """Indices of the objects in their streams (K, W)."""
    x: Floats
    """Position along the belt (K, W) [m]; `UNAVAILABLE_X` where the object may not be taken."""
    kind: Ints
    """Item as which the camera classifies the object (K, W)."""


class Turn(NamedTuple):
    """Sight and hand of the deciding robot in K lines."""

    sight: Sight
    """Sight with x from the robot's base."""
    hand: Floats
    """Position at which the hand stands still, from its base (K, 3) [m]."""


@final
class RobotKind:
    """Robots with the same bins and speed settings.

    Args:
        config: one of these robots as a conveyor cell.
        horizon: time within which an object may be taken [s].
    """

    def __init__(self, config: ConveyorConfig, horizon: float) -> None:
        self.planner = PickPlanner(config)
        self._config, self._horizon = config, horizon
        self._accepts = config.acceptance()
        self._percent = np.array(config.limits.percent)

    def initial_hand(self) -> Floats:
        """Position of hands when a shift begins: above the middle of the belt (3,) [m]."""
        belt = self._config.belt
        return np.array([0.0, (belt.lane_y[0] + belt.lane_y[1]) / 2, belt.height + 0.3])

    def options(self, turn: Turn, objects: Objects) -> Options:
        """Options of the deciding robots.

        Args:
            turn: sight and hand of the deciding robot in K lines.
            objects: objects of all N lines (N, M).
        """
        sight = turn.sight
        row, place = np.nonzero(self.near(sight.x))
        candidates, bins = np.nonzero(self._accepts[sight.kind[row, place]])
        settings = len(self._percent)
        row, place = np.repeat(row[candidates], settings), np.repeat(place[candidates], settings)
        percent = np.tile(self._percent, len(candidates))
        return self._plan_candidates(turn, (row, place), objects, np.repeat(bins, settings), percent)

    def near(self, x: Floats) -> Bools:
        """Whether an object at a place along the belt, from the robot's base [m], reaches the window in time."""
        (low, high), speed = self._config.belt.pick_x, self._config.belt.speed
        return (x <= high) & (x >= low - speed * self._horizon)

    def _plan_candidates(
        self, turn: Turn, candidate: tuple[Ints, Ints], objects: Objects, bins: Ints, percent: Floats
    ) -> Options:
        """Options among candidates (C,): objects that can be met in time and thrown."""
        belt, mover, sight = self._config.belt, self.planner.mover, turn.sight
        objects_index = sight.line[candidate[0]], sight.object_index[candidate]
        height = self.planner.height(objects.size[objects_index], objects.known_depth[objects_index])
        place = np.stack([sight.x[candidate], objects.draws.lane_y[objects_index], height], axis=-1)
        meeting = mover.reach(ThrowMotion.resting(turn.hand[candidate[0]]), place, LimitRows.t3kr(percent))
        met = np.flatnonzero(meeting.feasible & (meeting.time <= self._horizon))
        throws = replace(take(objects, (objects_index[0][met], objects_index[1][met])), percent=percent[met])
        context, feasible = self.planner.plan_into(throws, meeting.position[met], bins[met])
        rows, pick, target = met[feasible], context.pick[feasible], context.target[feasible]
        motion = mover.throw(
            pick, take(context.plan, feasible), take(context.throw_limits, feasible), take(context.ceiling, feasible)
        )
        lift = meeting.time[rows] + self._config.motion.dwell
        return Options(
            row=candidate[0][rows],
            place=candidate[1][rows],
            bin=bins[rows],
            percent=percent[rows],
            pick=pick,
            away=target[:, :2] - pick[:, :2],
            lift=lift,
            wait=meeting.wait[rows],
            leave=lift + (belt.pick_x[1] - pick[:, 0]) / belt.speed,
            throwing=motion.stop_time,
            stop=motion.stop,
        )


def merge_options(parts: list[Options]) -> Options:
    """Options of several lines, merged in the order of the lines."""
    options = concatenate_records(parts)
    return take(options, np.argsort(options.row, kind="stable"))
