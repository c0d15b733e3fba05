"""Figures of a benchmark from its results: summaries, paired differences and multiples of the noise floor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from itertools import product
from typing import Any

from ..ground import metrics
from ..ground.cli import UsageError
from ..judging.record import Record, Result
from .entries import labels_of
from .plan import Plan, trial_name, trial_of_plan


def compare(
    record: type[Record], learned: Sequence[Result], reference: Sequence[Result], num_envs: int
) -> dict[str, Any]:
    """Difference of a learned controller and a reference on the same throws or shifts, with intervals.

    The figures are those of `Record.compared`. Each throw or shift is averaged over the seeds of a controller;
    `by_seed` compares each seed of the learned controller alone.
    """
    whole = _difference(record, learned, reference, num_envs)
    alone = [whole] if len(learned) == 1 else [_difference(record, [r], reference, num_envs) for r in learned]
    by_seed = [{"seed": r["seed"], **difference} for r, difference in zip(learned, alone, strict=True)]
    return {**whole, "by_seed": by_seed}


def assemble(plan: Plan, results: Sequence[Result]) -> dict[str, Any]:
    """Table and paired comparisons of a benchmark, as its JSON file holds them.

    Raises:
        UsageError: results of one level are not of the same objects and cannot be paired.
    """
    trial = trial_of_plan(plan)
    record = trial.record
    _check_paired(record, results)
    groups = _group_results(plan, results)
    table: list[dict[str, Any]] = []
    for (label, throws, level), group in groups.items():
        head = {"label": label, "throws": throws, "level": level, "train_level": group[0]["train_level"]}
        table.append({**head, "controller": group[0]["controller"], **record.summarise(group, plan.num_envs)})
    _add_floors(plan, table)
    comparisons: list[dict[str, Any]] = []
    for candidate, baseline, level in product(plan.learned, plan.references, plan.levels):
        learned, reference = (groups.get((choice.label, choice.throws, level)) for choice in (candidate, baseline))
        if learned and reference:
            head = {"level": level, "learned": candidate.model_dump(), "reference": baseline.model_dump()}
            comparisons.append({**head, **compare(record, learned, reference, plan.num_envs)})
    figures = {name: figure.style() for name, figure in record.figures.items()}
    head = {"trial": trial_name(plan), "unit": trial.unit, "step": trial.step, "figures": figures}
    return {**head, "table": table, "comparisons": comparisons}


def _group_results(plan: Plan, results: Sequence[Result]) -> dict[tuple[str, int, str], list[Result]]:
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


def _difference(
    record: type[Record], learned: Sequence[Result], reference: Sequence[Result], num_envs: int
) -> dict[str, Any]:
    difference: dict[str, Any] = {}
    sides = (learned, reference)
    candidate, baseline = (record.paired_columns(side, sides, num_envs) for side in sides)
    for name in candidate:
        # Mean over seeds (S, N) -> (N,); NaN where any seed was not measured.
        candidate_means, baseline_means = (
            [column.mean(axis=0) for column in side[name]] for side in (candidate, baseline)
        )
        interval = (
            metrics.rate_difference(*candidate_means, *baseline_means)
            if len(candidate_means) > 1
            else metrics.mean_difference(*candidate_means, *baseline_means)
        )
        difference[name] = {**asdict(interval), "excludes_zero": interval.excludes_zero}
    return difference


def _check_paired(record: type[Record], results: Sequence[Result]) -> None:
    first_results: dict[str, tuple[str, list[int]]] = {}
    for result in results:
        objects = record.objects(result["columns"])
        if objects is None:
            continue
        label, items = first_results.setdefault(result["level"], (result["label"], objects))
        if items != objects:
            raise UsageError(
                f"{label!r} and {result['label']!r} threw different objects on level {result['level']!r}; "
                "choose an environment whose objects do not depend on the actions"
            )
