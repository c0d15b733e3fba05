"""What a benchmark of grasps says of each kind: held, lost on the way, and sorted."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..ground.environments import config_of
from ..ground.tables import Grid
from ..judging.throws.columns import OUTCOMES

Data = Mapping[str, Any]


def kind_table(data: Data, level: str) -> Grid:
    """Shares by kind of what each controller held, lost on the way and sorted; no rows where nothing is grasped."""
    results = [r for r in data["results"] if r["level"] == level and "tries" in r["columns"]]
    plan, names = data["plan"], list[str]()
    if results:
        names += config_of(plan["env"], plan["inline"].get(level, level)).items
    labels = list(dict.fromkeys(str(r["label"]) for r in results))
    rows = [
        [name, *(_shares([r for r in results if r["label"] == label], kind) for label in labels)]
        for kind, name in enumerate(names)
    ]
    note = (
        "In each cell: share of the kind's objects that the cup held / share that was lost on the way / share that was "
        "sorted, which is the recovery of the kind."
    )
    return Grid(f"Held, lost and sorted by kind, level {level}", ["kind", *labels], rows, note)


def _shares(results: list[Data], kind: int) -> str:
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
    return " / ".join(f"{100.0 * share:.0f}" for share in shares) + " %"
