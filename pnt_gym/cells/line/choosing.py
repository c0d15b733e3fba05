"""Choices of the robots that decide next: the best options of each robot, with their features."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any, Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, replace_rows, take
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.cells.line.chances import Chances
from pnt_gym.cells.line.config import LineConfig, distinct_cells
from pnt_gym.cells.line.options import UNAVAILABLE_X, Options, RobotKind, Sight, Turn, merge_options
from pnt_gym.cells.line.state import CHOICES, Choices, LineState, PicksAndThrows
from pnt_gym.cells.line.stream import Stream
from pnt_gym.errors import ConfigError

NEAR: Final = 0.25
"""Objects within this distance along the belt from where a hand stops count as near it [m]."""
IDLE_TIME: Final = 0.1
"""Time after which a robot looks again if it has nothing to take or takes nothing [s]."""
LONGEST_PAUSE: Final = 1.0
"""A robot looks again after this time even if nothing is near, since an object that another robot failed to pick comes
unannounced [s]."""
_TRIALS: Final = 200


@final
class Chooser:
    """Finds the choices of robots.

    Args:
        config: level of the line.
        cells: the robots as conveyor cells.
        chances: table of the robots' throws.

    Raises:
        ConfigError: a robot can take nothing.
    """

    def __init__(self, config: LineConfig, cells: list[ConveyorConfig], chances: Chances) -> None:
        from pnt_gym.cells.line.lie import in_sight  # noqa: PLC0415 - numba takes a while

        self._config, self._chances, self._in_sight = config, chances, in_sight
        different, self._kind_of = distinct_cells(cells)
        self._kinds = [RobotKind(cell, config.horizon) for cell in different]
        self._can_take, self._places = config.can_take(), config.robot_x()
        self._blank_choice, self._blank_context = self._sample_choice()

    @property
    def planner(self) -> PickPlanner:
        """Planner of the robot with the most bins; apart from the fill of bins, all planners draw the same objects."""
        return max((kind.planner for kind in self._kinds), key=lambda planner: len(planner.areas))

    def robot_kind(self, robot: int) -> RobotKind:
        """The kind of robots to which a robot belongs."""
        return self._kinds[int(self._kind_of[robot])]

    def initial_hand(self) -> Floats:
        """Position of hands when a shift begins (3,) [m]."""
        return self._kinds[0].initial_hand()

    def empty_choices(self, count: int) -> Choices:
        """Choices of N lines without any real choice."""
        return take(self._blank_choice, np.zeros((count, CHOICES), dtype=np.int64))

    def find_choices(self, state: LineState, stream: Stream, sight: Sight) -> Choices:
        """Choices of the deciding robots in the lines of a sight (K, CHOICES)."""
        lines, robot = sight.line, state.robot[sight.line]
        options = self.options(stream.objects, sight, robot, state.hand[lines, robot])
        objects = options.row, options.place
        worth, chance = stream.worth[lines[options.row], sight.object_index[objects]], self.chance(sight, options)
        # Options are ranked by expected value less the price of their time.
        place, selected = self._rank(options.row, worth * chance - self._config.price_of_time * options.cycle)
        options, place = take(options, selected), place[selected]
        choices = _make_choices(
            options,
            real=np.ones(len(selected), dtype=np.bool_),
            index=sight.object_index[options.row, options.place],
            value=worth[selected],
            chance=chance[selected],
            **self._choice_features(options, take(sight, options.row), robot[options.row]),
        )
        return replace_rows(self.empty_choices(len(lines)), (options.row, place), choices)

    def plan_choices(self, robot: Ints, stream: Stream, choices: Choices) -> Context:
        """Picks and throws of choices (N,) of robots (N,), one in each line; arbitrary where not real.

        Each throw is planned a second time here, because storing the first plan would take hundreds of numbers for each
        choice.
        """
        context = take(self._blank_context, np.zeros(len(robot), dtype=np.int64))
        for index, kind in enumerate(self._kinds):
            rows = np.flatnonzero(choices.real & (self._kind_of[robot] == index))
            kind_choices = take(choices, rows)
            objects = replace(take(stream.objects, (rows, kind_choices.index)), percent=kind_choices.percent)
            context = (
                replace_rows(context, rows, kind.planner.plan_into(objects, kind_choices.pick, kind_choices.bin)[0])
                if rows.size
                else context
            )
        return context

    def sight(self, state: LineState, stream: Stream, lines: Ints) -> Sight:
        """Objects that camera and encoder know in some lines (K,) now."""
        ride, ends = self._config.cell.belt.speed * state.clock[lines], np.empty((len(lines), 2), dtype=np.int64)
        # Objects stand in the order of x, so that those in sight follow each other.
        self._in_sight(stream.x, lines, ride, *self._config.reach, ends)
        first, last = ends.T
        index = first[:, None] + np.arange(max(int((last - first).max(initial=1)), 1))
        in_sight, index = index < last[:, None], np.minimum(index, stream.x.shape[1] - 1)
        objects = lines[:, None], index
        in_sight &= state.books.since(objects) <= state.clock[lines, None]
        x = np.where(in_sight, stream.x[objects] + ride[:, None], UNAVAILABLE_X)
        return Sight(lines, index, x, stream.objects.measured.kind[objects])

    def pause(self, robot: Ints, sight: Sight) -> Floats:
        """Time after which robots (K,) without options look again (K,) [s]."""
        belt = self._config.cell.belt
        own_x = sight.x - self._places[robot][:, None]
        coming = self._can_take[robot[:, None], sight.kind] & (own_x <= belt.pick_x[1])
        border = belt.pick_x[0] - belt.speed * self._config.horizon
        distance = np.where(coming, border - own_x, UNAVAILABLE_X)
        return np.clip(distance.min(axis=1) / belt.speed, IDLE_TIME, LONGEST_PAUSE)

    def options(self, objects: Objects, sight: Sight, robot: Ints, hand: Floats) -> Options:
        """Options of robots (K,) whose hands stand still at places (K, 3) [m] from their bases."""
        turn = Turn(sight._replace(x=self._reachable_x(sight, robot)), hand)
        if len(self._kinds) == 1:
            return self._kinds[0].options(turn, objects)
        parts: list[Options] = []
        for index, kind in enumerate(self._kinds):
            rows = np.flatnonzero(self._kind_of[robot] == index)
            options = kind.options(take(turn, rows), objects)
            parts.append(replace(options, row=rows[options.row]))
        return merge_options(parts)

    def has_candidates(self, sight: Sight, robot: Ints) -> Bools:
        """Whether an object that the robot takes is near it (K,); only then is planning worthwhile."""
        return np.any(self._kinds[0].near(self._reachable_x(sight, robot)), axis=1)

    def _reachable_x(self, sight: Sight, robot: Ints) -> Floats:
        """Places of objects from the robots' bases (K, W) [m]; `UNAVAILABLE_X` where robots (K,) cannot take one."""
        return np.where(
            self._can_take[robot[:, None], sight.kind], sight.x - self._places[robot][:, None], UNAVAILABLE_X
        )

    def chance(self, sight: Sight, options: Options) -> Floats:
        """Chance that each option brings its object into its bin (C,)."""
        kind = sight.kind[options.row, options.place]
        distance = np.sqrt(options.away[:, 0] ** 2 + options.away[:, 1] ** 2)
        return self._chances.success_chance(kind, options.percent, distance)

    def heirs(self, robot: Ints, kind: Ints) -> Bools:
        """Robots downstream of each robot (C,) that take objects classified as kinds (C,), (C, R)."""
        return self._can_take[:, kind].T & (np.arange(len(self._places)) > robot[:, None])

    def coming(self, state: LineState, stream: Stream) -> Floats:
        """Objects that each deciding robot takes, from the camera to the end of its window (N,)."""
        sight, robot = self.sight(state, stream, np.arange(len(state.clock))), state.robot
        end = self._places[robot] + self._config.cell.belt.pick_x[1]
        is_taken = self._can_take[robot[:, None], sight.kind] & (sight.x <= end[:, None])
        return is_taken.sum(axis=1).astype(np.float64)

    def _rank(self, row: Ints, worth: Floats) -> tuple[Ints, Ints]:
        """Ranks of options (C,) in their line, the best first, and indices of those that become choices."""
        order = np.lexsort((-worth, row))
        first = np.searchsorted(row[order], row[order])
        place = np.empty(len(row), dtype=np.int64)
        place[order] = np.arange(len(row)) - first
        return place, np.flatnonzero(place < CHOICES)

    def _choice_features(self, options: Options, sight: Sight, robot: Ints) -> dict[str, Floats]:
        """Further features of options (C,), from the sights of their robots' lines."""
        speed, (low, _) = self._config.cell.belt.speed, self._config.cell.belt.pick_x
        rows = np.arange(len(robot))
        object_x, kind = sight.x[rows, options.place], sight.kind[rows, options.place]
        stop = self._places[robot] + options.stop[:, 0]
        x_after = (
            np.where(self._can_take[robot[:, None], sight.kind], sight.x, UNAVAILABLE_X)
            + speed * options.cycle[:, None]
        )
        near = np.abs(x_after - stop[:, None]) <= NEAR
        heirs = self.heirs(robot, kind)
        heir, has_heir = heirs.argmax(axis=1), heirs.any(axis=1)
        window = self._places[heir] + low
        between = (
            (sight.x >= object_x[:, None]) & (sight.x <= window[:, None]) & self._can_take[heir[:, None], sight.kind]
        )
        return {
            "crowd": (near.sum(axis=1) - near[rows, options.place]).astype(np.float64),
            "heirs": heirs.sum(axis=1).astype(np.float64),
            "reaches": np.where(has_heir, np.maximum(window - object_x, 0.0) / speed, 0.0),
            "queue": np.where(has_heir, between.sum(axis=1), 0).astype(np.float64),
        }

    def _sample_choice(self) -> tuple[Choices, Context]:
        """An arbitrary pick and throw (1,), which fills rows without a choice."""
        generator, kind = np.random.default_rng(0), self._kinds[0]
        objects = self.planner.draw([generator], np.zeros(1, dtype=np.int64), _TRIALS)
        low, high = self._config.cell.belt.pick_x
        x = low + (high - low) * objects.draws.place[..., 0]
        sight = Sight(np.zeros(1, dtype=np.int64), np.arange(_TRIALS)[None], x, objects.measured.kind)
        options = kind.options(Turn(sight, self.initial_hand()[None]), objects)
        if len(options.row) == 0:
            raise ConfigError(
                f"level {self._config.name!r}: no robot can throw anything into its bins; move them closer"
            )
        first = np.zeros(1, dtype=np.int64)
        zero_features = dict.fromkeys(("value", "chance", "crowd", "heirs", "reaches", "queue"), np.zeros(1))
        option = take(options, first)
        throws = replace(take(objects, (first, option.place)), percent=option.percent)
        context, _ = kind.planner.plan_into(throws, option.pick, option.bin)
        return _make_choices(option, real=np.zeros(1, dtype=np.bool_), index=first, **zero_features), context


def _make_choices(options: Options, **features: Any) -> Choices:
    """Choices from options, with further features by the names of `Choices`."""
    return Choices(**{part.name: getattr(options, part.name) for part in fields(PicksAndThrows)}, **features)
