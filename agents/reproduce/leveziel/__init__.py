"""Leveziel et al., "A 4-DoF parallel robot with a built-in gripper for waste sorting", computed anew."""

from __future__ import annotations

from typing import Final

from ..finding import Part
from . import circle, closing, cycle, formulas, grasps, indices, moves, toss, workspace
from .toss import toss_overview as overview

__all__ = ["PARTS", "SHORT", "overview"]

SHORT: Final = "Leveziel et al."
PARTS: Final[tuple[Part, ...]] = (
    *workspace.PARTS,
    *indices.PARTS,
    *circle.PARTS,
    *moves.PARTS,
    *closing.PARTS,
    *cycle.PARTS,
    *grasps.PARTS,
    *toss.PARTS,
    *formulas.PARTS,
)
