"""Choices of the robots that decide next: the best options of each robot, with their features."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, replace_rows, take
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.cells.line import turn_kernel
from pnt_gym.cells.line.chances import Chances
from pnt_gym.cells.line.config import LineConfig, distinct_cells
from pnt_gym.cells.line.options import UNAVAILABLE_X, Options, Sight, Sites, ThrowCandidates
from pnt_gym.cells.line.state import CHOICES, COLUMNS, Choices, LineState
from pnt_gym.cells.line.straight import StraightPlanner
from pnt_gym.cells.line.stream import Stream
from pnt_gym.errors import ConfigError

if TYPE_CHECKING:
    from pnt_gym.cells.line.decision_kernel import LineArrays, OrderArrays

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
        self._config, self._chances = config, chances
        kinds, self._kind_of = distinct_cells(cells)
        self._planners = [PickPlanner(kind) for kind in kinds]
        self._sites = Sites(kinds, self._kind_of)
        self._option_planner = StraightPlanner(self._planners, self._sites, config.horizon)
        self.can_take, self.bases = config.can_take(), config.robot_x()
        self.numbers = _line_numbers(config)
        """Numbers of the line as `turn_kernel` names them."""
        self._blank_choice, self.blank = self._sample_choice()
        """Choice and context (1,) that fill rows without a choice."""
        belt, blank = config.cell.belt, self._blank_choice
        self._order: OrderArrays = (
            np.array([config.price_of_time, belt.speed, belt.pick_x[0], NEAR]),
            *(chances.percent, chances.edges, chances.picked, chances.landed),
            blank.numbers[0].copy(),
            np.concatenate([blank.index, blank.bin]),
        )
        """Tables of the order of choices as `decision_kernel` takes them."""

    @property
    def planner(self) -> PickPlanner:
        """Planner of the robot with the most bins; apart from the fill of bins, all planners draw the same objects."""
        return max(self._planners, key=lambda planner: len(planner.areas))

    def planner_of(self, robot: int) -> PickPlanner:
        """The planner of a robot."""
        return self._planners[int(self._kind_of[robot])]

    def initial_hand(self) -> Floats:
        """Position of hands when a shift begins: above the middle of the belt (3,) [m]."""
        belt = self._config.cell.belt
        return np.array([0.0, (belt.lane_y[0] + belt.lane_y[1]) / 2, belt.height + 0.3])

    def empty_choices(self, count: int) -> Choices:
        """Choices of N lines without any real choice."""
        return take(self._blank_choice, np.zeros((count, CHOICES), dtype=np.int64))

    @cached_property
    def tables(self) -> tuple[LineArrays, OrderArrays]:
        """Tables with which `decision_kernel` advances lines."""
        sites = self._sites
        robots, begins, ends = self._config.standstills()
        line = (
            self.numbers, self.can_take, self.bases, robots, np.stack([begins, ends], axis=1),
            sites.ranges, sites.accepts, sites.bin, *self._option_planner.tables,
        )  # fmt: skip
        return line, self._order

    def plan_choices(self, robot: Ints, stream: Stream, choices: Choices) -> Context:
        """Picks and throws of choices (N,) of robots (N,), one in each line; arbitrary where not real.

        Each throw is planned a second time here, because storing the first plan would take hundreds of numbers for each
        choice.
        """
        context = take(self.blank, np.zeros(len(robot), dtype=np.int64))
        for index, planner in enumerate(self._planners):
            rows = np.flatnonzero(choices.real & (self._kind_of[robot] == index))
            if rows.size > 0:
                kind_choices = take(choices, rows)
                objects = replace(take(stream.objects, (rows, kind_choices.index)), percent=kind_choices.percent)
                planned = planner.plan_into(objects, kind_choices.pick, kind_choices.bin)[0]
                context = replace_rows(context, rows, planned)
        return context

    def sight(self, state: LineState, stream: Stream, lines: Ints, ends: Ints | None = None) -> Sight:
        """Objects that camera and encoder know in some lines (K,) now.

        Args:
            state: state of the lines.
            stream: objects that come along.
            lines: indices of the lines (K,).
            ends: ranges of the objects in sight (K, 2), where they are known.
        """
        if ends is None:
            ends = np.empty((len(lines), 2), dtype=np.int64)
            turn_kernel.find_ends(self.numbers, lines, state.clock, stream.x, ends)
        width = max(int((ends[:, 1] - ends[:, 0]).max(initial=1)), 1)
        index, kind = np.empty((2, len(lines), width), dtype=np.int64)
        x, kinds = np.empty((len(lines), width)), stream.objects.measured.kind
        since = state.books.read().since
        turn_kernel.show_objects(self.numbers, lines, state.clock, stream.x, since, kinds, ends, index, x, kind)
        return Sight(lines, index, x, kind)

    def options(self, objects: Objects, sight: Sight, robot: Ints, hand: Floats) -> Options:
        """Options of robots (K,) whose hands stand still at places (K, 3) [m] from their bases."""
        # Compiled code takes no read-only arrays.
        index, x = np.require(sight.object_index, requirements="W"), np.require(sight.x, requirements="W")
        writable = sight._replace(object_index=index, x=x)
        return self._options(objects, writable, robot, hand, (self.can_take, self.bases))

    def _options(
        self, objects: Objects, sight: Sight, robot: Ints, hand: Floats, robots: tuple[Bools, Floats]
    ) -> Options:
        """Options as `options`, of robots of which each takes items (R, items) and stands at a place (R,) [m]."""
        most = sight.x.size * self._sites.most
        index, x = np.empty((4, most), dtype=np.int64), np.empty(most)
        tables = *robots, self._sites.ranges, self._sites.accepts
        count = turn_kernel.list_candidates(self.numbers, sight.x, sight.kind, robot, *tables, index, x)
        return self._option_planner.plan(ThrowCandidates(index[:, :count], x[:count]), sight, hand, objects)

    def chance(self, sight: Sight, options: Options) -> Floats:
        """Chance that each option brings its object into its bin (C,)."""
        kind = sight.kind[options.row, options.place]
        distance = np.sqrt(options.away[:, 0] ** 2 + options.away[:, 1] ** 2)
        return self._chances.success_chance(kind, options.percent, distance)

    def heirs(self, robot: Ints, kind: Ints) -> Bools:
        """Robots downstream of each robot (C,) that take objects classified as kinds (C,), (C, R)."""
        return self.can_take[:, kind].T & (np.arange(len(self.bases)) > robot[:, None])

    def _sample_choice(self) -> tuple[Choices, Context]:
        """An arbitrary pick and throw (1,), which fills rows without a choice."""
        objects = self.planner.draw([np.random.default_rng(0)], np.zeros(1, dtype=np.int64), _TRIALS)
        low, high = self._config.cell.belt.pick_x
        x = low + (high - low) * objects.draws.place[..., 0]
        line, index = np.zeros(1, dtype=np.int64), np.arange(_TRIALS)[None]
        sight, hand = Sight(line, index, x, objects.measured.kind), self.initial_hand()[None]
        options = self._options(objects, sight, line, hand, (np.ones_like(self.can_take), np.zeros(len(self.bases))))
        if len(options.row) == 0:
            raise ConfigError(
                f"level {self._config.name!r}: no robot can throw an object into its bins; move the bins closer"
            )
        option = take(options, line)
        throws = replace(take(objects, (line, option.place)), percent=option.percent)
        context, _ = self._planners[0].plan_into(throws, option.pick, option.bin)
        numbers = np.zeros((1, COLUMNS))
        numbers[:, : option.numbers.shape[1]] = option.numbers
        blank = Choices(bin=option.bin, numbers=numbers, real=np.zeros(1, dtype=np.bool_), index=line)
        return blank, context


def _line_numbers(config: LineConfig) -> Floats:
    """Numbers of a line as `turn_kernel` names them."""
    belt = config.cell.belt
    near = belt.pick_x[0] - belt.speed * config.horizon, belt.pick_x[1]
    return np.array([belt.speed, *config.reach, *near, config.duration, IDLE_TIME, LONGEST_PAUSE, UNAVAILABLE_X])
