"""Order of decisions along N lines: the next robot that is free and has something to take decides."""

from __future__ import annotations

from typing import Final, final

import numpy as np

from pnt_gym.arrays import Ints
from pnt_gym.cells.line import decision_kernel
from pnt_gym.cells.line.choosing import Chooser
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.state import LineState
from pnt_gym.cells.line.stream import Stream
from pnt_gym.errors import ConfigError

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

    def advance(self, stream: Stream, state: LineState, lines: Ints) -> None:
        """Advance some lines, in place, to their next decisions or to the end of their shifts.

        Python only computes the cube roots of short throws.

        Raises:
            ConfigError: the robots of a line find nothing that they can take.
        """
        line, order = self._chooser.tables
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
                raise ConfigError(f"level {self._config.name!r}: the robots find no object that they can take")
            lines = options[0]
            if lines.size > 0:
                roots = np.cbrt(options[-1][:2])
                lines = decision_kernel.choose_after_roots(line, order, *arrays, stream.worth, options, roots)
