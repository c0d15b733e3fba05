"""The leaderboard: what was handed in beside the project's own controllers, a board for each kind of task.

A board is sorted by the figure that its task is judged by, on its first level. The best of each column is bold, of
those who know what any controller can know; who knows more is marked, and only shows how much there is.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final, NamedTuple

from pnt_gym.constants import WORLD

from ..controllers.named import CHEATS
from ..ground.files import check_form
from ..ground.looks import reader_name
from ..ground.tables import NONE, Grid
from ..ground.versions import world_of
from ..results import compare
from . import contents, room
from .submissions import FOLDER

Data = Mapping[str, Any]
US: Final = "us"
"""Who made the controllers of the project."""
PREFIX: Final = "leaderboard-"
"""Beginning of the names of the boards' tables in documents."""


class Column(NamedTuple):
    """A figure of a board.

    Attributes:
        name: what it is called.
        key: of a row.
        factor: on the value.
        unit: behind the number.
        sign: -1 where less is better.
    """

    name: str
    key: str
    factor: float = 1.0
    unit: str = ""
    sign: int = 1


PACE: Final = Column("sorted/min", "sorted_per_min")
ERROR: Final = Column("landing error", "landing_error_mean_m", 1000.0, " mm", -1)
SUCCESS: Final = Column("success", "success_rate", 100.0, " %")
VALUE: Final = Column("value/min", "value_per_min")


class Board(NamedTuple):
    """A board.

    Attributes:
        title: of the table.
        env: environment of the throws.
        file: results of the project's controllers, without ".json".
        levels: those that count; the first one sorts.
        columns: figures on each level; the first one sorts.
        labels: of the project's controllers; empty for all.
        held_out: what everyone has thrown.
    """

    title: str
    env: str
    file: str
    levels: Sequence[str]
    columns: Sequence[Column]
    labels: Sequence[str]
    held_out: str


BOARDS: Final = {
    "conveyor": Board(
        "Throws at the conveyor",
        "PnTRelease-v0",
        "benchmark",
        ("waste", "unseen"),
        (PACE, ERROR),
        ("analytic", "fitted_planner", "virtual_goal", "ridge", "mlp", "sac", "oracle"),
        "1,000 held-out throws on each level; who learns does so on `waste`, in five seeds",
    ),
    "cells": Board(
        "Cells that nobody measured",
        "PnTAdapt-v0",
        "cells",
        ("cells", "cells_far"),
        (PACE,),
        (),
        "shifts of 50 picks, each in another cell, by flights; `cells_far` lies outside of the ranges",
    ),
    "line": Board(
        "Who takes what along a line",
        "PnTLine-v0",
        "benchmark_line",
        ("skills3_burst", "skills3", "line3", "value", "single", "speed"),
        (VALUE,),
        (),
        "100 held-out shifts of 120 s on each level; who learns does so on the level itself",
    ),
    "grasp": Board(
        "See, grasp, throw",
        "PnTGrasp-v0",
        "benchmark_grasp",
        ("grasp", "grasp_unseen"),
        (PACE, SUCCESS),
        (
            "centre",
            "centroid",
            "flattest",
            "flattest_colour",
            "local_mlp",
            "local_mlp_depth",
            "fitted_q",
            "oracle_grasp",
        ),
        "2,000 held-out objects on each level; the kinds of `grasp_unseen` are in nobody's training",
    ),
}


class Entry(NamedTuple):
    """A row of a board: controller, who made it, throws to learn from, whether it cheats, and its rows by level."""

    label: str
    by: str
    throws: int
    is_cheat: bool
    rows: Mapping[str, Data]


def grid(results: Path, name: str) -> Grid:
    """A board by its name, from a folder of results; without rows where the project's own results are missing."""
    board = BOARDS[name]
    file = results / f"{board.file}.json"
    columns = [(level, column) for level in board.levels for column in board.columns]
    header = ["controller", "by", "learned from", *(f"{level}: {column.name}" for level, column in columns)]
    if not file.is_file():
        return Grid(board.title, header, [])
    data = contents.read(file)
    with check_form(file):
        entries = [*_own(board, data), *_handed_in(board, results, world_of(data))]
    entries.sort(key=lambda entry: [-column.sign * _value(entry, level, column) for level, column in columns])
    best = [_best(entries, level, column) for level, column in columns]
    lines = [
        [
            _name(entry),
            entry.by,
            f"{entry.throws:,}" if entry.throws else NONE[0],
            *(_cell(entry, level, column, top) for (level, column), top in zip(columns, best, strict=True)),
        ]
        for entry in entries
    ]
    older = f" {contents.older(world_of(data))}" if world_of(data) < WORLD else ""
    return Grid(board.title, header, lines, f"`{board.env}`: {board.held_out}.{older}")


def _name(entry: Entry) -> str:
    """The identifier, the name that a reader knows, and a mark on who knows more than a controller can know."""
    words = [reader_name(entry.label), "*knows what is hidden*" * entry.is_cheat]
    return f"`{entry.label}` {', '.join(word for word in words if word)}".strip()


def _own(board: Board, data: Data) -> Iterator[Entry]:
    """The project's controllers that have a row on every level, each after the most throws that it learned from."""
    if "table" in data:
        rows = [row for row in sorted(data["table"], key=lambda row: row["throws"]) if row["level"] in board.levels]
        found: dict[str, dict[str, Data]] = {}
        for row in rows:
            found.setdefault(row["label"], {})[row["level"]] = row
    else:
        values = {level: room.values(data, level) for level in board.levels}
        found = {
            label: {level: {PACE.key: of[label]} for level, of in values.items() if label in of}
            for label in values[board.levels[0]]
        }
    for label, of_levels in found.items():
        if set(of_levels) == set(board.levels) and label in (board.labels or found):
            throws = max(row.get("throws", 0) for row in of_levels.values())
            yield Entry(label, US, throws, label in CHEATS, of_levels)


def _handed_in(board: Board, results: Path, world: int) -> Iterator[Entry]:
    """What was handed in for the environment of a board, of the world of its other rows."""
    for file in sorted((results / FOLDER).glob("*.json")):
        data = compare.read(file).data
        rows = {row["level"]: row for row in sorted(data["table"], key=lambda row: row["throws"])}
        if data["plan"]["env"] == board.env and world_of(data) == world and set(board.levels) <= set(rows):
            throws = max(row["throws"] for row in rows.values()) or data.get("learned_from", 0)
            yield Entry(file.stem, data["by"], throws, False, rows)


def _value(entry: Entry, level: str, column: Column) -> float:
    return column.factor * float(entry.rows[level][column.key])


def _best(entries: Sequence[Entry], level: str, column: Column) -> str:
    """The best figure of a column as text, without those that cheat."""
    values = [_value(entry, level, column) for entry in entries if not entry.is_cheat]
    return f"{(max if column.sign > 0 else min)(values):.1f}" if values else ""


def _cell(entry: Entry, level: str, column: Column, best: str) -> str:
    """A figure, bold where no other one of the column is better."""
    text = f"{_value(entry, level, column):.1f}"
    shown = f"{text}{column.unit}"
    return f"**{shown}**" if text == best and not entry.is_cheat else shown
