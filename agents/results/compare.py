"""Figures of a benchmark from its results: summaries, paired differences and multiples of the noise floor.

A file of results may be a stranger's. The rows must be those that the file's plan asks for, each number in its range;
table and comparisons are computed from the rows anew, and a file that says otherwise is refused.
"""

from __future__ import annotations

import json
import math
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from itertools import product
from pathlib import Path
from typing import Any, Final

from pydantic import ValidationError

from pnt_gym.cells.base.problems import list_problems
from pnt_gym.errors import PntGymError, one_sentence
from pnt_gym.names import unknown_name

from ..ground import metrics
from ..ground.cli import UsageError
from ..ground.files import check_form, json_text
from ..ground.places import SHIPPED
from ..ground.shipped import module_of
from ..judging.record import Record, Result
from . import entries
from .content import ABOUT, ROW, Content, name_row, read_form
from .plan import Plan, entries_by_level, read_plan, seeds_of, trial_name, trial_of_plan

BENCHMARKS: Final = {
    "PnTRelease-v0": SHIPPED / "configs" / "benchmark.yaml",
    "PnTGrasp-v0": SHIPPED / "configs" / "benchmark_grasp.yaml",
    "PnTLine-v0": SHIPPED / "configs" / "benchmark_line.yaml",
}
"""Plans whose held-out throws or work shifts submissions have, by environment."""
FRAME: Final = ("env", "levels", "inline", "picks", "picks_on", "shifts", "seed", "num_envs")
"""Keys of a plan by which held-out throws and work shifts are named."""
NEARLY: Final = 1e-9
"""Relative difference of two figures that the order of sums explains."""


FORMER: Final = re.compile(r"comparisons\.\d+\.by_seed|table\.\d+\.by_shift\.\w+")
"""What files of earlier versions show beside it, and nobody reads: the rows have it."""


def assemble(plan: Plan, results: Sequence[Result]) -> dict[str, Any]:
    """Table and paired comparisons of a benchmark, as its JSON file holds them.

    Raises:
        UsageError: results of one level are not of the same objects and cannot be paired.
    """
    trial = trial_of_plan(plan)
    record = trial.record
    # Results of one level must be of the same objects.
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
    groups: dict[tuple[str, int, str], list[Result]] = {}
    order = [label for entry in plan.entries for label in entries.labels(entry)]
    for result in sorted(results, key=lambda r: (order.index(r["label"]), r["throws"], r["seed"])):
        groups.setdefault((result["label"], result["throws"], result["level"]), []).append(result)
    table: list[dict[str, Any]] = []
    for (label, throws, level), group in groups.items():
        head = {"label": label, "throws": throws, "level": level, "train_level": group[0]["train_level"]}
        table.append({**head, "controller": group[0]["controller"], **record.summarise(group, plan.num_envs)})
    for level, label in plan.floors.items():
        rows = [row for row in table if row["level"] == level]
        floors = sorted((r["throws"], r["landing_error_mean_m"]) for r in rows if r["label"] == label)
        floor = floors[-1][1] if floors else None  # after most throws
        for row in rows:
            row["times_floor"] = None if floor is None else row["landing_error_mean_m"] / floor
    comparisons: list[dict[str, Any]] = []
    for candidate, baseline, level in product(plan.learned, plan.references, plan.levels):
        learned, reference = (groups.get((choice.label, choice.throws, level)) for choice in (candidate, baseline))
        if learned and reference:
            head = {"level": level, "learned": candidate.model_dump(), "reference": baseline.model_dump()}
            comparisons.append({**head, **compare(record, learned, reference, plan.num_envs)})
    figures = {name: figure.style() for name, figure in record.figures.items()}
    head = {"trial": trial_name(plan), "unit": trial.unit, "step": trial.step, "figures": figures}
    return {**head, "table": table, "comparisons": comparisons}


def compare(
    record: type[Record], learned: Sequence[Result], reference: Sequence[Result], num_envs: int
) -> dict[str, Any]:
    """Difference of a learned controller and a reference on the same throws or shifts, with intervals.

    The figures are those of `Record.compared`. Each throw or shift is averaged over the seeds of a controller.
    """
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
            else metrics.difference(*candidate_means, *baseline_means)
        )
        difference[name] = {**asdict(interval), "excludes_zero": interval.excludes_zero}
    return difference


# What a file shows


def check(content: Content, *, trust: bool = False) -> Content:
    """The same content, if its figures are those of its rows.

    The last digits of its figures stay: rounding differs from machine to machine, and drawings are named by digits.

    Args:
        content: content of a file, of which the form is checked.
        trust: import the module of the environment that the file names.

    Raises:
        UsageError: the file says other than its rows, or names a module.
    """
    plan, data, path = content
    if module_of(plan.env) is not None and not trust:
        raise untrusted(path, plan.env)
    _check(path, plan, data["results"])
    for key, figure in _figures(path, plan, data["results"]).items():
        difference = _contradiction(data[key], figure, key)
        if difference is not None:
            raise UsageError(f"{str(path)!r} shows what its {data['unit']} do not give: {difference}")
    return content


def untrusted(path: Path, name: str) -> UsageError:
    """Error of a file that names a module, which nobody has said to trust."""
    return UsageError(f"{str(path)!r} names {name!r}: importing the module runs its code; give --trust if it is yours")


def _check(path: Path, plan: Plan, rows: Sequence[Mapping[str, Any]]) -> None:
    """Make sure that rows are those of a plan, each once, and that their columns have the form of its trial.

    Raises:
        UsageError: a row is missing, stands twice, is of no entry, or has other columns.
    """
    expected = _rows(plan)
    counts = Counter(tuple(row[name] for name in ROW) for row in rows)
    for row in rows:
        place = tuple(row[name] for name in ROW)
        if place not in expected or expected[place][0] != row["controller"]:
            raise UsageError(f"{str(path)!r}: row {name_row(row)} is of no entry of the file's plan")
        if counts[place] > 1:
            raise UsageError(f"{str(path)!r}: row {name_row(row)} stands there {counts[place]} times")
    missing = [place for place in expected if place not in counts]
    if missing:
        row = name_row(dict(zip(ROW, missing[0], strict=True)))
        raise UsageError(f"{str(path)!r} lacks {len(missing)} of the rows of its plan; the first is {row}")
    form = trial_of_plan(plan).record.form()
    for row in rows:
        _, count = expected[tuple(row[name] for name in ROW)]
        try:
            form.model_validate(row["columns"], context={"count": count})
        except ValidationError as error:
            raise UsageError(*list_problems(f"{str(path)!r}: row {name_row(row)}", error, form)) from None


def _rows(plan: Plan) -> dict[tuple[Any, ...], tuple[str, int]]:
    """Controller and number of held-out units of every row that a plan asks for, by what names the row."""
    trial = trial_of_plan(plan)
    rows: dict[tuple[Any, ...], tuple[str, int]] = {}
    for entry, _ in entries_by_level(plan):
        levels, train_level = entry.levels or plan.levels, entry.train_level or plan.train_level
        names = zip(entries.labels(entry), (entry.controller, *entry.also), strict=True)
        for (label, name), throws, seed, level in product(names, entry.throws, seeds_of(plan, entry), levels):
            rows[label, throws, seed, level, train_level] = name, plan.count(trial, level, entry)
    return rows


def _figures(path: Path, plan: Plan, rows: list[Any]) -> dict[str, Any]:
    """Everything that a file shows, computed from its rows.

    Raises:
        UsageError: the rows give no figures.
    """
    with check_form(path):
        try:
            return json.loads(json_text(assemble(plan, rows)))
        except PntGymError as error:
            raise UsageError(f"{str(path)!r}: {error}") from None


def _contradiction(shown: Any, computed: Any, place: str) -> str | None:
    """The first difference of what a file shows and what its rows give, in words; None if there is none."""
    if isinstance(shown, dict) and isinstance(computed, dict):
        former = {name for name in shown.keys() - computed.keys() if FORMER.fullmatch(f"{place}.{name}")}
        if shown.keys() - former != computed.keys():
            name = min((shown.keys() - former) ^ computed.keys())
            return f"{place}.{one_sentence(name, 60)} is {'missing' if name in computed else 'no figure of theirs'}"
        parts = [(name, shown[name], computed[name]) for name in computed]
    elif isinstance(shown, list) and isinstance(computed, list):
        if len(shown) != len(computed):
            return f"{place} has {len(shown)} entries, and not {len(computed)}"
        parts = [(str(number), *pair) for number, pair in enumerate(zip(shown, computed, strict=True))]
    else:
        said, given = (one_sentence(repr(value), 40) for value in (shown, computed))
        return None if _is_same(shown, computed) else f"{place} is {said}, and not {given}"
    differences = (_contradiction(said, given, f"{place}.{name}") for name, said, given in parts)
    return next((words for words in differences if words is not None), None)


def _is_same(shown: Any, computed: Any) -> bool:
    """Whether two values are equal; numbers may differ by rounding."""
    if isinstance(shown, bool) or isinstance(computed, bool) or not isinstance(shown, int | float):
        return type(shown) is type(computed) and shown == computed
    return isinstance(computed, int | float) and math.isclose(shown, computed, rel_tol=NEARLY, abs_tol=1e-12)


def read(path: Path) -> Content:
    """Content of a submission's file.

    Raises:
        UsageError: the file is damaged, says other than its rows, or is no submission.
    """
    content = read_form(path)
    check_submission(content)
    return check(content)


def check_submission(content: Content) -> None:
    """Check what the content of a submission's file has beside that of a benchmark's file.

    Raises:
        UsageError: the file says too little of itself, or its throws are not the benchmark's.
    """
    plan, data, path = content
    missing = [name for name in ABOUT if name not in data]
    if missing:
        raise UsageError(f"submission {str(path)!r} has no {missing[0]!r}")
    if {row["label"] for row in data["results"]} != {path.stem}:
        raise UsageError(f"submission {str(path)!r}: its rows must have the label {path.stem!r}")
    if plan.env not in BENCHMARKS:
        raise UsageError(f"submission {str(path)!r}: {unknown_name('environment', plan.env, BENCHMARKS)}")
    frame = read_plan(BENCHMARKS[plan.env])
    for key in FRAME:
        if getattr(plan, key) != getattr(frame, key):
            raise UsageError(
                f"submission {str(path)!r} has {key} {getattr(plan, key)!r}; the benchmark has {getattr(frame, key)!r}"
            )
