"""Room between beginning and ceiling: what is the best possible in each environment, and how much of it is taken."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from pnt_gym.cells.base.config import Section
from pnt_gym.constants import WORLD

from ..ground import metrics
from ..ground.files import read_yaml
from ..ground.tables import NONE, Grid
from ..ground.versions import world_of
from . import contents

Data = Mapping[str, Any]


class Room(Section):
    """Rows of a file of results by the part that they play, by their labels."""

    file: str
    levels: list[str]
    floor: list[str]
    planner: Sequence[str] = ()
    rule: Sequence[str] = ()
    learner: list[str]
    ceiling: str
    is_proved: bool = False


ROOMS: Final = {
    name: Room.model_validate(entry)
    for name, entry in read_yaml(Path(__file__).with_name("room.yaml"), "rooms").items()
}
ROLES: Final = ("floor", "planner", "rule", "learner")
HEADER: Final = (
    "environment",
    "level",
    "begins at",
    "best planner",
    "best rule",
    "best learner",
    "ceiling",
    "left",
    "the ceiling is",
    "world",
)


def grid(results: Path) -> Grid:
    """The table, from a folder of results; without rows of files that the folder lacks."""
    rows: list[list[str]] = []
    for name, room in ROOMS.items():
        file = results / f"{room.file}.json"
        if not file.is_file():
            continue
        data = contents.read(file)
        for level in room.levels:
            cells = _line(room, values(data, level))
            rows.append([f"`{name.partition(',')[0]}`", f"`{level}`", *cells, str(world_of(data))])
    note = (
        "Sorted objects a minute; value a minute on `PnTLine-v0`, where the ceiling is the bound of expected values, "
        "which no order passes on average. All other ceilings are *reached* by a controller that knows what no other "
        "one can know. The best of each kind is chosen by these throws. *Left*: from the best of all to the ceiling, "
        "and its share of the way from the beginning, which the simplest controller brings, to the ceiling. *World*: "
        f"in which the throws were simulated; it is {WORLD} now."
    )
    return Grid("Beginnings, ceilings, and what is left between them", HEADER, rows, note)


def _line(room: Room, found: Mapping[str, float]) -> list[str]:
    """Cells of a level, by what each row brings."""
    best = {role: _best(getattr(room, role), found) for role in ROLES}
    most = max(found[label] for label in best.values() if label)
    floor, ceiling = found[room.floor[0]], found[room.ceiling]
    left, share = round(ceiling - most, 1) + 0.0, round(100.0 * (ceiling - most) / (ceiling - floor)) + 0.0  # no -0
    shown = [f"{found[label]:.1f} `{label}`" if label else NONE[0] for label in best.values()]
    return [*shown, f"{ceiling:.1f}", f"{left:.1f} ({share:.0f} %)", "proved" if room.is_proved else "reached"]


def _best(labels: Sequence[str], found: Mapping[str, float]) -> str | None:
    """The label of the row that brings most; None without any."""
    return max((label for label in labels if label in found), key=found.__getitem__, default=None)


def values(data: Data, level: str) -> dict[str, float]:
    """What rows of a level bring a minute, by label; of rows after several numbers of throws the best."""
    found: dict[str, float] = {}
    for row in data.get("table", ()):
        if row["level"] == level:
            found[row["label"]] = max(found.get(row["label"], 0.0), row["sorted_per_min"])
    parts: dict[str, list[list[float]]] = {}
    for row in data.get("rows", ()):
        # Rows of a study have what is counted and the seconds of each shift, and a part in place of a level.
        counted = row.get("shifts", row.get("cells"))
        if counted and row.get("level", row["part"]) == level and row.get("window", 0) == 0:
            parts.setdefault(row["controller"], []).extend(counted)
            if "expected" in row:
                parts["expected"] = row["expected"]
    return found | {label: metrics.rate(*np.array(shifts)[:, :2].T).value for label, shifts in parts.items()}
