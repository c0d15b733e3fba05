"""Rows of another processor: what counts as the same, and what the command says of them."""

import copy
from typing import Any

import pytest

from agents.benchmark.verify import is_near

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
