"""Leveziel et al., "A 4-DoF parallel robot with a built-in gripper for waste sorting", computed anew."""

from __future__ import annotations

from typing import Final

from agents.reproduce.finding import Overview, Parts
from agents.reproduce.grids import Rows

from . import circle, closing, cycle, formulas, grasps, indices, moves, workspace

SHORT: Final = "Leveziel et al."
PARTS: Final[Parts] = {
    "workspace": workspace.workspace_findings,
    "indices": indices.index_findings,
    "circle": circle.circle_findings,
    "moves": moves.move_findings,
    "closing": closing.closing_findings,
    "cycle": cycle.cycle_findings,
    "grasps": grasps.grasp_findings,
    "formulas": formulas.formula_findings,
}


def overview(rows: Rows) -> Overview:
    """No tables over several parts: each part has its own tables."""
    del rows
    return Overview()
