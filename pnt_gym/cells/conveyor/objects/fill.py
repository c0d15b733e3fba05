"""Bins that fill: the free depth of bins for the next throw, from the objects in them."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, replace_rows, take
from pnt_gym.cells.base.items import ItemTable
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.objects.records import Objects

LEAST_DEPTH: Final = 0.02
"""Smallest free depth of a bin [m]: a filling that would rise higher slides over the rim, or is raked."""
_SHARE: Final = np.array([np.pi / 6.0, np.pi / 4.0, 1.0])
"""Volume of each shape over that of the box around it."""


@final
@dataclass(frozen=True)
class Fill:
    """Contents of the B bins of N cells."""

    count: Ints
    """Number of objects since the bin was emptied (N, B)."""
    volume: Floats
    """Volume of these objects, without the gaps between them (N, B) [m3]."""

    @classmethod
    def empty(cls, *shape: int) -> Fill:
        """Empty bins (N, B)."""
        return cls(np.zeros(shape, dtype=np.int64), np.zeros(shape))

    def depth(self, area: Floats, config: ConveyorConfig) -> Floats:
        """Free depth (N, B) [m] above the contents, for openings of an area (N, B) or (B,) [m2]; contents are level."""
        bins = config.bins
        left = bins.depth - self.volume / (bins.packing * area)
        return np.maximum(left, min(LEAST_DEPTH, bins.depth))


class PlannedBins:
    """Bins of N cells whose depth is that in each pick's context: contents do not carry over between throws."""

    def begin(self, rows: Ints, depth: Floats) -> Floats:
        """Depths (K, B) [m] for the first throws in some rows, from the depths (K, B) in their contexts."""
        return depth

    @contextmanager
    def hold_back(self, rows: Bools) -> Generator[None]:
        """Context at whose end the bins of some rows (N,) are as at its beginning."""
        yield

    def after(self, objects: Objects, ended_in: Ints, depth: Floats) -> Floats:
        """Depths (N, B) [m] for the next throws, after the thrown objects have ended in bins (N,), -1 for none."""
        return depth


@final
class FillingBins(PlannedBins):
    """Fixed bins of N cells in which objects stay for the throws that follow.

    Args:
        config: the cell.
        count: number of cells N.
        emptied: number of objects at which a bin is emptied.
    """

    def __init__(self, config: ConveyorConfig, count: int, emptied: int) -> None:
        self._config, self._emptied = config, emptied
        self._area = fixed_areas(config)
        self._fill = Fill.empty(count, len(self._area))

    def begin(self, rows: Ints, depth: Floats) -> Floats:
        """Depths of empty bins (K, B) [m]."""
        empty = Fill.empty(len(rows), len(self._area))
        self._fill = replace_rows(self._fill, rows, empty)
        return empty.depth(self._area, self._config)

    @contextmanager
    def hold_back(self, rows: Bools) -> Generator[None]:
        """Context at whose end the bins of some rows (N,) hold what they held at its beginning."""
        before = self._fill
        yield
        self._fill = replace_rows(self._fill, rows, take(before, rows))

    def after(self, objects: Objects, ended_in: Ints, depth: Floats) -> Floats:
        """Depths (N, B) [m] above the contents, with the objects that have ended in bins."""
        came = np.arange(len(self._area), dtype=np.int64) == ended_in[:, None]
        count = self._fill.count + came
        volume = self._fill.volume + came * volume_of(objects.shape, objects.size)[:, None]
        full = count >= self._emptied
        self._fill = Fill(np.where(full, 0, count), np.where(full, 0.0, volume))
        return self._fill.depth(self._area, self._config)


def bins_of_cells(config: ConveyorConfig, count: int, carried: bool) -> PlannedBins:
    """The bins of N cells; with `carried`, contents carry over from throw to throw where the level has fixed bins."""
    emptied = config.bins.emptied
    if emptied is None or not config.bins.fixed or not carried:
        return PlannedBins()
    return FillingBins(config, count, emptied)


def fixed_areas(config: ConveyorConfig) -> Floats:
    """Areas of the fixed bins' openings (B,) [m2]."""
    return np.prod(np.array([fixed.size for fixed in config.bins.fixed]).reshape(-1, 2), axis=1)


def mean_volumes(config: ConveyorConfig, table: ItemTable) -> Floats:
    """Mean volumes of the items that each bin accepts (B,) [m3]."""
    volumes = volume_of(table.shape, table.size)
    takes = config.acceptance() if config.bins.fixed else np.full((len(volumes), 1), True)
    return (volumes @ takes) / takes.sum(axis=0)


def draw_fill(draw: Floats, emptied: int, volume: Floats) -> Fill:
    """Random contents of bins between two emptyings, by uniform draws (N, B) and mean object volumes (B,) [m3]."""
    count = np.minimum((draw * emptied).astype(np.int64), emptied - 1)
    return Fill(count, count * volume)


def volume_of(shape: Ints, size: Floats) -> Floats:
    """Volume of bodies by shape S and full extents S + (3,) [m]: S [m3]."""
    return np.asarray(_SHARE[shape] * size[..., 0] * size[..., 1] * size[..., 2])
