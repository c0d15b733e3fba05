"""What robots can choose: objects in sight, planned throws, and the full plans of choices."""

from __future__ import annotations

from typing import Final, NamedTuple, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, replace_rows, take
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.cells.line import plan, sight, simulate
from pnt_gym.cells.line.chances import Chances
from pnt_gym.cells.line.config import LineConfig, distinct_cells
from pnt_gym.cells.line.rows import Choice, LineState, Rider, Seen, Tables
from pnt_gym.cells.line.stream import Stream
from pnt_gym.cells.line.tables import make_tables
from pnt_gym.errors import ConfigError
from pnt_gym.rows import Rows1, Rows2

MOST_LOOKS: Final = 100_000
"""Looks without a result in a row before a line is declared impossible."""
_TRIALS: Final = 200


class Sight(NamedTuple):
    """What camera and encoder know of K lines."""

    line: Ints
    """Indices of the lines (K,)."""
    seen: Rows2[Seen]
    """Objects in sight, the most downstream first (K, W)."""


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
        self._config = config
        kinds, self._kind_of = distinct_cells(cells)
        self._planners = [PickPlanner(kind) for kind in kinds]
        self.tables: Tables = make_tables(config, self._planners, self._kind_of, chances)
        """Tables of the line for compiled functions."""
        belt = config.cell.belt
        self.initial_hand: Floats = np.array([0.0, (belt.lane_y[0] + belt.lane_y[1]) / 2, belt.height + 0.3])
        """Position of hands when a shift begins: above the middle of the belt (3,) [m]."""
        trials = self._trial_throws()
        self.can_throw: Bools = np.array([len(choices) > 0 for _, choices in trials])
        """Whether each kind of robot, as `distinct_cells` orders them, can throw an object into one of its bins."""
        if not self.can_throw.any():
            raise ConfigError(
                f"level {self._config.name!r}: no robot can throw an object into its bins; move the bins closer"
            )
        self.blank, choice = trials[int(np.argmax(self.can_throw))]
        """Context (1,) that fills rows without a choice."""
        self.tables = self.tables._replace(blank=choice)

    def _trial_throws(self) -> list[tuple[Context, Rows1[Choice]]]:
        """A pick and throw of each kind of robots, both of one row, or of none where no trial object can be thrown."""
        objects = self.planner.draw([np.random.default_rng(0)], np.zeros(1, dtype=np.int64), _TRIALS)
        low, high = self._config.cell.belt.pick_x
        stream = Stream.of(objects, low + (high - low) * objects.draws.place[..., 0], *np.zeros((2, 1, _TRIALS)))
        seen = Seen.zeros(1, _TRIALS, index=np.arange(_TRIALS), x=stream.x, kind=stream.riders["seen"])
        stations = self.tables.stations.copy()
        stations["base"] = 0.0
        tables = self.tables._replace(stations=stations, can_take=np.ones_like(self.tables.can_take))
        line, hand, trials = (
            np.zeros(1, dtype=np.int64),
            self.initial_hand[None],
            list[tuple[Context, Rows1[Choice]]](),
        )
        for robot in np.unique(self._kind_of, return_index=True)[1]:
            choice = plan.plan_options(tables, stream.riders, line, seen, np.array([robot]), hand)[:1].copy()
            throws = take(objects, (line[: len(choice)], choice["place"])).replace(percent=choice["percent"])
            context, _ = self.planner_of(int(robot)).plan_into(throws, choice["pick"], choice["bin"])
            for name in ("real", "line", "place", "index", "value", "chance"):
                choice[name] = 0
            trials.append((context, choice))
        return trials

    @property
    def planner(self) -> PickPlanner:
        """Planner of the robot with the most bins; apart from the fill of bins, all planners draw the same objects."""
        return max(self._planners, key=lambda planner: len(planner.areas))

    def planner_of(self, robot: int) -> PickPlanner:
        """The planner of a robot."""
        return self._planners[int(self._kind_of[robot])]

    def advance(self, stream: Stream, state: LineState, lines: Ints) -> None:
        """Advance some lines, in place, to their next decisions or to the end of their shifts.

        Raises:
            ConfigError: the robots of a line find nothing that they can take.
        """
        if not simulate.advance(self.tables, state, stream.riders, lines, MOST_LOOKS):
            raise ConfigError(f"level {self._config.name!r}: the robots find no object that they can take")

    def plan_choices(self, robot: Ints, stream: Stream, choices: Rows1[Choice]) -> Context:
        """Picks and throws of choices (N,) of robots (N,), one in each line; arbitrary where not real.

        Each throw is planned a second time here, because storing the first plan would take hundreds of numbers for each
        choice.
        """
        context = take(self.blank, np.zeros(len(robot), dtype=np.int64))
        for index, planner in enumerate(self._planners):
            rows = np.flatnonzero(choices["real"] & (self._kind_of[robot] == index))
            if rows.size > 0:
                own = take(choices, rows)
                objects = take(stream.objects, (rows, own["index"])).replace(percent=own["percent"])
                context = replace_rows(context, rows, planner.plan_into(objects, own["pick"], own["bin"])[0])
        return context

    def sight(self, state: LineState, stream: Stream, lines: Ints) -> Sight:
        """What camera and encoder know of some lines (K,) now."""
        return Sight(lines, sight.show_objects(self.tables, state, stream.riders, lines))

    def options(self, riders: Rows2[Rider], look: Sight, robot: Ints, hand: Floats) -> Rows1[Choice]:
        """Throws that robots (K,) can plan, with values and chances, in the order of the lines (G,).

        Args:
            riders: objects of all lines (N, M).
            look: what the robots know.
            robot: the robots (K,).
            hand: places at which their hands stand still, from their bases (K, 3) [m].
        """
        return plan.plan_options(self.tables, riders, look.line, look.seen, robot, hand)

    def heirs(self, robot: Ints, kind: Ints) -> Bools:
        """Robots downstream of each robot (C,) that take objects classified as kinds (C,), (C, R)."""
        can_take = self.tables.can_take
        return can_take[:, kind].T & (np.arange(len(can_take)) > robot[:, None])
