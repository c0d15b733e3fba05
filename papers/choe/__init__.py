"""Choe et al. 2023, "An Approach for Elliptical Trajectory Planning with Vertical Straight Lines", computed anew."""

from __future__ import annotations

from typing import Final

from agents.reproduce.finding import Overview, Parts
from agents.reproduce.grids import Rows

from . import claims, ellipse, lengths, rivals, speed

SHORT: Final = "Choe et al. 2023"
PARTS: Final[Parts] = {
    "example": ellipse.example_findings,
    "length": ellipse.length_findings,
    "curvature": speed.curvature_findings,
    "speed": speed.speed_findings,
    "joints": speed.joint_findings,
    "claims": claims.claim_findings,
    "lengths": lengths.length_findings,
    "fig-8-times": rivals.rival_findings,
}


def overview(rows: Rows) -> Overview:
    """No tables over several parts: each part has its own tables."""
    del rows
    return Overview()
