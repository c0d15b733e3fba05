"""Tables of a benchmark of lines, whose controllers have worked the same shifts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..tables import Grid, percent
from .tables import OF_LINE, comparison_table, conditions, other_levels, rows_of, side_by_side, who

Data = Mapping[str, Any]
COLUMNS = ("value/min", "recovery")
"""Of the tables of all levels side by side."""


def line_grids(data: Data) -> list[Grid]:
    """Every table of a benchmark of lines."""
    grids = [worked_table(data), side_by_side("Further levels", data, other_levels(data), COLUMNS)]
    for level in data["plan"]["levels"]:
        grids += [comparison_table(data, level), judged_table(data, level), items_table(data, level)]
    return [grid for grid in grids if grid.rows]


def worked_table(data: Data) -> Grid:
    """Every controller on the levels of the plan, side by side."""
    said = "value a minute with its 95 % interval over shifts; recovery is what was sorted of all that came"
    note = conditions(data, f"Up to {data['plan']['shifts']} held-out shifts", said)
    levels = data["plan"]["levels"]
    return side_by_side("Every controller on the same held-out shifts", data, levels, COLUMNS, note)


def judged_table(data: Data, level: str) -> Grid:
    """What a line is judged by beside its value a minute."""
    rows = [
        [
            *who(row),
            str(row["shifts"]),
            f"{row['sorted_per_min']:.1f}",
            *(percent(row[name]) for name in ("recovery", "value_recovery", "purity", "pick_rate")),
            ", ".join(percent(share) for share in row["utilisation"]),
            f"{row['ms_per_decision']:.2f}",
        ]
        for row in rows_of(data, [level])
    ]
    header = ["sorted/min", "recovery", "recovery of value", "purity", "picks that held", "robots at work"]
    note = "Purity: share of what lies in bins that belongs there. Robots at work, upstream first, are not waiting."
    header = [*OF_LINE, "shifts", *header, "ms/decision"]
    return Grid(f"What a line is judged by, level {level}", header, rows, note)


def items_table(data: Data, level: str) -> Grid:
    """Recovery by item."""
    found = rows_of(data, [level])
    items = found[0]["items"] if found else []
    rows = [[*who(row), *map(percent, row["recovery_by_item"])] for row in found]
    return Grid(f"Recovery by item, level {level}", [*OF_LINE, *items], rows)
