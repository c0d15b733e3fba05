"""Bins that fill: how deep they still are for the next throw, by what lies in them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Floats, Ints
from pnt_gym.cells.base.items import ItemTable
from pnt_gym.cells.conveyor.config import ConveyorConfig

LEAST_DEPTH: Final = 0.02
"""However much lies in a bin, it is level, and so deep [m]: what would rise higher slides over the rim, or is raked."""
_SHARE: Final = np.array([np.pi / 6.0, np.pi / 4.0, 1.0])
"""Volume of each shape over that of the box around it."""


@final
@dataclass(frozen=True)
class Fill:
    """What lies in the B bins of N cells."""

    count: Ints
    """Objects since they were emptied (N, B)."""
    volume: Floats
    """Of these objects alone, without what is between them (N, B) [m3]."""

    @classmethod
    def nothing(cls, *shape: int) -> Fill:
        """Empty bins (N, B)."""
        return cls(np.zeros(shape, dtype=np.int64), np.zeros(shape))

    def after(self, ended_in: Ints, volume: Floats, emptied: int) -> Fill:
        """What lies there when objects of some volume (N,) have ended in bins (N,), in none where -1.

        A bin is emptied as soon as so many objects lie in it.
        """
        came = np.arange(self.count.shape[1], dtype=np.int64) == ended_in[:, None]
        count = self.count + came
        full = count >= emptied
        return Fill(np.where(full, 0, count), np.where(full, 0.0, self.volume + came * volume[:, None]))

    def depth(self, area: Floats, config: ConveyorConfig) -> Floats:
        """How deep bins of an area (N, B) or (B,) [m2] are above what lies in them, level (N, B) [m]."""
        bins = config.bins
        left = bins.depth - self.volume / (bins.packing * area)
        return np.maximum(left, min(LEAST_DEPTH, bins.depth))


def drawn_fill(draw: Floats, config: ConveyorConfig, table: ItemTable) -> Fill:
    """Bins at any moment between two emptyings, by uniform draws (N, B): objects of the mean volume they take."""
    emptied = config.bins.emptied or 1
    count = np.minimum((draw * emptied).astype(np.int64), emptied - 1)
    own = volume_of(table.shape, table.size)
    takes = config.acceptance() if config.bins.fixed else np.full((len(own), 1), True)
    return Fill(count, count * ((own @ takes) / takes.sum(axis=0)))


def volume_of(shape: Ints, size: Floats) -> Floats:
    """Volume of bodies by shape S and full extents S + (3,) [m]: S [m3]."""
    return np.asarray(_SHARE[shape] * size[..., 0] * size[..., 1] * size[..., 2])
