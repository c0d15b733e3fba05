"""Submissions beside the benchmark's own controllers, compared throw by throw with the analytic planner."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from ..ground import metrics
from ..ground.cli import UsageError
from ..ground.files import check_form
from ..ground.tables import Grid, millimetres, percent
from ..ground.versions import world_of
from ..judging.throw_record import ThrowRecord
from ..results import compare
from . import contents

Data = Mapping[str, Any]
BLOCK: Final = "submissions"
"""Name of the table in documents, and of its chapter."""
FOLDER: Final = "submissions"
"""Folder of the submissions below that of the results."""
OURS: Final = ("analytic", "virtual_goal", "ridge", "mlp", "sac", "oracle")
"""Controllers of the benchmark beside which submissions stand, each after the most throws that it learned from."""
REFERENCE: Final = "analytic"
"""The controller with which all others are compared, throw by throw."""
TITLE: Final = "What others have handed in"
PROJECT: Final = "the project"
HEADER: Final = (
    "level",
    "controller",
    "by",
    "throws to learn",
    "landing error",
    "success",
    "sorted/min",
    "landing, less the planner's",
    "sorted/min, less the planner's",
)


def grid(results: Path) -> Grid:
    """The table of all submissions in a folder of results; without rows where there are none.

    Raises:
        UsageError: a submission is damaged, or of another world than the benchmark.
    """
    files = sorted((results / FOLDER).glob("*.json"))
    if not files or not (results / "benchmark.json").is_file():
        return Grid(TITLE, HEADER, [])
    benchmark = contents.read(results / "benchmark.json")
    lines: list[list[str]] = []
    with check_form(results / "benchmark.json"):
        shown = list(_rows(benchmark, OURS))
        references = {level: _results(benchmark, row) for level, row in shown if row["label"] == REFERENCE}
        ours = [[level, *_line(row, PROJECT, benchmark, references[level])] for level, row in shown]
    for file in files:
        submission = compare.read(file).data
        if submission["plan"]["env"] != benchmark["plan"]["env"]:
            continue
        world, known = world_of(submission), world_of(benchmark)
        if world != known:
            raise UsageError(
                f"submission {str(file)!r} was measured in world {world}, and the benchmark in world {known}; results "
                "of different worlds are not compared"
            )
        with check_form(file):
            for level, row in _rows(submission, [file.stem]):
                lines.append([level, *_line(row, submission["by"], submission, references[level])])
    levels = benchmark["plan"]["levels"]
    rows = sorted([*ours, *lines], key=lambda line: levels.index(line[0]))
    note = (
        f"{benchmark['plan']['picks']} held-out throws per seed on `{benchmark['plan']['env']}`, the same objects for "
        "all. Differences to the analytic planner have 95 % intervals, paired throw by throw; rows whose objects are "
        "others are not compared."
    )
    return Grid(TITLE, HEADER, rows, note)


def _rows(data: Data, labels: Sequence[str]) -> Iterator[tuple[str, Data]]:
    """Level and row of each label, after the most throws that it learned from."""
    for level in data["plan"]["levels"]:
        ordered = sorted(data["table"], key=lambda row: row["throws"])
        last = {row["label"]: row for row in ordered if row["level"] == level}
        yield from ((level, last[label]) for label in labels if label in last)


def _results(data: Data, row: Data) -> list[Data]:
    """Results of a row of the table, one for each seed."""
    keys = ("label", "throws", "level", "train_level")
    return [result for result in data["results"] if all(result[key] == row[key] for key in keys)]


def _line(row: Data, by: str, data: Data, reference: Sequence[Data]) -> list[str]:
    results = _results(data, row)
    throws = row["throws"] or data.get("learned_from", 0)
    success = metrics.Interval(row["success_rate"], row["success_low"], row["success_high"])
    return [
        row["label"],
        by,
        f"{throws:,}" if throws else "-",
        millimetres(row["landing_error_mean_m"]),
        f"{percent(success.value)} ({100 * success.low:.1f}..{100 * success.high:.1f})",
        f"{row['sorted_per_min']:.1f}",
        *_differences(results, reference, data["plan"]["num_envs"]),
    ]


def _differences(results: Sequence[Data], reference: Sequence[Data], num_envs: int) -> list[str]:
    """Paired differences with intervals; a dash for the reference, and where the objects are not the same."""
    objects = [ThrowRecord.objects(side[0]["columns"]) for side in (results, reference)]
    if results[0]["label"] == REFERENCE or objects[0] != objects[1]:
        return ["-", "-"]
    sides = (results, reference)
    mine, theirs = (ThrowRecord.paired_columns(side, sides, num_envs) for side in sides)
    texts: list[str] = []
    for name, figure in ThrowRecord.figures.items():
        left, right = ([np.mean(column, axis=0) for column in side[name]] for side in (mine, theirs))
        difference = metrics.difference if len(left) == 1 else metrics.rate_difference
        texts.append(figure.interval(difference(*left, *right)))
    return texts
