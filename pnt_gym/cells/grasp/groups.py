"""Groups of objects within reach of one place of the hand, of which the place of the cup chooses one."""

from __future__ import annotations

from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, put_rows, replace_rows, take
from pnt_gym.cells.base.cell import Generators
from pnt_gym.cells.conveyor.belt.sources import MOST_DRAWS, IndependentPicks
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.objects.records import Objects, half_extent
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.cells.grasp.config import GraspConfig

HEADINGS: Final = 16
"""Number of directions that are tried for the line on which a group lies."""
GAP: Final = 0.005
"""Gap between the outlines of neighbours along that line [m]."""


@final
class GroupPicks(IndependentPicks):
    """Independent picks of groups of objects; the first object of a group lies in the picture's middle.

    The objects of a group lie on a line through the first, in the direction in which they lie closest together.
    """

    def __init__(self, planner: PickPlanner, generators: Generators) -> None:
        super().__init__(planner, generators)
        config = planner.config
        assert isinstance(config, GraspConfig)
        self._size = config.grasp.objects
        self.groups: Context = self._draw(np.zeros(len(generators), dtype=np.int64), [np.random.default_rng(0)])[0]
        """The coming picks of all objects of the groups (N, M)."""

    def _next(self, rows: Ints) -> Context:
        """First objects of independent groups, one group per row; groups are drawn until all throws are feasible."""
        groups, good = self._draw(rows, self._generators)
        for _ in range(MOST_DRAWS):
            pending = np.flatnonzero(~good)
            if pending.size == 0:
                self.groups = put_rows(self.groups, rows, groups, len(self._generators))
                return take(groups, (np.arange(len(rows)), np.zeros(len(rows), dtype=np.int64)))
            group, fits = self._draw(rows[pending], self._generators)
            groups = replace_rows(groups, pending, group)
            good[pending] = fits
        raise self._impossible()

    def _draw(self, rows: Ints, generators: Generators) -> tuple[Context, Bools]:
        """Drawn groups (K, M), and which have a feasible throw for all their objects (K,)."""
        objects = self._planner.draw(generators, rows, self._size)
        low, high = self._planner.config.lift_x
        middle = np.stack([low + (high - low) * objects.draws.place[:, 0, 0], objects.draws.lane_y[:, 0]], axis=-1)
        place = middle[:, None] + offsets(objects)
        index = np.repeat(np.arange(len(rows)), self._size), np.tile(np.arange(self._size), len(rows))
        flat = take(objects.replace(draws=objects.draws.replace(lane_y=place[..., 1])), index)
        context, good = self._planner.plan(flat, self._planner.pick_point(flat, place[..., 0].reshape(-1)))
        together = np.arange(place[..., 0].size, dtype=np.int64).reshape(len(rows), -1)
        return take(context, together), np.asarray(good.reshape(len(rows), -1).all(axis=1))


def offsets(objects: Objects) -> Floats:
    """Middles of the outlines of groups of objects (K, M), from that of the first (K, M, 2) [m]."""
    begin = 2.0 * np.pi * objects.draws.place[:, 0, 3]
    headings = begin[:, None] + 2.0 * np.pi / HEADINGS * np.arange(HEADINGS)
    result = np.zeros((*objects.kind.shape, 2))
    distance = [np.zeros_like(headings)]
    for member in range(1, objects.kind.shape[1]):
        wide = [half_extent(take(objects, np.s_[:, [k]]), headings) for k in (0, member)]
        distance.append(wide[0] + wide[1] + GAP)
    best = np.maximum.reduce(distance).argmin(axis=1)
    rows = np.arange(len(best))
    for member in range(1, objects.kind.shape[1]):
        heading = headings[rows, best] + np.pi * (member - 1)  # the first and the second neighbour lie opposite
        away = distance[member][rows, best]
        result[:, member] = away[:, None] * np.stack([np.cos(heading), np.sin(heading)], axis=-1)
    return result
