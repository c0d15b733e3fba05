"""The tables of a study, as its plan declares them, from the rows that were measured."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ..ground.cli import UsageError
from ..ground.tables import Grid
from ..results.study import StudyPlan, Table, pooled, shipped_study
from .templates import NONE, filled, shown

Data = Mapping[str, Any]


def study_grids(data: Data) -> list[Grid]:
    """Every table of a study."""
    plan = shipped_study(data["study"])
    return [study_grid(plan, table, data) for table in plan.tables]


def study_grid(plan: StudyPlan, table: Table, data: Data) -> Grid:
    """A table of a study: a line for each row, or for those that agree in the index."""
    part = plan.parts[table.parts[0] if table.parts else next(iter(plan.parts))]
    note = filled(table.note, {**data, "throws": part.count(data["throws"]), "settings": part.settings})
    rows = [row for row in data["rows"] if _is_shown(row, table)]
    if not table.columns:
        texts = [*table.index.values(), *table.figures.values()]
        lines = [[_text(plan, text, row) for text in texts] for row in rows]
        return Grid(table.title, [*table.index, *table.figures], lines, note)
    header = dict.fromkeys(_heading(plan, table.columns, row) for row in _in_order(rows, table.columns))
    meeting: dict[tuple[str, ...], dict[str, list[Data]]] = {}
    for row in rows:
        line = meeting.setdefault(tuple(_text(plan, text, row) for text in table.index.values()), {})
        line.setdefault(_heading(plan, table.columns, row), []).append(row)
    lines = [
        [*index, *(_text(plan, table.figure, _pooled(line[name], table)) if name in line else NONE for name in header)]
        for index, line in meeting.items()
    ]
    return Grid(table.title, [*table.index, *header], lines, note)


def _text(plan: StudyPlan, expression: str, row: Data) -> str:
    """A cell: what an expression makes of a row, whose values the plan may call by other names."""
    names = {axis: known[row[axis]] for axis, known in plan.names.items() if axis in row and row[axis] in known}
    return shown(expression, {**row, **names, "row": row})


def _heading(plan: StudyPlan, axis: str, row: Data) -> str:
    """What a column of an axis is called: a name of the plan's, or the value, whole numbers without a point."""
    value = row[axis]
    return plan.names.get(axis, {}).get(value) or (f"{value:g}" if isinstance(value, float) else str(value))


def _in_order(rows: Sequence[Data], axis: str) -> Sequence[Data]:
    """Rows by their value of an axis if all values are numbers, or as they are."""
    return rows if any(isinstance(row[axis], str) for row in rows) else sorted(rows, key=lambda row: row[axis])


def _pooled(rows: Sequence[Data], table: Table) -> Data:
    """The rows that meet in a cell, as one.

    Raises:
        UsageError: the rows have different values of the axis, which the plan calls by the same name.
    """
    values = {row[table.columns] for row in rows}
    if len(values) > 1:
        met = ", ".join(map(str, sorted(values)))
        raise UsageError(f"table {table.title!r}: {table.columns} {met} meet in a cell; they need different names")
    return pooled(rows)


def _is_shown(row: Data, table: Table) -> bool:
    of_part = not table.parts or row["part"] in table.parts
    return of_part and all(row.get(axis) in values for axis, values in table.where.items())
