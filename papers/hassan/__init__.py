"""Hassan et al. 2022, "Time-Optimal Pick-and-Throw S-Curve Trajectories for Fast Parallel Robots", computed anew."""

from __future__ import annotations

from typing import Final

from agents.reproduce.finding import Parts

from . import figures, methods, space, statements, table
from .overview import overview

__all__ = ["PARTS", "SHORT", "overview"]

SHORT: Final = "Hassan et al. 2022"
PARTS: Final[Parts] = {
    "table1": table.table_findings,
    "methods": methods.methods_findings,
    "statements": statements.statement_findings,
    "figures": figures.figures_findings,
    "space": space.space_findings,
}
