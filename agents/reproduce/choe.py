"""Choe et al. 2023, "An Approach for Elliptical Trajectory Planning with Vertical Straight Lines", computed anew."""

from __future__ import annotations

from agents.reproduce import choe_ellipse, choe_lengths, choe_simulated, choe_speed, choe_times
from agents.reproduce.findings import Part

PARTS: tuple[Part, ...] = (
    *choe_ellipse.PARTS,
    *choe_speed.PARTS,
    *choe_lengths.PARTS,
    *choe_times.PARTS,
    *choe_simulated.PARTS,
)
