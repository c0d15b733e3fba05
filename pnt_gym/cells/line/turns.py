"""Order of decisions along N lines: the next robot that is free and has something to take decides."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, final

import numpy as np

from pnt_gym.arrays import Ints
from pnt_gym.cells.line import decision_kernel, turn_kernel
from pnt_gym.cells.line.choosing import IDLE_TIME, Chooser
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.state import LineState
from pnt_gym.cells.line.stream import Stream
from pnt_gym.errors import ConfigError

if TYPE_CHECKING:
    from pnt_gym.cells.line.decision_kernel import LineArrays, OrderArrays

MOST_LOOKS: Final = 100_000
"""Looks without a result in a row before a line is declared impossible."""


@final
class Turns:
    """Advances lines from decision to decision.

    Args:
        config: level of the line.
        chooser: finds the choices of each robot.
    """

    def __init__(self, config: LineConfig, chooser: Chooser) -> None:
        self._config, self._chooser = config, chooser
        robots, begins, ends = config.standstills()
        self._standstills = robots, np.stack([begins, ends], axis=1)

    def advance(self, stream: Stream, state: LineState, rows: Ints) -> None:
        """Advance some lines to their next decisions, or to the end of their shifts, in place.

        Raises:
            ConfigError: the robots of a line find nothing that they can take.
        """
        tables, lines = self._chooser.fast_tables, rows
        if tables is not None:
            self._advance_fast(*tables, stream, state, rows)
            return
        for _ in range(MOST_LOOKS):
            if lines.size == 0:
                state.choices.real[rows[state.clock[rows] >= self._config.duration]] = False
                state.expected[rows] = np.maximum(state.expected[rows], state.free[rows])
                return
            lines, ends = self._find_turns(stream, state, lines)
            sight = self._chooser.sight(state, stream, lines, ends)
            lines = lines[~self._chooser.write_choices(state.choices, state, stream, sight)]
            # An object is near, so a robot that cannot take one looks again after the shortest time.
            state.free[lines, state.robot[lines]] += IDLE_TIME
        raise self._impossible()

    def _advance_fast(
        self, line: LineArrays, order: OrderArrays, stream: Stream, state: LineState, lines: Ints
    ) -> None:
        """Advance some lines, in place, as `advance`; Python only computes the cube roots of short throws."""
        objects, choices, since = stream.objects, state.choices, state.books.read().since
        arrays = (
            (state.clock, state.robot, state.free, state.expected, state.hand),
            (choices.real, choices.index, choices.bin, choices.numbers),
        )
        seen = objects.measured.kind, objects.size, objects.known_depth, objects.draws.lane_y
        while lines.size > 0:
            has_ended, options = decision_kernel.next_decisions(
                line, order, *arrays, stream.x, since, stream.worth, *seen, lines, MOST_LOOKS
            )
            if not has_ended:
                raise self._impossible()
            lines = options[0]
            if lines.size > 0:
                roots = np.cbrt(options[-1][:2])
                lines = decision_kernel.choose_after_roots(line, order, *arrays, stream.worth, options, roots)

    def _find_turns(self, stream: Stream, state: LineState, lines: Ints) -> tuple[Ints, Ints]:
        """Advance lines to the next robot with something near it: the lines, and their ranges of objects in sight."""
        chooser, has_candidates = self._chooser, np.empty(len(lines), dtype=np.bool_)
        ends, since = np.empty((len(lines), 2), dtype=np.int64), state.books.read().since
        if not turn_kernel.next_turns(
            chooser.numbers, lines, state.clock, state.robot, state.free, stream.x, since,
            stream.objects.measured.kind, chooser.can_take, chooser.bases, *self._standstills, has_candidates, ends,
        ):  # fmt: skip
            raise self._impossible()
        return lines[has_candidates], ends[has_candidates]

    def _impossible(self) -> ConfigError:
        return ConfigError(f"level {self._config.name!r}: the robots find no object that they can take")
