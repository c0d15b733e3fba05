"""Leveziel et al., "A 4-DoF parallel robot with a built-in gripper for waste sorting", computed anew."""

from __future__ import annotations

from agents.reproduce import (
    leveziel_circle,
    leveziel_closing,
    leveziel_cycle,
    leveziel_formulas,
    leveziel_grasps,
    leveziel_indices,
    leveziel_moves,
    leveziel_toss,
    leveziel_workspace,
)
from agents.reproduce.findings import Part

PARTS: tuple[Part, ...] = (
    *leveziel_workspace.PARTS,
    *leveziel_indices.PARTS,
    *leveziel_circle.PARTS,
    *leveziel_moves.PARTS,
    *leveziel_closing.PARTS,
    *leveziel_cycle.PARTS,
    *leveziel_grasps.PARTS,
    *leveziel_toss.PARTS,
    *leveziel_formulas.PARTS,
)
