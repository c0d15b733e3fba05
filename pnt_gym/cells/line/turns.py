"""Order of decisions along N lines: the next robot that is free and has something to take decides."""

from __future__ import annotations

from dataclasses import replace
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Floats, Ints, replace_rows, take
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

    def advance(self, stream: Stream, state: LineState, rows: Ints) -> LineState:
        """State with some lines at their next decisions, or at the end of their shifts."""
        pending, candidates = rows, rows[:0]
        for _ in range(MOST_LOOKS):
            if pending.size > 0:
                state, near_rows, pending = self._next_turns(stream, state, pending)
                candidates = np.concatenate([candidates, near_rows])
            elif candidates.size > 0:  # planning for all of them at once takes hardly longer than for one
                state, pending, candidates = *self._find_choices(stream, state, np.sort(candidates)), rows[:0]
            else:
                return _close_shifts(
                    replace(state, expected=np.maximum(state.expected, state.free)), self._config.duration
                )
        raise ConfigError(f"level {self._config.name!r}: its robots find nothing that they can take")

    def _next_turns(self, stream: Stream, state: LineState, rows: Ints) -> tuple[LineState, Ints, Ints]:
        """Some lines at the next robot's turn: the state, lines with objects near the robot, and lines without."""
        robot = state.free[rows].argmin(axis=1)
        clock, robots, free = state.clock.copy(), state.robot.copy(), state.free.copy()
        clock[rows], robots[rows] = state.free[rows, robot], robot
        state = replace(state, clock=clock, robot=robots, free=free)
        rows = rows[clock[rows] < self._config.duration]
        until = self._standstill_ends(clock[rows], robots[rows])
        down = until > clock[rows]
        free[rows[down], robots[rows[down]]] = until[down]
        looking = rows[~down]
        sight = self._chooser.sight(state, stream, looking)
        has_candidates = self._chooser.has_candidates(sight, robots[looking])
        idle = looking[~has_candidates]
        free[idle, robots[idle]] += self._chooser.pause(robots[idle], take(sight, ~has_candidates))
        return state, looking[has_candidates], np.concatenate([rows[down], idle])

    def _standstill_ends(self, clock: Floats, robot: Ints) -> Floats:
        """Ends of the standstills of robots (K,) [s]; the present time for robots that do not stand still."""
        until = clock.copy()
        for down_robot, start, end in zip(*self._config.standstills(), strict=True):
            until = np.where((robot == down_robot) & (until >= start) & (until < end), end, until)
        return until

    def _find_choices(self, stream: Stream, state: LineState, rows: Ints) -> tuple[LineState, Ints]:
        """State with the choices of the deciding robots in some lines, and the lines without a choice."""
        sight = self._chooser.sight(state, stream, rows)
        choices = self._chooser.find_choices(state, stream, sight)
        is_empty = ~choices.real.any(axis=1)
        idle, free = rows[is_empty], state.free.copy()
        free[idle, state.robot[idle]] += self._chooser.pause(state.robot[idle], take(sight, is_empty))
        return replace(state, choices=replace_rows(state.choices, rows, choices), free=free), idle


def _close_shifts(state: LineState, duration: float) -> LineState:
    """State without choices in lines whose shift is over."""
    over = state.clock >= duration
    if not over.any():
        return state
    return replace(state, choices=replace(state.choices, real=state.choices.real & ~over[:, None]))
