"""Figures of controllers, from the columns of throws that a benchmark keeps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from pnt_gym.arrays import Floats

from ...ground import metrics
from ..record import Result
from .columns import OUTCOMES
from .data import over_the_shift

COUNTS: Final = ("passed", "ended", "belong", "dropped", "tries", "energy_j")
"""Columns of a result that hold totals of all its throws."""


def errors(result: Result) -> Floats:
    """Landing error of each throw [m], NaN where it was not measured."""
    columns = result["columns"]
    if "error_m" in columns:
        return np.array(columns["error_m"], dtype=float)
    return np.hypot(np.array(columns["along_m"], dtype=float), np.array(columns["across_m"], dtype=float))


def successes(result: Result, *outcomes: str) -> Floats:
    """1.0 for each throw with one of the outcomes, else 0.0 (N,); by default with a success, `sorted` or `astray`."""
    letters = [OUTCOMES[name] for name in outcomes or ("sorted", "astray")]
    return np.array([letter in letters for letter in result["columns"]["outcome"]], dtype=float)


def _by_seed(results: Sequence[Result]) -> tuple[Floats, Floats, Floats]:
    """Landing errors [m], sorted counts and cycle times [s] of S seeds and N throws, each (S, N)."""
    time = np.array([r["columns"]["cycle_s"] for r in results], dtype=float)
    return np.array([errors(r) for r in results]), np.array([successes(r, "sorted") for r in results]), time


def by_shift(results: Sequence[Result], num_envs: int) -> tuple[Floats, Floats, Floats]:
    """Landing errors [m], sorted counts and times [s], each (S, N): per throw, or per shift in cells with shifts.

    Throws of one shift depend on one another. The error of a shift is the mean over its throws, count and time are
    sums.
    """
    error, sorted_throws, time = _by_seed(results)
    if "pick" not in results[0]["columns"]:
        return error, sorted_throws, time
    picks = max(results[0]["columns"]["pick"]) + 1

    def shifts(column: Floats) -> Floats:
        return column.reshape(len(results), -1, picks, num_envs).swapaxes(1, 2).reshape(len(results), picks, -1)

    return np.nanmean(shifts(error), axis=1), shifts(sorted_throws).sum(axis=1), shifts(time).sum(axis=1)


def _over_the_shift(results: Sequence[Result]) -> dict[str, Any]:
    """Number of shifts, and their landing error at the begin, in the second half and by throw; empty without shifts."""
    if "pick" not in results[0]["columns"]:
        return {}
    error = np.concatenate([errors(r) for r in results])
    pick = np.concatenate([r["columns"]["pick"] for r in results])
    by_pick = [float(np.nanmean(error[pick == k])) for k in range(int(pick.max()) + 1)]
    count = len(pick) // len(by_pick) // len(results)
    return {"shifts": count, **over_the_shift(error, pick), "landing_error_by_pick_m": by_pick}


def summarise(results: Sequence[Result], num_envs: int) -> dict[str, Any]:
    """Figures of one controller over its seeds; each throw counts once per seed.

    The interval of the error is bootstrapped over throws, or over shifts if there are any, averaged over the seeds.
    """
    error, sorted_throws, time = _by_seed(results)
    success = np.array([successes(r) for r in results])
    where = metrics.landing(error.ravel())
    pace = metrics.throughput(sorted_throws.ravel(), time.ravel())
    unit_errors = by_shift(results, num_envs)[0].mean(axis=0)
    mean = metrics.mean_interval(unit_errors[np.isfinite(unit_errors)])
    rate = metrics.wilson(round(float(success.mean()) * success.shape[1]), success.shape[1])
    letters = "".join(r["columns"]["outcome"] for r in results)
    return {
        "seeds": [r["seed"] for r in results],
        "landing_error_mean_m": where.mean,
        "landing_error_low_m": mean.low,
        "landing_error_high_m": mean.high,
        "landing_error_p95_m": where.p95,
        "landing_error_iqm_m": where.iqm,
        "landing_near_share": where.near,
        "landing_error_by_seed_m": [float(np.nanmean(e)) for e in error],
        **_over_the_shift(results),
        **_scatter(results),
        "unmeasured": where.unmeasured,
        "success_rate": float(success.mean()),
        "success_low": rate.low,
        "success_high": rate.high,
        "picks_per_min": pace.attempted,
        "sorted_per_min": pace.sorted,
        "cycle_time_mean_s": pace.cycle_time,
        **{f"share_{name}": letters.count(letter) / len(letters) for name, letter in OUTCOMES.items()},
        "clipped_rate": sum(r["columns"]["clipped"] for r in results) / len(letters),
        "recontact_rate": sum(r["columns"]["recontact"] for r in results) / len(letters),
        **_sorting(results, letters),
        "learn_seconds": float(np.mean([r["learn_seconds"] for r in results])),
    }


def _sorting(results: Sequence[Result], letters: str) -> dict[str, float]:
    """Figures of sorting beside the pace, where the cell has them."""
    first, sorted_count = results[0]["columns"], letters.count(OUTCOMES["sorted"])
    total = {name: sum(r["columns"][name] for r in results) for name in COUNTS if name in first}
    picked_count, figures = len(letters) - letters.count(OUTCOMES["unpicked"]), dict[str, float]()
    if "passed" in total:
        figures["recovery"] = sorted_count / (len(letters) + total["passed"])
    if "tries" in total:
        figures["tries_per_pick"] = total["tries"] / len(letters)
    if total.get("ended"):
        figures["purity"] = total["belong"] / total["ended"]
    if "dropped" in total and picked_count:
        figures |= {"pick_rate": picked_count / len(letters), "drop_rate": total["dropped"] / picked_count}
    return figures | ({"energy_per_pick_j": total["energy_j"] / len(letters)} if "energy_j" in total else {})


def _scatter(results: Sequence[Result]) -> dict[str, float]:
    """Mean and standard deviation of the landing along and across the throw, where the cell has them."""
    figures: dict[str, float] = {}
    for name in ("along_m", "across_m"):
        if name in results[0]["columns"]:
            values = np.concatenate([r["columns"][name] for r in results]).astype(float)
            figures |= {f"bias_{name}": float(np.nanmean(values)), f"spread_{name}": float(np.nanstd(values))}
    return figures
