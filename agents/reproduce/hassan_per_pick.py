"""The throw in a free direction as a cell plans it, pick by pick: how much it loses and how long it takes."""

from __future__ import annotations

import time
from collections.abc import Mapping
from typing import Final

import numpy as np

from agents.reproduce.findings import Row
from agents.reproduce.hassan_cases import TARGETS, picks_per_min, scene
from agents.reproduce.hassan_free_cells import CYCLE, KEPT_MISS, RULES, Cell, as_cycle, ceilings
from pnt_gym.config import load
from pnt_gym.planning import MotionLimits
from pnt_gym.planning.arrays import Floats
from pnt_gym.planning.cycle import Cycle
from pnt_gym.planning.free_batch import FreeThrows, plan_free_throws
from pnt_gym.planning.free_rules import check_throw
from pnt_gym.planning.plan import Reason

BATCH: Final = 256
ROUNDS: Final = 9
TIMED: Final = (("inside", 40), ("outside", 45))
"""Cells whose target and limits the timed picks have."""


def per_pick_cycle(zone: str, percent: float) -> Cycle:
    """The cycles of the loop planned in one batch; a row without a throw is infeasible."""
    picks, targets, following = scene(zone)
    found = _planned(picks, targets, following, MotionLimits.t3kr(percent))
    reason = np.where(found.feasible, int(Reason.FEASIBLE), int(Reason.CEILING))
    return as_cycle(found.path, found.release_time, found.position, found.velocity, found.feasible, reason)


def _planned(picks: Floats, targets: Floats, following: Floats, limits: MotionLimits) -> FreeThrows:
    roof = ceilings(picks)
    return plan_free_throws(picks, targets, following, limits, ceiling=roof, tolerance=CYCLE.tolerance, rules=RULES)


def loss_rows(folder: str, quick: Mapping[Cell, Cycle], optimum: Mapping[Cell, Cycle]) -> list[Row]:
    """The largest loss of picks per minute against the optimum."""
    both = [cell for cell in quick if cell in optimum]
    if not both:
        return []
    loss = {cell: 100.0 * (1.0 - picks_per_min(quick[cell]) / picks_per_min(optimum[cell])) for cell in both}
    worst = max(both, key=lambda cell: loss[cell])
    note = f"largest loss of picks/min against the optimum, at {worst[0]}/{worst[1]}"
    by_cell = {f"{zone}/{percent}": value for (zone, percent), value in loss.items()}
    return [Row(f"{folder}/loss-max", None, loss[worst], "%", "ours", note, {"loss_by_cell": by_cell})]


def timing_rows(folder: str) -> list[Row]:
    """Processor time per pick in a batch of random picks of the belt, and what came of them."""
    rows: list[Row] = []
    for zone, percent in TIMED:
        picks, following = random_picks()
        targets, limits = np.tile(TARGETS[zone], (BATCH, 1)), MotionLimits.t3kr(percent)
        seconds: list[float] = []
        found = _planned(picks, targets, following, limits)
        for _ in range(ROUNDS):
            began = time.thread_time()
            found = _planned(picks, targets, following, limits)
            seconds.append((time.thread_time() - began) / BATCH)
        good = found.feasible
        checked = check_throw(
            found.path.take(good), found.release_time[good], targets[good], limits, ceilings(picks[good]), RULES
        )
        kept = int(checked.good(KEPT_MISS).sum())
        note = f"best of {ROUNDS} batches of {BATCH} random picks of the belt at {percent} %, target {zone}, one core"
        details = {
            "picks": BATCH,
            "planned": int(good.sum()),
            "straight": int((found.straight & good).sum()),
            "limits_kept": kept,
        }
        name = f"{folder}/time-per-pick-{zone}-{percent}"
        rows.append(Row(name, None, 1e6 * min(seconds), "us", "ours", note, details))
    return rows


def random_picks() -> tuple[Floats, Floats]:
    """Picks and next picks, each (BATCH, 3) [m], where a belt brings its objects; fixed seed."""
    belt = load("nominal").belt
    rng = np.random.default_rng(256)
    low, high = (np.array([belt.pick_x[k], belt.lane_y[k]]) for k in (0, 1))
    level = np.full((2, BATCH, 1), scene("inside")[0][0, 2])
    points = np.concatenate([rng.uniform(low, high, (2, BATCH, 2)), level], axis=2)
    return points[0], points[1]
