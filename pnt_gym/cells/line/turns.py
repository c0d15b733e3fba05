"""Order of decisions along N lines: the next robot that is free and has something to take decides."""

from __future__ import annotations

from dataclasses import replace
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Floats, Ints, replaced, take
from pnt_gym.cells.line.choosing import Chooser
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.state import Shift
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

    def following(self, stream: Stream, state: Shift, rows: Ints) -> Shift:
        """State with some lines at their next decisions, or at the end of their shifts."""
        pending, tempted = rows, rows[:0]
        for _ in range(MOST_LOOKS):
            if pending.size > 0:
                state, found, pending = self._turned(stream, state, pending)
                tempted = np.concatenate([tempted, found])
            elif tempted.size > 0:  # planning for all of them at once takes hardly longer than for one
                state, pending, tempted = *self._looked(stream, state, np.sort(tempted)), rows[:0]
            else:
                return _closed(replace(state, expected=np.maximum(state.expected, state.free)), self._config.duration)
        raise ConfigError(f"level {self._config.name!r}: its robots find nothing that they can take")

    def _turned(self, stream: Stream, state: Shift, rows: Ints) -> tuple[Shift, Ints, Ints]:
        """Some lines at the next robot's turn: the state, lines with objects near the robot, and lines without."""
        robot = state.free[rows].argmin(axis=1)
        clock, robots, free = state.clock.copy(), state.robot.copy(), state.free.copy()
        clock[rows], robots[rows] = state.free[rows, robot], robot
        state = replace(state, clock=clock, robot=robots, free=free)
        rows = rows[clock[rows] < self._config.duration]
        until = self._standing(clock[rows], robots[rows])
        down = until > clock[rows]
        free[rows[down], robots[rows[down]]] = until[down]
        looking = rows[~down]
        sight = self._chooser.sight(state, stream, looking)
        tempted = self._chooser.tempted(sight, robots[looking])
        idle = looking[~tempted]
        free[idle, robots[idle]] += self._chooser.pause(robots[idle], take(sight, ~tempted))
        return state, looking[tempted], np.concatenate([rows[down], idle])

    def _standing(self, clock: Floats, robot: Ints) -> Floats:
        """Ends of the standstills of robots (K,) [s]; the present time for robots that do not stand still."""
        until = clock.copy()
        for who, start, end in zip(*self._config.standstills(), strict=True):
            until = np.where((robot == who) & (until >= start) & (until < end), end, until)
        return until

    def _looked(self, stream: Stream, state: Shift, rows: Ints) -> tuple[Shift, Ints]:
        """State with the choices of the deciding robots in some lines, and the lines without a choice."""
        sight = self._chooser.sight(state, stream, rows)
        found = self._chooser.found(state, stream, sight)
        nothing = ~found.real.any(axis=1)
        idle, free = rows[nothing], state.free.copy()
        free[idle, state.robot[idle]] += self._chooser.pause(state.robot[idle], take(sight, nothing))
        return replace(state, choices=replaced(state.choices, rows, found), free=free), idle


def _closed(state: Shift, duration: float) -> Shift:
    """State without choices in lines whose shift is over."""
    over = state.clock >= duration
    if not over.any():
        return state
    return replace(state, choices=replace(state.choices, real=state.choices.real & ~over[:, None]))
