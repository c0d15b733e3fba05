"""Miyashita et al. 2010, "Parts Assembly and Sorting by Throwing Manipulation: Planning and Control", computed anew."""

from __future__ import annotations

from typing import Final

from ..finding import Overview, Part
from ..grids import Rows, plain
from . import (
    acceptance,
    accessible,
    contact,
    contact_learning,
    contact_level,
    contact_reach,
    example,
    formulas,
    learning,
    tasks,
)

SHORT: Final = "Miyashita et al. 2010"
PARTS: Final[tuple[Part, ...]] = (
    *example.PARTS,
    *accessible.PARTS,
    *learning.PARTS,
    *acceptance.PARTS,
    *contact.PARTS,
    *contact_reach.PARTS,
    *contact_learning.PARTS,
    *contact_level.PARTS,
    *tasks.PARTS,
    *formulas.PARTS,
)
_FOLDERS: Final = ("miyashita/scatter/", "miyashita/slopes/")


def overview(rows: Rows) -> Overview:
    """Tables over all delays of the random goals."""
    limits = [row for name, row in rows.items() if name.startswith(_FOLDERS)]
    grids = {
        "acceptance": acceptance.acceptance_grid(rows),
        "limits": plain("What bounds learning at random goals: scatter and slopes", limits, drop="miyashita/"),
    }
    return Overview({name: grid for name, grid in grids.items() if grid.rows})
