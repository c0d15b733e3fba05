"""The table of what is the best possible: the best of each kind, and what is left to the ceiling."""

import json
from pathlib import Path
from typing import Any

from agents.report import room


def study(folder: Path, controllers: dict[str, list[float]], expected: float) -> None:
    """A file of ceilings with two shifts of a minute on one level, and the bound of both."""
    rows: list[dict[str, Any]] = [
        {
            "part": "orders",
            "level": "single",
            "controller": name,
            "shifts": [[value, 60.0] for value in shifts],
            "first": [[10.0, 60.0]] * 2,
            "drawn": [[expected + 1.0, 60.0]] * 2,
            "expected": [[expected, 60.0]] * 2,
        }
        for name, shifts in controllers.items()
    ]
    data = {"study": "ceilings", "version": "0", "world": 2, "seed": 0, "throws": 2, "rows": rows}
    (folder / "ceilings.json").write_text(json.dumps(data))


def test_a_line_names_the_best_of_each_kind_and_what_is_left(tmp_path: Path, monkeypatch: Any) -> None:
    own = room.ROOMS["PnTLine-v0"].model_copy(update={"levels": ["single"]})
    monkeypatch.setattr(room, "ROOMS", {"PnTLine-v0": own})
    study(tmp_path, {"fifo": [10.0, 10.0], "atc": [14.0, 10.0], "price": [11.0, 11.0], "index": [15.0, 15.0]}, 20.0)
    (row,) = room.grid(tmp_path).rows
    assert row[:2] == ["`PnTLine-v0`", "`single`"]
    assert row[2:] == ["10.0 `fifo`", "-", "12.0 `atc`", "15.0 `index`", "20.0", "5.0 (50 %)", "proved", "2"]


def test_a_folder_without_results_has_no_such_table(tmp_path: Path) -> None:
    assert room.grid(tmp_path).rows == []
