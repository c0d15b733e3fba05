"""Choe et al. 2023, "An Approach for Elliptical Trajectory Planning with Vertical Straight Lines", computed anew."""

from __future__ import annotations

from typing import Final

from ..finding import Overview, Part
from ..grids import Rows
from . import ellipse, lengths, simulated, speed, times

SHORT: Final = "Choe et al. 2023"
PARTS: Final[tuple[Part, ...]] = (*ellipse.PARTS, *speed.PARTS, *lengths.PARTS, *times.PARTS, *simulated.PARTS)


def overview(rows: Rows) -> Overview:
    """Nothing draws on several parts: each has its own tables."""
    del rows
    return Overview()
