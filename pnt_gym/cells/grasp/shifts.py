"""Shifts of independent picks, each with a few of the level's kinds."""

from __future__ import annotations

from operator import methodcaller
from typing import final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.base.cell import Generators, Purpose, draw_aside
from pnt_gym.cells.conveyor.belt.sources import IndependentPicks
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.cells.grasp.config import GraspConfig


@final
class ShiftPicks(IndependentPicks):
    """Independent picks of shifts; where the level has `grasp.kinds`, each shift draws its own kinds when it begins.

    The kinds of a shift are different items of the level. The k-th kind comes as often as one over k.
    """

    def __init__(self, planner: PickPlanner, generators: Generators) -> None:
        super().__init__(planner, generators)
        config = planner.config
        assert isinstance(config, GraspConfig)
        most = config.grasp.kinds or 0
        self._items = len(config.items)
        self._bounds = np.cumsum(1.0 / np.arange(1, most + 1))
        """Cumulated frequencies of a shift's kinds (M,), up to a factor."""
        self._kinds = np.zeros((len(generators), most), dtype=np.int64)
        """Kinds of the rows' shifts (N, M)."""

    def first(self, rows: Ints) -> Context:
        """First picks of new shifts, one per row."""
        for row in map(int, rows):
            shuffle = Purpose.KINDS, methodcaller("permutation", np.arange(self._items))
            (order,) = draw_aside(self._generators[row], shuffle)
            self._kinds[row] = order[: len(self._bounds)]
        return super().first(rows)

    def _attempt(self, rows: Ints) -> tuple[Context, Bools]:
        kinds = self._of_shifts if len(self._bounds) > 0 else None
        return self._planner.plan(*self._planner.draw_picks(self._generators, rows, kinds))

    def _of_shifts(self, rows: Ints, draws: Floats) -> Floats:
        """Draws (K, C) that stand for kinds of the shifts of some rows (K,), by uniform draws (K, C)."""
        rank = np.asarray(np.searchsorted(self._bounds, draws * self._bounds[-1], side="right"), dtype=np.int64)
        chosen = self._kinds[rows[:, None], np.minimum(rank, len(self._bounds) - 1)]
        return (chosen + 0.5) / self._items
