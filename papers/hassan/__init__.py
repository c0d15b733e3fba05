"""Hassan et al. 2022, "Time-Optimal Pick-and-Throw S-Curve Trajectories for Fast Parallel Robots", computed anew."""

from __future__ import annotations

from functools import partial
from typing import Final

from agents.reproduce.finding import Parts

from . import figures, free, inconsistencies, methods, space, table
from .overview import overview

__all__ = ["PARTS", "SHORT", "overview"]

SHORT: Final = "Hassan et al. 2022"
PARTS: Final[Parts] = {
    "table1": table.table_findings,
    "free-direction": free.free_findings,
    "free-direction-constant-jerk": free.constant_jerk_findings,
    **{f"headroom-{variant}": partial(free.headroom_findings, variant) for variant in free.HEADROOM},
    "methods": methods.methods_findings,
    "inconsistencies": inconsistencies.inconsistency_findings,
    "figures": figures.figures_findings,
    "space": space.space_findings,
}
