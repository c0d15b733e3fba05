"""Hassan et al. 2022, "Time-Optimal Pick-and-Throw S-Curve Trajectories for Fast Parallel Robots", computed anew."""

from __future__ import annotations

from agents.reproduce import hassan_figures, hassan_free, hassan_inconsistencies, hassan_methods, hassan_table
from agents.reproduce.findings import Part

PARTS: tuple[Part, ...] = (
    *hassan_table.PARTS,
    *hassan_free.PARTS,
    *hassan_methods.PARTS,
    *hassan_inconsistencies.PARTS,
    *hassan_figures.PARTS,
)
