"""Where the next pick comes from: an independent draw, or the stream of objects on the moving belt."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, Protocol, final

import numpy as np

from pnt_gym.cells.context import Context
from pnt_gym.cells.motion import ThrowMotion
from pnt_gym.cells.movers import Return
from pnt_gym.cells.objects import Objects, draw_objects
from pnt_gym.cells.picks import PickPlanner
from pnt_gym.errors import ConfigError
from pnt_gym.planning.arrays import Bools, Floats, Ints
from pnt_gym.planning.limits import MotionLimits
from pnt_gym.rows import put, take

Generators = list[np.random.Generator]

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

    position: Floats
    """Cup position of the next pick (N, 3) [m]."""
    wait: Floats
    """Standstill above it until the object arrives (N,) [s]."""
    context: Context
    back: Return
    """The motion there."""


class PickSource(Protocol):
    """Hands out picks to some rows of a cell; every row draws only from its own generator."""

    def first(self, rows: Ints, generators: Generators) -> Context:
        """First picks of an episode for the cell's rows, seeded by one generator each."""
        ...

    def following(self, motion: ThrowMotion, limits: MotionLimits) -> NextPick:
        """The picks that follow the throws of all rows."""
        ...

    def waiting(self, row: int) -> tuple[Objects, Floats] | None:
        """The objects that come after one row's present pick, and their centres (K, 3) [m]; None without a belt."""
        ...


@final
class IndependentPicks:
    """Every pick is drawn anew and does not depend on the throw before: the contextual-bandit form."""

    def __init__(self, planner: PickPlanner, count: int) -> None:
        self._planner = planner
        self._generators: Generators = [np.random.default_rng() for _ in range(count)]
        self._place = np.zeros((count, 2))

    def first(self, rows: Ints, generators: Generators) -> Context:
        """One independent pick per row."""
        for row, generator in zip(rows, generators, strict=True):
            self._generators[row] = generator
        return self._draw(rows)

    def following(self, motion: ThrowMotion, limits: MotionLimits) -> NextPick:
        """A new pick that has nothing to do with the throw before."""
        # The next object stands somewhere in the pick window; that draw belongs to the present pick.
        belt = self._planner.config.belt
        x = belt.pick_x[0] + (belt.pick_x[1] - belt.pick_x[0]) * self._place[:, 0]
        y = belt.lane_y[0] + (belt.lane_y[1] - belt.lane_y[0]) * self._place[:, 1]
        position = np.stack([x, y, np.full_like(x, belt.height + STANDING_HEIGHT)], axis=-1)
        back = self._planner.mover.back(motion, position, limits)
        return NextPick(position, np.zeros_like(x), self._draw(np.arange(len(x))), back)

    def waiting(self, row: int) -> tuple[Objects, Floats] | None:
        """Nothing: there is no belt."""
        return None

    def _draw(self, rows: Ints) -> Context:
        """Objects are drawn until their throw is feasible."""
        context, good = self._attempt(rows)
        for _ in range(MOST_DRAWS):
            pending = np.flatnonzero(~good)
            if pending.size == 0:
                self._place[rows] = context.objects.place[:, 1:3]
                return context
            found, fits = self._attempt(rows[pending])
            put(context, pending, found)
            good[pending] = fits
        raise _impossible(self._planner)

    def _attempt(self, rows: Ints) -> tuple[Context, Bools]:
        config = self._planner.config
        objects = take(draw_objects([self._generators[r] for r in rows], 1, config), np.s_[:, 0])
        low, high = config.belt.pick_x
        x = low + (high - low) * objects.place[:, 0]
        return self._planner.plan(objects, self._planner.pick_point(objects, x))


@final
class BeltPicks:
    """Objects ride the belt past the robot; the hand meets the first one that it can reach and throw.

    Objects that leave the window before the hand is there, and those without a feasible throw, ride on.
    """

    def __init__(self, planner: PickPlanner, count: int) -> None:
        self._planner = planner
        self._generators: Generators = [np.random.default_rng() for _ in range(count)]
        generators = [np.random.default_rng(0) for _ in range(count)]
        self.queue: Objects = draw_objects(generators, QUEUE, planner.config)
        """Objects on the belt, nearest first (N, QUEUE)."""
        self.queue_x: Floats = np.zeros((count, QUEUE))
        """Where they are at the lift of the present pick (N, QUEUE) [m]."""
        self.passed: Ints = np.zeros(count, dtype=np.int64)
        """Objects let go since the episode began (N,)."""

    def first(self, rows: Ints, generators: Generators) -> Context:
        """An empty belt with objects about to enter the window; the hand starts above its middle."""
        config = self._planner.config
        for row, generator in zip(rows, generators, strict=True):
            self._generators[row] = generator
        put(self.queue, rows, draw_objects(generators, QUEUE, config))
        # The first object enters the window one gap after the episode begins.
        self.queue_x[rows] = config.belt.pick_x[0] - np.cumsum(self.queue.gap[rows], axis=1)
        self.passed[rows] = 0
        middle = (config.belt.lane_y[0] + config.belt.lane_y[1]) / 2
        start = np.tile([0.0, middle, config.belt.height + 0.3], (len(rows), 1))
        limits = MotionLimits.t3kr(np.full(len(rows), max(config.limits.percent)))
        return self._next(rows, ThrowMotion.resting(start), limits, MOST_DRAWS // QUEUE).context

    def following(self, motion: ThrowMotion, limits: MotionLimits) -> NextPick:
        """The first object on the belt that can be met and thrown after these throws."""
        rows = np.arange(len(motion.stop))
        return self._next(rows, motion, limits, MOST_DRAWS // QUEUE)

    def waiting(self, row: int) -> tuple[Objects, Floats] | None:
        """The objects upstream on the belt."""
        height = self._planner.config.belt.height + self.queue.size[row, :, 2] / 2
        centre = np.stack([self.queue_x[row], self.queue.lane_y[row], height], axis=-1)
        return take(self.queue, row), centre

    def _next(self, rows: Ints, motion: ThrowMotion, limits: MotionLimits, queues: int) -> NextPick:
        """The first object that can be met and thrown, for each row; looks through at most so many queues."""
        if queues == 0:
            raise _impossible(self._planner)
        result, time, chosen = self._search(rows, motion, limits)
        found, missing = np.flatnonzero(chosen >= 0), np.flatnonzero(chosen < 0)
        elapsed = motion.stop_time + time + self._planner.config.motion.dwell
        self._roll(rows[found], chosen[found] + 1, elapsed[found])
        if missing.size > 0:
            self._roll(rows[missing], np.full(missing.size, QUEUE), np.zeros(missing.size))
            again = self._next(rows[missing], take(motion, missing), limits.take(missing), queues - 1)
            put(result, missing, again)
        return replace(result, context=replace(result.context))

    def _search(self, rows: Ints, motion: ThrowMotion, limits: MotionLimits) -> tuple[NextPick, Floats, Ints]:
        """Meeting of each row's first suitable object, its time, and its place in the queue (-1: none)."""
        queue, x = take(self.queue, rows), self.queue_x[rows] + self._speed * motion.stop_time[:, None]
        pending = np.arange(len(rows))
        result, time, good = self._meet(take(queue, np.s_[:, 0]), x[:, 0], motion, limits, pending)
        chosen = np.where(good, 0, -1)
        for place in range(1, QUEUE):
            pending = np.flatnonzero(chosen < 0)
            if pending.size == 0:
                break
            found, later, good = self._meet(take(queue, np.s_[:, place]), x[:, place], motion, limits, pending)
            put(result, pending, found)
            time[pending] = later
            chosen[pending[good]] = place
        return result, time, chosen

    @property
    def _speed(self) -> float:
        return self._planner.config.belt.speed

    def _meet(
        self, objects: Objects, x: Floats, motion: ThrowMotion, limits: MotionLimits, rows: Ints
    ) -> tuple[NextPick, Floats, Bools]:
        """Meeting, its time, and pick for one object of each of some rows, and which of them work out."""
        some = take(objects, rows)
        point = self._planner.pick_point(some, x[rows])
        meeting = self._planner.mover.meet(take(motion, rows), point, limits.take(rows))
        context, throwable = self._planner.plan(some, meeting.position)
        found = NextPick(meeting.position, meeting.wait, context, meeting.back)
        return found, meeting.time, meeting.feasible & throwable

    def _roll(self, rows: Ints, used: Ints, elapsed: Floats) -> None:
        """Move the belt on, drop the objects that were picked or passed, and add new ones upstream."""
        self.passed[rows] += used - 1
        self.queue_x[rows] += self._speed * elapsed[:, None]
        for row, count in zip(rows, used, strict=True):
            new = take(draw_objects([self._generators[row]], int(count), self._planner.config), 0)
            keep = take(self.queue, (row, slice(count, None)))
            put(self.queue, (row, slice(None, QUEUE - count)), keep)
            put(self.queue, (row, slice(QUEUE - count, None)), new)
            last = self.queue_x[row, -1]
            self.queue_x[row, : QUEUE - count] = self.queue_x[row, count:].copy()
            self.queue_x[row, QUEUE - count :] = last - np.cumsum(new.gap)


def _impossible(planner: PickPlanner) -> ConfigError:
    return ConfigError(
        f"cell {planner.config.name!r}: no object has a feasible throw; check that the bins are in reach at "
        f"{', '.join(f'{p:g}' for p in planner.config.limits.percent)} % of the robot's limits and that the "
        f"follow-through of {planner.config.motion.follow_through.window} s leaves room inside the workspace"
    )
