"""The throw of Hassan et al. 2022 with a release in any direction: what the best motion under the same limits can do.

Same picks, targets, release ceiling, tolerance and vertical approach as Table I. The hand keeps above the falling
object until it is clear of it; its height and the window after the release are varied (`headroom/...`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cache
from typing import Any, Final

import numpy as np

from agents.reproduce.findings import Row
from agents.reproduce.hassan_cases import PERCENTAGES, PROTOCOLS, PUBLISHED, picks_per_min, scene
from agents.reproduce.hassan_simulated import ByMismatch, simulated_details
from agents.reproduce.hassan_table import DWELLS, KEPT
from agents.reproduce.simulation import stacked
from pnt_gym.planning import EllipticWorkspace, MotionLimits
from pnt_gym.planning.arrays import Bools, Floats, Ints
from pnt_gym.planning.cycle import Cycle
from pnt_gym.planning.free_optimum import FreeThrow, fastest_throw
from pnt_gym.planning.free_rules import SAMPLE_RATE, HandRules, check_throw
from pnt_gym.planning.plan import Reason
from pnt_gym.planning.trajectory import JerkTrajectory
from pnt_gym.robots.t3kr.geometry import T3KR

CYCLE: Final = PROTOCOLS["limits-respected"].rules
"""What Table I leaves open, as for the straight throw within the limits."""

RULES: Final = HandRules(
    approach=CYCLE.approach,
    window=0.0,
    hand_cap=0.15,
    clear_distance=0.12,
    margin=0.3,
    workspace=EllipticWorkspace(T3KR.workspace_x, T3KR.workspace_y, T3KR.z_min, T3KR.z_max),
)

KEPT_MISS: Final = math.sqrt(2.0) * CYCLE.tolerance + KEPT
"""Throws are aimed short of the target by delta along x or y, so by up to delta sqrt 2 [m]."""

CELLS: Final = tuple((zone, percent) for zone, percents in PERCENTAGES.items() for percent in percents)

Cell = tuple[str, int]


@cache
def free_cycle(zone: str, percent: float, rules: HandRules = RULES) -> Cycle:
    """The fastest cycles of the loop, one row per pick.

    Raises:
        NoMotionFound: for a pick of the loop nothing was found that keeps every bound.
    """
    limits = MotionLimits.t3kr(percent)
    points = scene(zone)
    throws = [
        fastest_throw(*ends, limits, ceiling=float(roof), tolerance=CYCLE.tolerance, rules=rules)
        for *ends, roof in zip(*points, ceilings(points[0]), strict=True)
    ]
    return _joined(throws)


def ceilings(picks: Floats) -> Floats:
    """Greatest height of the release from each pick (N, 3): (N,) [m]."""
    if CYCLE.rise is None:
        raise ValueError("Table I is made under a release ceiling")
    return picks[:, 2] + CYCLE.rise


def _joined(throws: list[FreeThrow]) -> Cycle:
    return as_cycle(
        stacked([throw.path for throw in throws]),
        np.array([throw.release_time for throw in throws]),
        np.stack([throw.position for throw in throws]),
        np.stack([throw.velocity for throw in throws]),
        np.ones(len(throws), dtype=np.bool_),
        np.full(len(throws), int(Reason.FEASIBLE)),
    )


def as_cycle(
    path: JerkTrajectory, release_time: Floats, position: Floats, velocity: Floats, feasible: Bools, reason: Ints
) -> Cycle:
    """Free throws, one row each, in the form of the other methods' cycles."""
    return Cycle(
        path=path,
        phases=("throw", "return"),
        phase_ends=np.stack([release_time, path.duration], axis=1),
        release_time=release_time,
        release_position=position,
        release_velocity=velocity,
        feasible=feasible,
        reason=reason,
    )


def bounds(rules: HandRules) -> str:
    """What sets one set of rules apart from another, in words."""
    window = f"a window of {1e3 * rules.window:.0f} ms" if rules.window else "no window"
    return f"the hand at most {rules.hand_cap:.2f} m above the release ceiling, {window} after the release"


def cell_rows(
    folder: str,
    planned: Mapping[Cell, Cycle],
    refused: Mapping[Cell, str],
    measured: Mapping[str, ByMismatch],
    rules: HandRules,
    note: str,
) -> list[Row]:
    """The row of every cell, planned or not."""
    rows: list[Row] = []
    for cell in CELLS:
        name = f"{folder}/{cell[0]}/{cell[1]}"
        if cell in refused:
            rows.append(Row(name, None, None, "picks/min", "infeasible", refused[cell]))
            continue
        details = {**free_details(cell, planned[cell], rules), **simulated_details(measured[name])}
        rows.append(Row(name, None, picks_per_min(planned[cell]), "picks/min", "ours", note, details))
    return rows


def free_details(cell: Cell, cycle: Cycle, rules: HandRules) -> dict[str, Any]:
    """How a cell's cycles compare with the published throw, and how they keep to limits and rules at 10 kHz."""
    picks, targets, _ = scene(cell[0])
    ceiling = ceilings(picks)
    check = check_throw(cycle.path, cycle.release_time, targets, MotionLimits.t3kr(cell[1]), ceiling, rules)
    best = float(PUBLISHED["min-time-throw", cell[0], cell[1]])
    top = cycle.sample(rate=SAMPLE_RATE).position[..., 2].max(axis=1) - ceiling
    kept = check.good(KEPT_MISS)
    level = np.hypot(cycle.release_velocity[:, 0], cycle.release_velocity[:, 1])
    return {
        "published_best": best,
        "over_published_best": picks_per_min(cycle) / best - 1.0,
        "limits_kept": bool(kept.all()),
        "peak_velocity_ratio": float(check.velocity.max()),
        "peak_acceleration_ratio": float(check.acceleration.max()),
        "peak_jerk_ratio": float(check.jerk.max()),
        "least_gap_m": float(check.gap.min()),
        "hand_above_ceiling_m": float(top.max()),
        "inside_workspace_m": float(-check.outside.max()),
        "planned_miss_m": float(check.landing.max()),
        "cycle_times_s": cycle.duration.tolist(),
        "release_times_s": cycle.release_time.tolist(),
        "release_angles_deg": np.degrees(np.arctan2(cycle.release_velocity[:, 2], level)).tolist(),
        **{f"picks_per_min_dwell_{dwell}": picks_per_min(cycle, dwell) for dwell in DWELLS},
    }
