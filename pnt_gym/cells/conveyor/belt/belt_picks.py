"""Picks of objects that ride the belt past the robot, in the order of a dispatching rule."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, replace_rows, take, take_rows
from pnt_gym.cells.base.cell import Generators
from pnt_gym.cells.conveyor.belt.sources import MOST_DRAWS, NextPick, PickSource
from pnt_gym.cells.conveyor.belt.stream import (
    AWAY,
    PASSED_PLACES,
    BeltStream,
    Carried,
    Neighbours,
    course,
    sweeps_through,
)
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.cup.hold import Grips
from pnt_gym.cells.conveyor.movers.straight import Meeting, ThrowMotion
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.errors import ConfigError
from pnt_gym.planning import dispatch
from pnt_gym.planning.dispatch import Candidates, Rule
from pnt_gym.planning.motion.intercept import HORIZON
from pnt_gym.planning.motion.limits import LimitRows

SHORTEST_QUEUE: Final = 6
"""Length of a queue whose objects are tried in their order."""
LONGEST_QUEUE: Final = 32
"""Largest length of a queue from which the best object is taken."""


@final
@dataclass(frozen=True)
class PlannedPicks:
    """P objects that hands could pick next and throw, as planned to compare them."""

    meeting: Meeting
    """Meetings of hands and objects."""
    context: Context
    throwable: Bools
    """Which objects can be met and thrown (P,)."""


@final
@dataclass(frozen=True)
class RankedPicks:
    """P planned picks of objects in queues, by their places."""

    index: Ints
    """Index of the pick of the object at each place of a queue (K, Q); -1 where the object leaves before a pick."""
    picks: PlannedPicks
    motion: ThrowMotion
    """Motions of the throws of the objects that can be thrown, in their order."""

    def at(self, rows: Ints, places: Ints) -> PlannedPicks:
        """Picks of the objects at one place per row; the last pick stands in for index -1, as not throwable."""
        index = self.index[rows, places]
        picks = take(self.picks, index)
        return PlannedPicks(picks.meeting, picks.context, picks.throwable & (index >= 0))

    def motions(self, rows: Ints, places: Ints) -> ThrowMotion:
        """Motions of throwable objects at one place per row."""
        return take(self.motion, (np.cumsum(self.picks.throwable) - 1)[self.index[rows, places]])


@final
class BeltPicks(PickSource):
    """Picks of objects that ride the belt past the robot; a dispatching rule chooses the next feasible object.

    The rule `first` takes the most downstream feasible object, and all objects before it leave unpicked. With any other
    rule the remaining objects stay in the queue until they leave the window.
    """

    def __init__(self, planner: PickPlanner, generators: Generators) -> None:
        super().__init__(planner, generators)
        self._belt = planner.config.belt
        self._dwell = planner.config.motion.dwell
        self._rule: Rule = planner.config.dispatch
        self._patience = planner.config.patience
        # The planner with which a rule compares objects; the chosen object is planned by the cell's planner.
        quick = {"free_direction": "straight", "straight_flying": "straight", "ellipse": "pick_and_place"}.get(
            planner.config.planner
        )
        self._estimator = (
            planner if quick is None else PickPlanner(planner.config.model_copy(update={"planner": quick}))
        )
        self._solid = planner.config.belt.neighbours == "solid"
        belt, items, length = self._belt, planner.config.item_list(), SHORTEST_QUEUE
        if self._rule != "first":
            # Rules that compare objects see about those downstream of the camera.
            long = np.mean([item.size[:2] for item in items]) if belt.gap == "edge" else 0.0
            count = np.ceil((belt.pick_x[1] - belt.camera_x) / (np.mean(belt.spacing) + long))
            length = int(np.clip(count, SHORTEST_QUEUE, LONGEST_QUEUE))
        self.stream = BeltStream(planner, generators, length)

    def first(self, rows: Ints) -> Context:
        """An empty belt with objects about to enter the window; the hand starts above its middle."""
        config = self._planner.config
        self.stream.begin(rows)
        middle = (config.belt.lane_y[0] + config.belt.lane_y[1]) / 2
        start = np.tile([0.0, middle, config.belt.height + 0.3], (len(rows), 1))
        limits = config.robot.limits(np.full(len(rows), max(config.limits.percent)))
        return self.following(ThrowMotion.resting(start), limits, rows=rows).context

    def waiting(self, row: int) -> tuple[Objects, Floats] | None:
        """The objects on the belt, also those that can no longer be picked, and their centres (K, 3) [m]."""
        objects, x = take(take(self.stream.objects, [row]), 0), self.stream.x[row].copy()
        height = self._planner.config.belt.height + objects.size[:, 2] / 2
        return objects, np.stack([x, objects.draws.lane_y, height], axis=-1)

    def following(
        self, motion: ThrowMotion, limits: LimitRows, standing: Floats | None = None, rows: Ints | None = None
    ) -> NextPick:
        """The next picks after throws of some rows, by the rule; `rows` None: all rows.

        Raises:
            ConfigError: no object of the level can be picked and thrown.
        """
        rows = np.arange(len(motion.stop)) if rows is None else rows
        result, pending, length = None, np.arange(len(rows)), self.stream.length
        self.passed[rows] = 0
        for _ in range(-(-MOST_DRAWS // length)):
            hands, hand_limits = take_rows((motion, limits), pending, len(rows))
            picks, place, elapsed = self._choose_picks(rows[pending], hands, hand_limits)
            result = picks if result is None else replace_rows(result, pending, picks)
            # Objects that leave unpicked until the lift: without a feasible object all of them.
            gone = place
            if self._rule != "first":
                out = self.stream.queue_x[rows[pending]] + self._belt.speed * elapsed[:, None] > self._belt.pick_x[1]
                out &= np.arange(length) != place[:, None]
                gone = np.where(place < length, out.sum(axis=1), length)
            self.passed[rows[pending]] += gone
            self.stream.ride(rows[pending], place, gone, self._belt.speed * elapsed)
            pending = pending[place == length]
            if pending.size == 0:
                return result
        belt = self._belt
        if belt.spacing[0] <= belt.speed * HORIZON:
            raise self._impossible()
        raise ConfigError(
            f"belt.spacing starts at {belt.spacing[0]:g} m and belt.speed is {belt.speed:g} m/s: nobody waits "
            f"longer than {HORIZON:g} s for an object; let spacing start at {belt.speed * HORIZON:g} m or less"
        )

    def _choose_picks(self, rows: Ints, motion: ThrowMotion, limits: LimitRows) -> tuple[NextPick, Ints, Floats]:
        """The chosen picks in some rows (K,), their places in the queue, and the times until their lifts [s].

        The place of a row without a feasible object is the queue's length.
        """
        result, pending = None, np.arange(len(rows))
        places, elapsed = np.full(len(rows), self.stream.length), np.zeros(len(rows))
        order, ranked = self._order(rows, motion, limits)
        for at in order.T:
            belt_rows, place = rows[pending], at[pending]
            if ranked is None:
                hands, hand_limits = take((motion, limits), pending)
                picks = self._plan_picks(self._planner, *self.stream.in_queue(belt_rows, place), hands, hand_limits)
            else:
                picks = ranked.at(pending, place)
            time = motion.stop_time[pending] + picks.meeting.time + self._dwell
            good = picks.throwable & ~self.stream.knocked[belt_rows, PASSED_PLACES + place]
            best = good
            if self._solid:
                throws = None if ranked is None else ranked.motions(pending[good], place[good])
                best = self._sweeps_none(belt_rows, place, picks.context, time, good, throws)
            # The first feasible object is kept until a feasible object is found whose throw touches no neighbour.
            better = best | (places[pending] == self.stream.length)
            into = pending[better]
            result = picks if result is None else replace_rows(result, into, take(picks, better))
            into, chosen = pending[better & good], better & good
            places[into], elapsed[into] = place[chosen], time[chosen]
            pending = pending[~best]
            if pending.size == 0:
                break
        assert result is not None  # a queue is never empty
        back = self._planner.mover.approach(motion, result.meeting, limits)
        return NextPick(result.meeting.wait, result.context, back), places, elapsed

    def find_collisions(self, context: Context, motion: ThrowMotion, grips: Grips) -> Bools:
        """Which of all stored objects (N, PASSED_PLACES + Q) the carried objects sweep through."""
        step, stream = self._planner.config.timestep, self.stream
        let_go = motion.release_time + context.objects.delay
        free_at = np.where(grips.dropped, grips.lost_at * step, let_go)
        way = course(motion.path.table, motion.pick, free_at, self._belt.speed)
        o, around = context.objects, stream.objects
        carried = Carried(o.shape, o.size, o.yaw, context.pick, way)
        others = Neighbours(around.shape, around.size, around.yaw, stream.places(np.arange(len(way))))
        return sweeps_through(carried, others) & grips.picked[:, None]

    def knock(self, objects: Bools) -> None:
        """Mark objects (N, PASSED_PLACES + Q) as knocked; where neighbours are ghosts, nothing happens."""
        if self._solid:
            self.stream.knocked |= objects

    @contextmanager
    def hold_back(self, rows: Bools) -> Generator[None]:
        """Context at whose end the belts of some rows (N,) are as at its beginning."""
        stream, held = self.stream, rows.nonzero()[0]
        objects, x, knocked = take(stream.objects, held), stream.x[held], stream.knocked[held]
        with super().hold_back(rows):
            yield
        stream.objects.put(held, objects)
        stream.x[held], stream.knocked[held] = x, knocked

    def ride(self, rows: Ints, time: float) -> None:
        """Move the belts of some rows on for a time [s]."""
        self.stream.x[rows] += self._belt.speed * time

    def _sweeps_none(
        self, rows: Ints, at: Ints, context: Context, elapsed: Floats, good: Bools, motion: ThrowMotion | None
    ) -> Bools:
        """Which feasible objects at places of queues (K,), lifted after a time (K,) [s], sweep no others when thrown.

        The check uses measured values of all objects; objects that are not `good` are skipped. The motions are those of
        the good throws; None: plan them here.
        """
        candidates = good.nonzero()[0]
        rows, at, throws = rows[candidates], at[candidates], take_rows(context, candidates, len(good))
        if motion is None:
            motion = self._planner.mover.throw(throws.pick, throws.plan, throws.throw_limits, throws.ceiling)
        place = self.stream.places(rows)
        place[..., 0] += self._belt.speed * elapsed[candidates, None]
        place[np.arange(len(candidates)), PASSED_PLACES + at] = AWAY
        o, around = throws.objects.measured, take(self.stream.objects.measured, rows)
        way = course(motion.path.table, motion.pick, motion.release_time, self._belt.speed)
        carried = Carried(o.shape, o.size, o.yaw, throws.pick, way)
        others = Neighbours(around.shape, around.size, around.yaw, place)
        free = np.zeros(len(good), dtype=np.bool_)
        free[candidates] = ~sweeps_through(carried, others).any(axis=1)
        return free

    def _order(self, rows: Ints, motion: ThrowMotion, limits: LimitRows) -> tuple[Ints, RankedPicks | None]:
        """Places of the queues of some rows in the order in which to try them (K, Q), and picks already planned."""
        shape = len(rows), self.stream.length
        if self._rule == "first":
            return np.broadcast_to(np.arange(self.stream.length), shape), None
        ahead = self.stream.queue_x[rows] + self._belt.speed * motion.stop_time[:, None] <= self._belt.pick_x[1]
        ahead &= ~self.stream.knocked[rows, PASSED_PLACES:]
        row, place = np.nonzero(ahead)
        objects, x = self.stream.in_queue(rows[row], place)
        picks = self._plan_picks(self._estimator, objects, x, *take((motion, limits), row))
        # Priorities of the picks by the rule, and the motions of those that are throwable.
        context, good = picks.context, picks.throwable
        throws, throwing = take_rows(context, good.nonzero()[0], len(good)), np.zeros(len(good))
        motions = self._estimator.mover.throw(throws.pick, throws.plan, throws.throw_limits, throws.ceiling)
        throwing[good] = motions.stop_time
        start = picks.meeting.time + self._dwell
        stays = (self._belt.pick_x[1] - context.pick[:, 0]) / self._belt.speed
        among = Candidates(np.ones(len(good)), start + throwing, start, start + stays, good)
        ranks = np.full(shape, -np.inf)
        ranks[row, place] = dispatch.index(self._rule, among, self._patience)
        order = np.argsort(-ranks, axis=1, kind="stable")
        if self._estimator is not self._planner or len(row) == 0:
            return order, None
        index = np.full(shape, -1)
        index[row, place] = np.arange(len(row))
        return order, RankedPicks(index, picks, motions)

    def _plan_picks(
        self, planner: PickPlanner, objects: Objects, x: Floats, motion: ThrowMotion, limits: LimitRows
    ) -> PlannedPicks:
        """Picks and throws of objects at positions x along the belt when the throws of the hands begin (P,) [m]."""
        meeting = planner.mover.reach(
            motion, self._planner.pick_point(objects, x + self._belt.speed * motion.stop_time), limits
        )
        context, throwable = planner.plan(objects, meeting.position)
        return PlannedPicks(meeting, context, meeting.feasible & throwable)
