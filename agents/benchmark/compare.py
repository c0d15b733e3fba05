"""From throws or shifts to figures: summaries, paired differences and multiples of the noise floor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from itertools import product
from typing import Any

import numpy as np

from pnt_gym.arrays import Floats

from ..ground import metrics
from ..ground.cli import UsageError
from ..judging.throws import over_the_shift
from . import lines
from .entries import labels_of
from .plan import Plan
from .run import OUTCOMES

Result = Mapping[str, Any]
COUNTS = ("passed", "ended", "belong", "dropped", "energy_j")
"""Columns of a result that are of all its throws together."""


def errors(result: Result) -> Floats:
    """Landing error of each throw [m], NaN where it was not measured."""
    columns = result["columns"]
    if "error_m" in columns:
        return np.array(columns["error_m"], dtype=float)
    return np.hypot(np.array(columns["along_m"], dtype=float), np.array(columns["across_m"], dtype=float))


def successes(result: Result, *outcomes: str) -> Floats:
    """1 for each throw that ended so, else 0; in its bin, of the right kind or not, unless `outcomes` say otherwise."""
    letters = [OUTCOMES[name] for name in outcomes or ("sorted", "astray")]
    return np.array([letter in letters for letter in result["columns"]["outcome"]], dtype=float)


def _by_seed(results: Sequence[Result]) -> tuple[Floats, Floats, Floats]:
    """Errors [m], what was sorted, and cycle times [s], each (S, N)."""
    time = np.array([r["columns"]["cycle_s"] for r in results], dtype=float)
    return np.array([errors(r) for r in results]), np.array([successes(r, "sorted") for r in results]), time


def _by_shift(plan: Plan, results: Sequence[Result]) -> tuple[Floats, Floats, Floats]:
    """The same, each (S, N) with one column for every shift, where throws of a shift depend on one another.

    The error of a shift is the mean over its throws, the others are sums.
    """
    error, done, time = _by_seed(results)
    if "pick" not in results[0]["columns"]:
        return error, done, time
    picks = max(results[0]["columns"]["pick"]) + 1

    def shifts(column: Floats) -> Floats:
        return column.reshape(len(results), -1, picks, plan.num_envs).swapaxes(1, 2).reshape(len(results), picks, -1)

    return np.nanmean(shifts(error), axis=1), shifts(done).sum(axis=1), shifts(time).sum(axis=1)


def _over_the_shift(results: Sequence[Result]) -> dict[str, Any]:
    """How many shifts, their landing error at the beginning, in the second half and by throw; nothing without any."""
    if "pick" not in results[0]["columns"]:
        return {}
    error = np.concatenate([errors(r) for r in results])
    pick = np.concatenate([r["columns"]["pick"] for r in results])
    by_pick = [float(np.nanmean(error[pick == k])) for k in range(int(pick.max()) + 1)]
    count = len(pick) // len(by_pick) // len(results)
    return {"shifts": count, **over_the_shift(error, pick), "landing_error_by_pick_m": by_pick}


def summarise(plan: Plan, results: Sequence[Result]) -> dict[str, Any]:
    """Figures of one controller over its seeds: each throw counts once per seed.

    The interval of the error is bootstrapped over throws, or over shifts where there are any, averaged over the seeds.
    """
    if _of_line(results):
        return lines.summarise(results)
    error, done, time = _by_seed(results)
    success = np.array([successes(r) for r in results])
    where = metrics.landing(error.ravel())
    pace = metrics.throughput(done.ravel(), time.ravel())
    each = _by_shift(plan, results)[0].mean(axis=0)
    mean = metrics.mean_interval(each[np.isfinite(each)])
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
    """What a sorter is judged by beside its pace, where the cell tells."""
    first, done = results[0]["columns"], letters.count(OUTCOMES["sorted"])
    total = {name: sum(r["columns"][name] for r in results) for name in COUNTS if name in first}
    held, found = len(letters) - letters.count(OUTCOMES["unpicked"]), dict[str, float]()
    if "passed" in total:
        found["recovery"] = done / (len(letters) + total["passed"])
    if total.get("ended"):
        found["purity"] = total["belong"] / total["ended"]
    if "dropped" in total and held:
        found |= {"pick_rate": held / len(letters), "drop_rate": total["dropped"] / held}
    return found | ({"energy_per_pick_j": total["energy_j"] / len(letters)} if "energy_j" in total else {})


def _scatter(results: Sequence[Result]) -> dict[str, float]:
    """Mean and standard deviation of the landing along and across, where the cell has them."""
    found: dict[str, float] = {}
    for name in ("along_m", "across_m"):
        if name in results[0]["columns"]:
            values = np.concatenate([r["columns"][name] for r in results]).astype(float)
            found |= {f"bias_{name}": float(np.nanmean(values)), f"spread_{name}": float(np.nanstd(values))}
    return found


def compare(plan: Plan, learned: Sequence[Result], reference: Sequence[Result]) -> dict[str, Any]:
    """Learned less reference on the same throws or shifts, with intervals: what `_compared` gives.

    A throw or shift is averaged over the seeds of each side; `by_seed` compares each learned seed alone.
    """
    by_seed = [{"seed": r["seed"], **_difference(plan, [r], reference)} for r in learned]
    return {**_difference(plan, learned, reference), "by_seed": by_seed}


def assemble(plan: Plan, results: Sequence[Result]) -> dict[str, Any]:
    """Everything the benchmark says.

    Raises:
        UsageError: results of one level are not of the same objects, so nothing is paired.
    """
    _check_paired(results)
    groups = _grouped(plan, results)
    table: list[dict[str, Any]] = []
    for (label, throws, level), group in groups.items():
        head = {"label": label, "throws": throws, "level": level, "train_level": group[0]["train_level"]}
        table.append({**head, "controller": group[0]["controller"], **summarise(plan, group)})
    _add_floors(plan, table)
    comparisons: list[dict[str, Any]] = []
    for mine, other, level in product(plan.learned, plan.references, plan.levels):
        learned, reference = (groups.get((choice.label, choice.throws, level)) for choice in (mine, other))
        if learned and reference:
            head = {"level": level, "learned": mine.model_dump(), "reference": other.model_dump()}
            comparisons.append({**head, **compare(plan, learned, reference)})
    return {"table": table, "comparisons": comparisons}


def _grouped(plan: Plan, results: Sequence[Result]) -> dict[tuple[str, int, str], list[Result]]:
    groups: dict[tuple[str, int, str], list[Result]] = {}
    order = [label for entry in plan.entries for label in labels_of(entry)]
    for result in sorted(results, key=lambda r: (order.index(r["label"]), r["throws"], r["seed"])):
        groups.setdefault((result["label"], result["throws"], result["level"]), []).append(result)
    return groups


def _add_floors(plan: Plan, table: list[dict[str, Any]]) -> None:
    for level, label in plan.floors.items():
        rows = [row for row in table if row["level"] == level]
        floors = sorted((r["throws"], r["landing_error_mean_m"]) for r in rows if r["label"] == label)
        floor = floors[-1][1] if floors else None  # after most throws
        for row in rows:
            row["times_floor"] = None if floor is None else row["landing_error_mean_m"] / floor


def _difference(plan: Plan, learned: Sequence[Result], reference: Sequence[Result]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    mine, base = (_compared(plan, side, learned, reference) for side in (learned, reference))
    for name in mine:
        # Mean over seeds (S, N) -> (N,); NaN where any seed was not measured.
        one, other = ([column.mean(axis=0) for column in side[name]] for side in (mine, base))
        interval = metrics.paired_rate(*one, *other) if len(one) > 1 else metrics.paired_mean(*one, *other)
        found[name] = {**asdict(interval), "excludes_zero": interval.excludes_zero}
    return found


def _compared(plan: Plan, results: Sequence[Result], *sides: Sequence[Result]) -> dict[str, tuple[Floats, ...]]:
    """What is compared, each (S, N): of throws one figure, or what was sorted and in what time; of a line of shifts."""
    if _of_line(results):
        return lines.compared(results, min(len(side[0]["columns"]["value_per_min"]) for side in sides))
    error, done, time = _by_shift(plan, results)
    return {"landing_error_m": (error,), "sorted_per_min": (done, time)}


def _of_line(results: Sequence[Result]) -> bool:
    """Whether results are of shifts at a line."""
    return "value_per_min" in results[0]["columns"]


def _check_paired(results: Sequence[Result]) -> None:
    seen: dict[str, tuple[str, list[int]]] = {}
    for result in results:
        # Shifts of the same drift and stream are paired, whatever is picked when.
        if "pick" in result["columns"] or _of_line([result]):
            continue
        label, items = seen.setdefault(result["level"], (result["label"], result["columns"]["item"]))
        if items != result["columns"]["item"]:
            raise UsageError(
                f"{label!r} and {result['label']!r} threw different objects on level {result['level']!r}; "
                "choose an environment whose objects do not depend on the actions"
            )
