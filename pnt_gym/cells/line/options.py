"""What robots of a line could do next: every object that each can meet, into every bin that takes it, by the planner.

Times and feasibility are those of the conveyor's own planner, so what a robot decides by is what it then does.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, NamedTuple, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, joined, take
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.movers.straight import ThrowMotion
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.cells.line.state import PicksAndThrows
from pnt_gym.planning.motion.limits import LimitRows

AWAY: Final = 1e6
"""Where objects are that nobody may take [m]."""


@final
@dataclass(frozen=True)
class Options(PicksAndThrows):
    """All that could be done next, S = (C,)."""

    row: Ints
    """In which of K lines."""
    place: Ints
    """Which object in sight there."""


class Sight(NamedTuple):
    """What the camera and the belt's encoder know of K lines: W objects each, the most downstream first."""

    line: Ints
    """Which lines (K,)."""
    which: Ints
    """Objects of their streams (K, W)."""
    x: Floats
    """Where they are along the belt (K, W) [m]; `AWAY` where nobody may take one."""
    seen: Ints
    """As what they are seen (K, W)."""


class Turn(NamedTuple):
    """Whose turn it is in K lines, and what it may take of what is seen there."""

    sight: Sight
    """With x from the robot's base."""
    hand: Floats
    """Where the hand stands still, from its base (K, 3) [m]."""


@final
class Robots:
    """Robots that are alike: their bins and speed settings.

    Args:
        config: one of them as a conveyor cell.
        horizon: how far ahead an object may be taken [s].
    """

    def __init__(self, config: ConveyorConfig, horizon: float) -> None:
        self.planner = PickPlanner(config)
        self._config, self._horizon = config, horizon
        self._accepts = config.acceptance()
        self._percent = np.array(config.limits.percent)

    def begin(self) -> Floats:
        """Where hands stand when a shift begins: above the middle of the belt (3,) [m]."""
        belt = self._config.belt
        return np.array([0.0, (belt.lane_y[0] + belt.lane_y[1]) / 2, belt.height + 0.3])

    def options(self, turn: Turn, objects: Objects) -> Options:
        """All that can be done.

        Args:
            turn: whose turn it is, in K lines.
            objects: of all N lines (N, M).
        """
        sight = turn.sight
        row, place = np.nonzero(self.near(sight.x))
        which, bins = np.nonzero(self._accepts[sight.seen[row, place]])
        settings = len(self._percent)
        row, place = np.repeat(row[which], settings), np.repeat(place[which], settings)
        percent = np.tile(self._percent, len(which))
        return self._planned(turn, (row, place), objects, np.repeat(bins, settings), percent)

    def near(self, x: Floats) -> Bools:
        """Whether what is somewhere along the belt, from the robot's base [m], can be in the window in time."""
        (low, high), speed = self._config.belt.pick_x, self._config.belt.speed
        return (x <= high) & (x >= low - speed * self._horizon)

    def _planned(self, turn: Turn, at: tuple[Ints, Ints], objects: Objects, bins: Ints, percent: Floats) -> Options:
        """Those of candidates (C,) that can be met in time and thrown."""
        belt, mover, sight = self._config.belt, self.planner.mover, turn.sight
        which = sight.line[at[0]], sight.which[at]
        height = self.planner.height(objects.size[which], objects.known_depth[which])
        place = np.stack([sight.x[at], objects.draws.lane_y[which], height], axis=-1)
        meeting = mover.reach(ThrowMotion.resting(turn.hand[at[0]]), place, LimitRows.t3kr(percent))
        met = np.flatnonzero(meeting.feasible & (meeting.time <= self._horizon))
        thrown = replace(take(objects, (which[0][met], which[1][met])), percent=percent[met])
        context, good = self.planner.plan_into(thrown, meeting.position[met], bins[met])
        rows, pick, target = met[good], context.pick[good], context.target[good]
        motion = mover.throw(
            pick, take(context.plan, good), take(context.throw_limits, good), take(context.ceiling, good)
        )
        lift = meeting.time[rows] + self._config.motion.dwell
        return Options(
            row=at[0][rows],
            place=at[1][rows],
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


def of_all(parts: list[Options]) -> Options:
    """Options of several lines, in the order of the lines."""
    found = joined(parts)
    return take(found, np.argsort(found.row, kind="stable"))
