"""Hassan et al. 2022, "Time-Optimal Pick-and-Throw S-Curve Trajectories for Fast Parallel Robots", computed anew."""

from __future__ import annotations

from typing import Final

from ..finding import Part
from . import figures, free, inconsistencies, methods, table
from .overview import overview

__all__ = ["PARTS", "SHORT", "overview"]

SHORT: Final = "Hassan et al. 2022"
PARTS: Final[tuple[Part, ...]] = (
    *table.PARTS,
    *free.PARTS,
    *methods.PARTS,
    *inconsistencies.PARTS,
    *figures.PARTS,
)
