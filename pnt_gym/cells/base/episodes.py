"""Which throw of its episode each of N cells is at."""

from __future__ import annotations

from typing import final

import numpy as np

from pnt_gym.arrays import Bools, Ints


@final
class Episodes:
    """Counts the throws of N cells, and knows which of them need a new draw when their episode begins.

    Args:
        count: number of cells N.
        length: throws in an episode.
        drawn: whether the cell draws the next episode's first throw by itself after the last one of an episode.
    """

    def __init__(self, count: int, length: int, drawn: bool) -> None:
        self._length, self._drawn = length, drawn
        self._throws = np.zeros(count, dtype=np.int64)
        self._fresh = np.zeros(count, dtype=np.bool_)

    def begin(self, rows: Ints, seeded: Bools | bool) -> Ints:
        """Begin new episodes in some rows, seeded or not; returns the positions in `rows` that must be drawn anew."""
        self._throws[rows] = 0
        draw = seeded | ~self._fresh[rows]
        self._fresh[rows] = False
        return np.flatnonzero(draw)

    def thrown(self, early: Bools | None = None, waiting: Bools | None = None) -> Bools:
        """Count one throw in every cell; returns the episodes that are over (N,).

        Args:
            early: episodes that this throw ends before their length (N,); None for none.
            waiting: cells whose throw does not count (N,); None for none.
        """
        counted = np.ones_like(self._fresh) if waiting is None else ~waiting
        self._throws += counted
        ended = self._throws >= self._length
        if early is not None:
            ended = ended | early
        self._fresh = np.where(counted, ended & self._drawn, self._fresh)
        return ended
