"""Miyashita et al., "Parts Assembly and Sorting by Throwing Manipulation: Planning and Control", computed anew."""

from __future__ import annotations

from typing import Final

from agents.reproduce.finding import Overview, Parts
from agents.reproduce.grids import Rows

from . import acceptance, accessible, example, formulas, learning, margins, tasks

SHORT: Final = "Miyashita et al."
PARTS: Final[Parts] = {
    "example": example.example_findings,
    "margins": margins.margin_findings,
    "accessible": accessible.accessible_findings,
    "learning": learning.learning_findings,
    "acceptance": acceptance.acceptance_findings,
    "sorting": tasks.sorting_findings,
    "assembly": tasks.assembly_findings,
    "formulas": formulas.formula_findings,
}


def overview(rows: Rows) -> Overview:
    """No tables over several parts: each part has its own tables."""
    del rows
    return Overview()
