"""Columns of rows: what counts as the same, also on another processor, and that a file keeps them as they were."""

import copy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agents.benchmark.verify import is_near, judge
from agents.results.columns import with_columns, without_columns

ROW: dict[str, Any] = {
    "item": [0, 1] * 100,
    "along_m": [0.01] * 199 + [None],
    "across_m": [-0.002] * 199 + [None],
    "cycle_s": [0.9] * 200,
    "outcome": "s" * 199 + "p",
    "clipped": 3,
}


def changed(name: str, count: int, value: Any) -> dict[str, Any]:
    row = copy.deepcopy(ROW)
    column = list(row[name])
    column[:count] = [value] * count
    row[name] = "".join(column) if name == "outcome" else column
    return row


@pytest.mark.parametrize(
    ("row", "near"),
    [
        (ROW, True),
        (changed("along_m", 199, 0.0101), True),  # 0.1 mm everywhere
        (changed("along_m", 2, 0.2), True),  # one in a hundred anywhere
        (changed("along_m", 3, 0.2), False),
        (changed("along_m", 3, None), False),
        (changed("cycle_s", 200, 0.901), True),
        (changed("cycle_s", 3, 0.903), False),
        (changed("outcome", 2, "m"), True),
        (changed("outcome", 3, "m"), False),
        (changed("item", 1, 5), False),  # another object is another throw
        ({**ROW, "outcome": "s"}, False),
        ({**ROW, "clipped": 4}, True),
        ({name: column for name, column in ROW.items() if name != "cycle_s"}, False),
        ({**ROW, "dropped": 0}, False),
    ],
)
def test_all_but_few_throws_must_agree_within_the_bounds(row: dict[str, Any], near: bool) -> None:
    assert is_near(ROW, row) is near


def test_few_counts_throws_whatever_column_differs() -> None:
    row = changed("along_m", 2, 0.2)
    row["outcome"] = "s" * 190 + "mm" + "s" * 7 + "p"
    assert not is_near(ROW, row)


def test_totals_of_work_shifts_must_be_equal() -> None:
    assert not is_near({"value_per_min": [1.0], "success": 990}, {"value_per_min": [1.0], "success": 991})


@pytest.mark.parametrize(
    ("old", "new", "found"),
    [
        ({"a": 1, "b": [1, 2]}, {"a": 1, "b": [1, 2]}, None),
        ({"b": [1, 2]}, {"b": [1]}, {"column": "b", "at": None, "file": [1, 2], "here": [1], "count": 1}),
        ({}, {"b": 1}, {"column": "b", "at": None, "file": None, "here": 1, "count": 1}),
        ({"b": [1, 2, 3]}, {"b": [1, 5, 4]}, {"column": "b", "at": 1, "file": 2, "here": 5, "count": 2}),
    ],
)
def test_differences_in_form_are_differences(old: Any, new: Any, found: Any) -> None:
    assert judge(old, new) == {"verdict": "different" if found else "equal", "difference": found}


ODD: list[dict[str, Any]] = [
    {"error_m": [0.01, None, -3.2], "letters": "sap", "count": [1, 2, 300], "hit": [True, False, True]},
    {"error_m": [0.12345, 1e8, None], "by_robot": [[0.5, None], [1.0, 2.0], [3.0, 4.5]], "total": 4, "names": ["a"]},
    {"error_m": [1.0, 2.0, 3.0], "large": [1e300, None, 0.1], "fine": [1e-9, 0.5, None], "torn": [[1], [1, 2], []]},
    {"large": [1, 2, 3], "count": [0.5, None, 1.0], "words": ["1", None, "x"], "accent": "é", "none": [None] * 3},
]


def test_columns_of_any_kind_are_as_they_were() -> None:
    rows = [{"label": str(number), "columns": columns} for number, columns in enumerate(ODD)]
    heads, decimals, tables = without_columns(rows)
    assert with_columns(Path("file.json"), heads, tables, decimals) == rows
    assert decimals == {"error_m": 5, "by_robot": 1, "count": 1, "none": 0}
    assert {name: head for name, head in heads[1]["columns"].items()} == {"total": 4, "names": ["a"]}
    assert tables["0 error_m"].dtype == np.int32 and tables["groups"].tolist() == [0, 1, 2, 3]
