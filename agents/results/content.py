"""Content of a benchmark's file: read in one form, and every shown figure computed from the throws in the file.

A file of results may be a stranger's. The rows must be those that the file's plan asks for, each number in its range;
table and comparisons are computed from the rows anew, and a file that says otherwise is refused.
"""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Annotated, Any, Final, NamedTuple

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from pnt_gym.cells.base.problems import list_problems
from pnt_gym.errors import PntGymError, one_sentence

from ..ground.cli import UsageError
from ..ground.files import check_form, json_text, read_json
from ..ground.shipped import module_of
from ..judging.rows import Amount, Count, check_model
from .compare import assemble
from .entries import labels_of
from .plan import Plan, entries_by_level, seeds_of, trial_of_plan

NEARLY: Final = 1e-9
"""Relative difference of two figures that the order of sums explains."""
ROW: Final = ("label", "throws", "seed", "level", "train_level")
"""What names a row of the results."""
Text = Annotated[str, Field(max_length=2000)]


class ResultRow(BaseModel):
    """One row: a controller after one learning, and its held-out throws or work shifts on one level."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    label: Text
    controller: Text
    throws: Count
    seed: Annotated[int, Field(ge=0)]
    level: Text
    train_level: Text
    learn_seconds: Amount
    digests: dict[str, Text] = {}
    columns: dict[str, Any]


class BenchmarkFile(BaseModel):
    """A file of `pnt-gym benchmark`, or of `pnt-gym submit`, which says more about itself."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    by: Text = ""
    about: Text = ""
    command: Text = ""
    plan: dict[str, Any]
    versions: dict[str, Text]
    seconds: Amount
    trial: Text
    unit: Text
    step: Text
    figures: dict[str, Any]
    table: list[dict[str, Any]]
    comparisons: list[dict[str, Any]]
    policies: dict[str, str] = {}
    results: Annotated[list[ResultRow], Field(min_length=1)]


class Content(NamedTuple):
    """Content of a benchmark's file.

    Attributes:
        plan: the plan.
        data: everything by key, as JSON.
    """

    plan: Plan
    data: dict[str, Any]


def is_benchmark(data: Any) -> bool:
    """Whether data are of a benchmark's file, a damaged one perhaps, and no other file of results."""
    return isinstance(data, dict) and "plan" in data


def read_form(path: Path) -> Content:
    """Content of a benchmark's file of which the form alone is checked; no module is imported.

    Raises:
        UsageError: the file is missing or of another form.
    """
    data = read_json(path)
    if not is_benchmark(data):
        sources = "only files of `pnt-gym benchmark` and `pnt-gym submit` are verified"
        raise UsageError(f"{str(path)!r} has no plan: {sources}")
    return form_of(path, data)


def form_of(path: Path, data: dict[str, Any]) -> Content:
    """Content of a benchmark's file from its data, of which the form alone is checked.

    Raises:
        UsageError: the data are of another form.
    """
    check_model(path, BenchmarkFile, data)
    return Content(plan_of_file(path, data["plan"]), data)


def check_figures(path: Path, content: Content, *, trust: bool = False) -> Content:
    """The same content, if its figures are those of its rows.

    The last digits of its figures stay: rounding differs from machine to machine, and drawings are named by digits.

    Args:
        path: path of the file.
        content: content of the file, of which the form is checked.
        trust: import the module of the environment that the file names.

    Raises:
        UsageError: the file says other than its rows, or names a module.
    """
    plan, data = content
    if module_of(plan.env) is not None and not trust:
        raise untrusted(path, plan.env)
    _check_rows(path, plan, data["results"])
    for key, figure in _figures_of_rows(path, plan, data["results"]).items():
        difference = _difference(data[key], figure, key)
        if difference is not None:
            raise UsageError(f"{str(path)!r} shows what its {data['unit']} do not give: {difference}")
    return content


def plan_of_file(file: Path, plan: Any) -> Plan:
    """The plan that a benchmark's file holds.

    Raises:
        UsageError: the plan contradicts itself.
    """
    try:
        # A file holds every key of its plan; keys of other kinds of trials, at their defaults, must not count as given.
        return Plan.model_validate(Plan.model_validate(plan).model_dump(exclude_defaults=True))
    except ValidationError as error:
        raise UsageError(*list_problems(f"plan in {str(file)!r}", error, Plan)) from None


def untrusted(path: Path, name: str) -> UsageError:
    """Error of a file that names a module, which nobody has said to trust."""
    return UsageError(f"{str(path)!r} names {name!r}: importing the module runs its code; give --trust if it is yours")


def name_row(row: Mapping[str, Any]) -> str:
    """A row in words."""
    return ", ".join(f"{name} {one_sentence(row[name], 60)}" for name in ROW)


def _check_rows(path: Path, plan: Plan, rows: Sequence[Mapping[str, Any]]) -> None:
    """Make sure that rows are those of a plan, each once, and that their columns have the form of its trial.

    Raises:
        UsageError: a row is missing, stands twice, is of no entry, or has other columns.
    """
    expected = _expected_rows(plan)
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


def _expected_rows(plan: Plan) -> dict[tuple[Any, ...], tuple[str, int]]:
    """Controller and number of held-out units of every row that a plan asks for, by what names the row."""
    trial = trial_of_plan(plan)
    rows: dict[tuple[Any, ...], tuple[str, int]] = {}
    for entry, _ in entries_by_level(plan):
        levels, train_level = entry.levels or plan.levels, entry.train_level or plan.train_level
        names = zip(labels_of(entry), (entry.controller, *entry.also), strict=True)
        for (label, name), throws, seed, level in product(names, entry.throws, seeds_of(plan, entry), levels):
            rows[label, throws, seed, level, train_level] = name, plan.count_of(trial, level, entry)
    return rows


def _figures_of_rows(path: Path, plan: Plan, rows: list[Any]) -> dict[str, Any]:
    """Everything that a file shows, computed from its rows.

    Raises:
        UsageError: the rows give no figures.
    """
    with check_form(path):
        try:
            return json.loads(json_text(assemble(plan, rows)))
        except PntGymError as error:
            raise UsageError(f"{str(path)!r}: {error}") from None


def _difference(shown: Any, computed: Any, place: str) -> str | None:
    """The first difference of what a file shows and what its rows give, in words; None if there is none."""
    if isinstance(shown, dict) and isinstance(computed, dict):
        if shown.keys() != computed.keys():
            name = min(shown.keys() ^ computed.keys())
            return f"{place}.{one_sentence(name, 60)} is {'missing' if name in computed else 'no figure of theirs'}"
        parts = [(name, shown[name], computed[name]) for name in computed]
    elif isinstance(shown, list) and isinstance(computed, list):
        if len(shown) != len(computed):
            return f"{place} has {len(shown)} entries, and not {len(computed)}"
        parts = [(str(number), *pair) for number, pair in enumerate(zip(shown, computed, strict=True))]
    else:
        said, given = (one_sentence(repr(value), 40) for value in (shown, computed))
        return None if _is_same(shown, computed) else f"{place} is {said}, and not {given}"
    differences = (_difference(said, given, f"{place}.{name}") for name, said, given in parts)
    return next((words for words in differences if words is not None), None)


def _is_same(shown: Any, computed: Any) -> bool:
    """Whether two values are equal; numbers may differ by rounding."""
    if isinstance(shown, bool) or isinstance(computed, bool) or not isinstance(shown, int | float):
        return type(shown) is type(computed) and shown == computed
    return isinstance(computed, int | float) and math.isclose(shown, computed, rel_tol=NEARLY, abs_tol=1e-12)
