"""What a benchmark of grasps says of each kind: held, lost on the way, and sorted; and where objects land."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ..ground.environments import config_of
from ..ground.tables import Grid
from ..judging.throws import OUTCOMES

Data = Mapping[str, Any]
Cell = Callable[[Sequence[Data], int], str]
"""Text for a kind's objects in the results of one controller."""


def kind_table(data: Data, level: str) -> Grid:
    """Shares by kind of what each controller held, lost on the way and sorted; no rows where nothing is grasped."""
    note = (
        "Three shares of the kind's objects in each cell, in percent: held by the cup / lost on the way / sorted. The "
        "last share is the recovery of the kind."
    )
    return _table(f"Held, lost and sorted by kind, level {level}", data, level, _shares, note)


def landing_table(data: Data, level: str) -> Grid:
    """Landing errors by kind; no rows where nothing is grasped."""
    note = (
        "Three figures of the kind's thrown objects in each cell, in mm: mean landing error / median landing error / "
        "mean landing along the throw, which is negative for objects that land short."
    )
    return _table(f"Landing error by kind, level {level}", data, level, _landings, note)


def _table(title: str, data: Data, level: str, cell: Cell, note: str) -> Grid:
    """A row for each controller, of which there are many, and a column for each kind; no rows without a grasp."""
    results = [r for r in data["results"] if r["level"] == level and "tries" in r["columns"]]
    plan, kinds = data["plan"], list[str]()
    if results:
        kinds += config_of(plan["env"], plan["inline"].get(level, level)).items
    of_label: dict[str, list[Data]] = {}
    for result in results:
        of_label.setdefault(str(result["label"]), []).append(result)
    rows = [[label, *(cell(runs, kind) for kind in range(len(kinds)))] for label, runs in of_label.items()]
    return Grid(title, ["controller", *kinds], rows, note)


def _shares(results: Sequence[Data], kind: int) -> str:
    """Three shares of a kind's objects in the results of one controller, as text."""
    is_kind = np.concatenate([np.array(r["columns"]["item"]) == kind for r in results])
    letters = np.concatenate([list(r["columns"]["outcome"]) for r in results])[is_kind]
    if letters.size == 0:
        return "-"
    shares = (
        (letters != OUTCOMES["unpicked"]).mean(),
        (letters == OUTCOMES["dropped"]).mean(),
        (letters == OUTCOMES["sorted"]).mean(),
    )
    return "/".join(f"{100.0 * share:.0f}" for share in shares)


def _landings(results: Sequence[Data], kind: int) -> str:
    """Mean and median landing error of a kind's objects, and their mean landing along the throw, as text."""
    is_kind = np.concatenate([np.array(r["columns"]["item"]) == kind for r in results])
    along, across = (
        np.concatenate([np.array(r["columns"][name], dtype=np.float64) for r in results])[is_kind]
        for name in ("along_m", "across_m")
    )
    flew = np.isfinite(along)
    if not flew.any():
        return "-"
    error = 1000.0 * np.hypot(along, across)[flew]
    return f"{error.mean():.0f}/{np.median(error):.0f}/{1000.0 * along[flew].mean():+.0f}"
