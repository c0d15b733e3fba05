"""Where the next pick comes from: an independent draw, or the stream of objects on the moving belt."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, joined, replaced, take
from pnt_gym.cells.base.core import Generators
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.movers import ThrowMotion
from pnt_gym.cells.conveyor.objects import Objects
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.errors import ConfigError
from pnt_gym.planning.motion.limits import LimitRows
from pnt_gym.planning.motion.trajectory import Segments

MOST_DRAWS: Final = 120
"""Objects tried in a row before the cell is declared impossible."""
QUEUE: Final = 6
"""Objects known upstream of the pick window."""
STANDING_HEIGHT: Final = 0.05
"""Height of the next object where there is no belt to bring one [m]."""


@final
@dataclass(frozen=True)
class NextPick:
    """Where the hand goes after a throw, and the pick it finds there."""

    wait: Floats
    """Standstill above it until the object arrives (N,) [s]."""
    context: Context
    back: Segments
    """The motion there."""


class PickSource(ABC):
    """Abstract: hands out picks to some rows of a cell; every row draws only from its own generator."""

    def __init__(self, planner: PickPlanner, generators: Generators) -> None:
        self._planner = planner
        self._generators = generators

    @abstractmethod
    def first(self, rows: Ints) -> Context:
        """First picks of an episode for the cell's rows."""

    @abstractmethod
    def following(self, motion: ThrowMotion, limits: LimitRows, standing: Floats) -> NextPick:
        """The picks that follow the throws of all rows.

        Args:
            motion: the throws.
            limits: of the hand.
            standing: share of the pick window (N, 2) at which the next object stands, where no belt says it.
        """

    def waiting(self, row: int) -> tuple[Objects, Floats] | None:
        """The objects that come after one row's present pick, and their centres (K, 3) [m]; None without a belt."""
        return None

    def _impossible(self) -> ConfigError:
        config = self._planner.config
        return ConfigError(
            f"cell {config.name!r}: no object has a feasible throw; check that the bins are in reach at "
            f"{', '.join(f'{p:g}' for p in config.limits.percent)} % of the robot's limits and that the "
            f"follow-through of {config.motion.follow_through.window} s leaves room inside the workspace"
        )


@final
class IndependentPicks(PickSource):
    """Every pick is drawn anew and does not depend on the throw before: the contextual-bandit form."""

    def first(self, rows: Ints) -> Context:
        """One independent pick per row; objects are drawn until their throw is feasible."""
        context, good = self._attempt(rows)
        for _ in range(MOST_DRAWS):
            pending = np.flatnonzero(~good)
            if pending.size == 0:
                return context
            found, fits = self._attempt(rows[pending])
            context = replaced(context, pending, found)
            good[pending] = fits
        raise self._impossible()

    def following(self, motion: ThrowMotion, limits: LimitRows, standing: Floats) -> NextPick:
        """A new pick that has nothing to do with the throw before."""
        belt = self._planner.config.belt
        x = belt.pick_x[0] + (belt.pick_x[1] - belt.pick_x[0]) * standing[:, 0]
        y = belt.lane_y[0] + (belt.lane_y[1] - belt.lane_y[0]) * standing[:, 1]
        position = np.stack([x, y, np.full_like(x, belt.height + STANDING_HEIGHT)], axis=-1)
        back = self._planner.mover.back(motion, position, limits)
        return NextPick(np.zeros_like(x), self.first(np.arange(len(x))), back)

    def _attempt(self, rows: Ints) -> tuple[Context, Bools]:
        return self._planner.plan(*self._planner.draw_picks(self._generators, rows))


@final
class BeltPicks(PickSource):
    """Objects ride the belt past the robot; the hand meets the first one that it can reach and throw.

    Objects that leave the window before the hand is there, and those without a feasible throw, ride on.
    """

    def __init__(self, planner: PickPlanner, generators: Generators) -> None:
        super().__init__(planner, generators)
        count = len(generators)
        self.queue: Objects = planner.draw([np.random.default_rng(0)], np.zeros(count, dtype=np.int64), QUEUE)
        """Objects on the belt, nearest first (N, QUEUE)."""
        self.queue_x: Floats = np.zeros((count, QUEUE))
        """Where they are at the lift of the present pick (N, QUEUE) [m]."""
        self.passed: Ints = np.zeros(count, dtype=np.int64)
        """Objects let go since the episode began (N,)."""

    def first(self, rows: Ints) -> Context:
        """An empty belt with objects about to enter the window; the hand starts above its middle."""
        config = self._planner.config
        drawn = self._planner.draw(self._generators, rows, QUEUE)
        self.queue = replaced(self.queue, rows, drawn)
        # The first object enters the window one gap after the episode begins.
        self.queue_x[rows] = config.belt.pick_x[0] - np.cumsum(self.queue.gap[rows], axis=1)
        self.passed[rows] = 0
        middle = (config.belt.lane_y[0] + config.belt.lane_y[1]) / 2
        start = np.tile([0.0, middle, config.belt.height + 0.3], (len(rows), 1))
        limits = LimitRows.t3kr(np.full(len(rows), max(config.limits.percent)))
        return self.following(ThrowMotion.resting(start), limits, rows=rows).context

    def waiting(self, row: int) -> tuple[Objects, Floats] | None:
        """The objects upstream on the belt."""
        height = self._planner.config.belt.height + self.queue.size[row, :, 2] / 2
        centre = np.stack([self.queue_x[row], self.queue.lane_y[row], height], axis=-1)
        return take(self.queue, row), centre

    def following(
        self, motion: ThrowMotion, limits: LimitRows, standing: Floats | None = None, rows: Ints | None = None
    ) -> NextPick:
        """The first objects on the belt that can be met and thrown after throws of some rows; None for all rows."""
        rows = np.arange(len(motion.stop)) if rows is None else rows
        result, pending = None, np.arange(len(rows))
        for draw in range(MOST_DRAWS):
            place = draw % QUEUE
            if place == 0 and draw > 0:  # the whole queue rides on
                self._roll(rows[pending], QUEUE, np.zeros(pending.size))
            found, time, good = self._meet(rows[pending], place, take(motion, pending), take(limits, pending))
            result = found if result is None else replaced(result, pending, found)
            self._roll(rows[pending[good]], place + 1, time[good])
            pending = pending[~good]
            if pending.size == 0:
                return result
        raise self._impossible()

    def _meet(self, rows: Ints, place: int, motion: ThrowMotion, limits: LimitRows) -> tuple[NextPick, Floats, Bools]:
        """Pick of the object at a place of the queue in some rows, the time until its lift, and which work out."""
        config, objects = self._planner.config, take(self.queue, (rows, place))
        x = self.queue_x[rows, place] + config.belt.speed * motion.stop_time
        meeting = self._planner.mover.meet(motion, self._planner.pick_point(objects, x), limits)
        context, throwable = self._planner.plan(objects, meeting.position)
        found = NextPick(meeting.wait, context, meeting.back)
        elapsed = motion.stop_time + meeting.time + config.motion.dwell
        return found, elapsed, meeting.feasible & throwable

    def _roll(self, rows: Ints, used: int, elapsed: Floats) -> None:
        """Move the belt on, drop the objects that were picked or passed, and add new ones upstream."""
        if rows.size == 0:
            return
        self.passed[rows] += used - 1
        new = self._planner.draw(self._generators, rows, used)
        kept = take(self.queue, (rows, slice(used, None)))
        x = self.queue_x[rows] + self._planner.config.belt.speed * elapsed[:, None]
        self.queue = replaced(self.queue, rows, joined([kept, new], axis=1))
        self.queue_x[rows] = np.concatenate([x[:, used:], x[:, -1:] - np.cumsum(new.gap, axis=1)], axis=1)
