"""Leveziel et al., "A 4-DoF parallel robot with a built-in gripper for waste sorting", computed anew."""

from __future__ import annotations

from functools import partial
from typing import Final

from agents.reproduce.finding import Parts

from . import circle, closing, cycle, formulas, grasps, indices, moves, toss, workspace
from .toss import toss_overview as overview

__all__ = ["PARTS", "SHORT", "overview"]

SHORT: Final = "Leveziel et al."
PARTS: Final[Parts] = {
    "workspace": workspace.workspace_findings,
    "indices": indices.index_findings,
    "circle": circle.circle_findings,
    "moves": moves.move_findings,
    "closing": closing.closing_findings,
    "cycle": cycle.cycle_findings,
    "grasps": grasps.grasp_findings,
    "toss-planner": toss.planner_findings,
    **{f"toss-{name}": partial(toss.learner_findings, name, stages) for name, stages in toss.LEARNERS.items()},
    "formulas": formulas.formula_findings,
}
