"""Cycles of Table I simulated with the closed-chain robot in MuJoCo: figures of each plan, and sums over plans."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Final, TypeAlias, final

import numpy as np

from agents.reproduce.finding import Row
from pnt_gym.arrays import Floats, Point, take
from pnt_gym.cells.base.catalogue import PAPER_ITEMS
from pnt_gym.errors import PntGymError
from pnt_gym.robots.t3kr.geometry import T3KR

from .planning.cycle import Cycle
from .trial import Throws, Trials, run_trials

MISMATCHES: Final = (0.0, 1.0)
"""The planner's own world, and every unmodelled effect at its realistic strength."""


@final
@dataclass(frozen=True)
class TrialSummary:
    """Figures of the simulated cycles of one plan, lengths in m, torque in N m.

    Attributes:
        trials: number of simulated cycles.
        landing_error_mean: mean distance of the landing from the target; an object put down lands at its release.
        landing_error_max: largest distance of a landing from the target.
        landing_error_by_item: mean distance of the landing from the target by item.
        sorted: number of objects that landed in the opening and stayed in the bin.
        recontacts: number of objects that the cup touched after the release.
        clearance: smallest distance of cup and object from 20 ms after the release on.
        peak_torque: largest motor torque.
        release_tracking: largest distance of the hand from its reference at a release.
        tracking: largest distance of the hand from its reference at any time.
    """

    trials: int
    landing_error_mean: float
    landing_error_max: float
    landing_error_by_item: Mapping[str, float]
    sorted: int
    recontacts: int
    clearance: float
    peak_torque: float
    release_tracking: float
    tracking: float


ByMismatch: TypeAlias = Mapping[float, TrialSummary]


def simulate(
    plans: Mapping[str, tuple[Cycle, Point]], mismatches: Sequence[float] = MISMATCHES, threads: int = 1
) -> dict[str, dict[float, TrialSummary]]:
    """Simulate every cycle of every plan with each of the paper's three objects, at every strength of the mismatch.

    The hidden values of an object depend on item and pick only, so that all plans throw the same objects. Infeasible
    cycles are left out.

    Args:
        plans: cycles and their common target [m] by name.
        mismatches: strengths of the unmodelled effects.
        threads: worker threads; 1 by default, as parts of a reproduction run at the same time.

    Raises:
        PntGymError: a plan has no feasible cycle, or a cycle that the cell cannot execute (see `run_trials`).
    """
    return {
        name: {mismatch: _execute(name, *plan, mismatch, threads) for mismatch in mismatches}
        for name, plan in plans.items()
    }


def _execute(name: str, cycles: Cycle, target: Point, mismatch: float, threads: int) -> TrialSummary:
    picks = np.flatnonzero(cycles.feasible)
    if picks.size == 0:
        raise PntGymError(f"plan {name!r} holds no feasible cycle")
    rows, kinds = np.tile(picks, len(PAPER_ITEMS)), np.repeat(np.arange(len(PAPER_ITEMS)), picks.size)
    cycle = take(cycles, rows)
    throws = Throws(
        cycle.path.start,
        np.tile(target, (rows.size, 1)),
        [PAPER_ITEMS[kind] for kind in kinds],
        cycle.path,
        cycle.release_time,
        cycle.release_position,
        cycle.release_velocity,
    )
    trials = run_trials(throws, mismatch=mismatch, seeds=(kinds * len(cycles) + rows).tolist(), threads=threads)
    return _summarise(trials, np.split(trials.landing_error, len(PAPER_ITEMS)))


def _summarise(trials: Trials, errors: list[Floats]) -> TrialSummary:
    """Figures of all trials; ``errors`` holds their landing errors by item."""
    return TrialSummary(
        trials=len(trials),
        landing_error_mean=float(trials.landing_error.mean()),
        landing_error_max=float(trials.landing_error.max()),
        landing_error_by_item={name: float(error.mean()) for name, error in zip(PAPER_ITEMS, errors, strict=True)},
        sorted=int((trials.in_opening & trials.in_bin).sum()),
        recontacts=int(trials.recontact.sum()),
        clearance=float(trials.clearance.min()),
        peak_torque=float(trials.peak_torque.max()),
        release_tracking=float(trials.release_tracking.max()),
        tracking=float(trials.path_tracking.max()),
    )


def simulation_details(measured: ByMismatch) -> dict[str, Any]:
    """Entry of a plan's row: the figures at every strength of the mismatch."""
    return {"simulated": {f"{mismatch:g}": asdict(figures) for mismatch, figures in measured.items()}}


def simulation_rows(folder: str, plans: Iterable[ByMismatch]) -> list[Row]:
    """Rows with worst landing, touches and torque of several plans without mismatch, and share sorted with mismatch."""
    summaries = list(plans)
    ideal, realistic = ([figures[mismatch] for figures in summaries] for mismatch in MISMATCHES)
    of = f"of {sum(summary.trials for summary in ideal)} cycles in the simulator without mismatch"
    landing = f"largest distance from the target {of}; throws are aimed short by delta"
    touched = f"objects touched again by the cup, {of}"
    torque = f"largest motor torque; the motors give {T3KR.torque_limit:g} N m"
    landed = "in the opening and at rest in the bin, with every unmodelled effect at its realistic strength"
    share = 100.0 * sum(summary.sorted for summary in realistic) / sum(summary.trials for summary in realistic)
    peak = max(summary.peak_torque for figures in summaries for summary in figures.values())
    return [
        Row.ours(f"{folder}/landing-max", max(summary.landing_error_max for summary in ideal), "m", note=landing),
        Row.ours(f"{folder}/recontacts", float(sum(summary.recontacts for summary in ideal)), "-", note=touched),
        Row.ours(f"{folder}/peak-torque", peak, "N m", note=torque, limit=T3KR.torque_limit),
        Row.ours(f"{folder}/sorted-with-mismatch", share, "%", note=landed),
    ]
