"""Miyashita et al., "Parts Assembly and Sorting by Throwing Manipulation: Planning and Control", computed anew."""

from __future__ import annotations

from functools import partial
from typing import Final

from agents.reproduce.finding import Overview, Parts
from agents.reproduce.grids import Rows, plain

from . import acceptance, accessible, cases, contact, contact_learning, example, formulas, learning, margins, tasks

SHORT: Final = "Miyashita et al."
PARTS: Final[Parts] = {
    "example": example.example_findings,
    "margins": margins.margin_findings,
    "accessible": accessible.accessible_findings,
    "learning": learning.learning_findings,
    **{f"acceptance-{1e3 * late:.0f}ms": partial(acceptance.acceptance_findings, late) for late in cases.DELAYS},
    "contact": contact.contact_findings,
    "contact-reach": contact.reach_findings,
    "contact-learning": contact_learning.learning_findings,
    "contact-level": contact_learning.level_findings,
    "sorting": tasks.sorting_findings,
    "assembly": tasks.assembly_findings,
    "formulas": formulas.formula_findings,
}
_FOLDERS: Final = ("miyashita/scatter/", "miyashita/slopes/")


def overview(rows: Rows) -> Overview:
    """Tables on random goals over all delays, as far as their rows were computed."""
    limits = [row for name, row in rows.items() if name.startswith(_FOLDERS)]
    grids = {
        "acceptance": acceptance.acceptance_grid(rows),
        "limits": plain("What bounds learning at random goals: scatter and slopes", limits, drop="miyashita/"),
    }
    return Overview({name: grid for name, grid in grids.items() if grid.rows})
