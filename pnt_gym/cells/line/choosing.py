"""What robots whose turn it is can choose between: the best of all that they could do, with what is known of each."""

from __future__ import annotations

from typing import Final, final

import numpy as np

from pnt_gym.arrays import Floats, Ints, replaced, take
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.cells.line.chances import Chances
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.options import Options, Robots, Turn, of_all
from pnt_gym.cells.line.state import CHOICES, Choices, Shift
from pnt_gym.cells.line.stream import Stream
from pnt_gym.errors import ConfigError

NEAR: Final = 0.25
"""Objects this close along the belt to where a hand stops are near it [m]."""
AWAY: Final = 1e6
"""Where objects are that nobody may take [m]."""
_TRIALS: Final = 200


@final
class Chooser:
    """Finds choices.

    Args:
        config: the line.
        cells: its robots as conveyor cells.
        chances: of their throws.

    Raises:
        ConfigError: a robot that can do nothing.
    """

    def __init__(self, config: LineConfig, cells: list[ConveyorConfig], chances: Chances) -> None:
        self._config, self._chances = config, chances
        texts = [cell.model_dump_json() for cell in cells]
        different = list(dict.fromkeys(texts))
        self._kinds = [Robots(cells[texts.index(text)], config.horizon) for text in different]
        self._kind_of = np.array([different.index(text) for text in texts])
        self._able, self._places = config.able(), config.places()
        self._values = config.values()
        self._one = self._any_choice()

    @property
    def planner(self) -> PickPlanner:
        """Of the robot with the most bins; but for how full those are, all draw alike."""
        return max((kind.planner for kind in self._kinds), key=lambda planner: len(planner.areas))

    def begin(self) -> Floats:
        """Where hands stand when a shift begins (3,) [m]."""
        return self._kinds[0].begin()

    def nothing(self, count: int) -> Choices:
        """No choice, in N lines."""
        return take(self._one, np.zeros((count, CHOICES), dtype=np.int64))

    def found(self, state: Shift, stream: Stream, lines: Ints) -> Choices:
        """What the robots whose turn it is can do in some lines (K, CHOICES)."""
        robot = state.robot[lines]
        x = self._where(state, stream, lines)
        options = self._options(state, stream, lines, robot, x)
        seen, worth = stream.objects.seen[options.line, options.index], stream.worth[options.line, options.index]
        objects = options.context.objects
        chance = self._chances.success(seen, objects.percent, options.context.distance)
        row = np.searchsorted(lines, options.line)
        place, kept = self._ranked(row, worth * chance - self._config.price_of_time * options.cycle)
        options, row, place = take(options, kept), row[kept], place[kept]
        told = self._told(state, stream, options, x[row], robot[row])
        choices = Choices(
            real=np.ones(len(row), dtype=np.bool_),
            index=options.index,
            lift=options.lift,
            wait=options.wait,
            leave=options.leave,
            throwing=options.throwing,
            stop=options.stop,
            value=worth[kept],
            chance=chance[kept],
            context=options.context,
            **told,
        )
        return replaced(self.nothing(len(lines)), (row, place), choices)

    def coming(self, state: Shift, stream: Stream) -> Floats:
        """Objects that each robot whose turn it is takes, from the camera to the end of its window (N,)."""
        lines = np.arange(len(state.clock))
        x, end = self._where(state, stream, lines), self._places[state.robot] + self._config.cell.belt.pick_x[1]
        own = self._able[state.robot[:, None], stream.objects.seen] & (x <= end[:, None])
        return own.sum(axis=1).astype(np.float64)

    def _where(self, state: Shift, stream: Stream, lines: Ints) -> Floats:
        """Where objects of some lines are now (K, M) [m]; far away those that nobody knows or may take."""
        x = stream.x[lines] + self._config.cell.belt.speed * state.clock[lines, None]
        low, high = self._config.reach
        known = (x >= low) & (x <= high) & (state.since[lines] <= state.clock[lines, None])
        return np.where(known, x, AWAY)

    def _options(self, state: Shift, stream: Stream, lines: Ints, robot: Ints, x: Floats) -> Options:
        """All that robots (K,) of some lines can do."""
        seen = stream.objects.seen[lines]
        own = np.where(self._able[robot[:, None], seen], x - self._places[robot][:, None], AWAY)
        parts: list[Options] = []
        for index, kind in enumerate(self._kinds):
            some = np.flatnonzero(self._kind_of[robot] == index)
            turn = Turn(lines[some], state.hand[lines[some], robot[some]], seen[some], own[some])
            parts.append(kind.options(turn, stream.objects))
        return parts[0] if len(parts) == 1 else of_all(parts)

    def _ranked(self, row: Ints, worth: Floats) -> tuple[Ints, Ints]:
        """Places of options (C,) among those of their line, the best first, and which of them have one."""
        order = np.lexsort((-worth, row))
        first = np.searchsorted(row[order], row[order])
        place = np.empty(len(row), dtype=np.int64)
        place[order] = np.arange(len(row)) - first
        return place, np.flatnonzero(place < CHOICES)

    def _told(self, state: Shift, stream: Stream, options: Options, x: Floats, robot: Ints) -> dict[str, Floats]:
        """What else is known of options (C,), whose lines' objects are at x (C, M) [m]."""
        speed, (low, _) = self._config.cell.belt.speed, self._config.cell.belt.pick_x
        seen = stream.objects.seen[options.line]
        own = x[np.arange(len(robot)), options.index]
        stop = self._places[robot] + options.stop[:, 0]
        then = np.where(self._able[robot[:, None], seen], x, AWAY) + speed * options.cycle[:, None]
        near = np.abs(then - stop[:, None]) <= NEAR
        crowd = near.sum(axis=1) - near[np.arange(len(robot)), options.index]
        kind = seen[np.arange(len(robot)), options.index]
        heirs = self._able[:, kind].T & (np.arange(len(self._places)) > robot[:, None])
        next_one = heirs.argmax(axis=1)
        there = heirs.any(axis=1)
        window = self._places[next_one] + low
        between = (x >= own[:, None]) & (x <= window[:, None]) & self._able[next_one[:, None], seen]
        return {
            "crowd": crowd.astype(np.float64),
            "heirs": heirs.sum(axis=1).astype(np.float64),
            "reaches": np.where(there, np.maximum(window - own, 0.0) / speed, 0.0),
            "queue": np.where(there, between.sum(axis=1), 0).astype(np.float64),
        }

    def _any_choice(self) -> Choices:
        """Some pick and throw (1,), to stand where there is no choice."""
        generator, kind = np.random.default_rng(0), self._kinds[0]
        objects = self.planner.draw([generator], np.zeros(1, dtype=np.int64), _TRIALS)
        low, high = self._config.cell.belt.pick_x
        x = low + (high - low) * objects.place[..., 0]
        turn = Turn(np.zeros(1, dtype=np.int64), self.begin()[None], objects.seen, x)
        found = kind.options(turn, objects)
        if len(found.line) == 0:
            raise ConfigError(
                f"level {self._config.name!r}: no robot can throw anything into its bins; move them closer"
            )
        one, zero = take(found, np.zeros(1, dtype=np.int64)), np.zeros(1)
        return Choices(
            real=np.zeros(1, dtype=np.bool_),
            index=np.zeros(1, dtype=np.int64),
            lift=one.lift,
            wait=one.wait,
            leave=one.leave,
            throwing=one.throwing,
            stop=one.stop,
            value=zero,
            chance=zero.copy(),
            crowd=zero.copy(),
            heirs=zero.copy(),
            reaches=zero.copy(),
            queue=zero.copy(),
            context=one.context,
        )
