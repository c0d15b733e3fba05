"""Texts and tables from templates and expressions of Jinja; filters write figures with their units and intervals."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cache
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from ..ground import metrics
from ..ground.cli import UsageError
from ..ground.tables import Grid
from ..results.study import StudyPlan, Table, pool, shipped_study

NONE: Final = "-"
"""Text of a figure that is missing."""


class NoFigure(LookupError):
    """The results lack a controller, a level, a case or a figure that a text needs: they are of another plan."""


@cache
def environment() -> Any:
    """Jinja's environment of the report; a name that nobody has given is an error."""
    from jinja2 import Environment, StrictUndefined  # noqa: PLC0415 - needed for reports only

    made = Environment(autoescape=False, trim_blocks=True, lstrip_blocks=True, undefined=StrictUndefined)
    made.filters |= {
        write.__name__: write for write in (number, mm, percent, deg, count, code, pace, landing, share_of, won)
    }
    return made


def fill(template: str, values: Mapping[str, Any]) -> str:
    """A template with values in it.

    Raises:
        NoFigure: the template names something that is not among the values.
    """
    from jinja2 import UndefinedError  # noqa: PLC0415 - needed for reports only

    try:
        return environment().from_string(template).render(values)
    except UndefinedError as error:
        raise NoFigure(str(error)) from None


def text(expression: str, values: Mapping[str, Any]) -> str:
    """What an expression comes to, as text; a dash where a figure is missing."""
    from jinja2 import UndefinedError  # noqa: PLC0415 - needed for reports only

    try:
        value = _compiled(expression)(values)
        return NONE if value is None else str(value)
    except (UndefinedError, TypeError):
        return NONE


@cache
def _compiled(expression: str) -> Any:
    return environment().compile_expression(expression, undefined_to_none=False)


def number(value: Any, digits: int = 1, *, sign: bool = False, unit: str = "", factor: float = 1.0) -> str:
    """A number with digits after its point, its sign, its unit, and the ends of its interval in brackets."""
    ends = [value[end] for end in ("value", "low", "high")] if isinstance(value, Mapping) else [value]
    middle, *interval = (format(factor * end, f"{'+' if sign else ''}.{digits}f") for end in ends)
    return f"{middle}{unit}" + (f" ({'..'.join(interval)})" if interval else "")


def mm(value: Any, digits: int = 1, *, sign: bool = False) -> str:
    """A length [m] in millimetres."""
    return number(value, digits, sign=sign, unit=" mm", factor=1000.0)


def percent(value: Any, digits: int = 1, *, sign: bool = False) -> str:
    """A share in percent."""
    return number(value, digits, sign=sign, unit=" %", factor=100.0)


def deg(value: Any, digits: int = 1) -> str:
    """An angle [rad] in degrees."""
    return number(value, digits, unit=" deg", factor=180.0 / math.pi)


def count(value: Any) -> str:
    """A whole number, with commas between its thousands."""
    return f"{value:,.0f}"


def pace(parts: Any, least: Any = None) -> Mapping[str, float]:
    """Sorted picks per minute of parts, each objects sorted and seconds first; or their gain over those of `least`."""
    sorted_, seconds = np.array(parts)[:, :2].T
    found = (
        metrics.rate(sorted_, seconds)
        if least is None
        else metrics.rate_difference(sorted_, seconds, *np.array(least).T)
    )
    return vars(found)


def code(value: Any) -> str:
    """A name as code."""
    return f"`{value}`"


def landing(parts: Any) -> Mapping[str, float]:
    """Mean landing error [m] of parts, each with the sum of errors and the number of landings behind two others."""
    errors, landings = np.array(parts)[:, 2:].T
    return vars(metrics.rate(errors, landings, 1.0))


def share_of(parts: Any, whole: Any) -> Mapping[str, float]:
    """Share of what others bring in the same parts that parts as of `pace` bring."""
    return vars(metrics.rate(np.array(parts)[:, 0], np.array(whole)[:, 0], 1.0))


def won(parts: Any, least: Any, most: Any) -> Mapping[str, float]:
    """Share of what the `most` controller wins over the `least` one that parts as of `pace` win."""
    return vars(metrics.share_won(np.array(parts)[:, :2], least, most))


Data = Mapping[str, Any]
Names = Mapping[str, Mapping[Any, str]]


def grids(data: Data) -> list[Grid]:
    """Every table of a study."""
    plan = shipped_study(data["study"])
    return [grid(plan, table, data) for table in plan.tables]


def grid(plan: StudyPlan, table: Table, data: Data) -> Grid:
    """A table of a study; its note tells of its first part."""
    part = plan.parts[table.parts[0] if table.parts else next(iter(plan.parts))]
    values = {**data, "throws": part.count(data["throws"]), "settings": part.settings}
    of_parts = [row for row in data["rows"] if not table.parts or row["part"] in table.parts]
    rows = [row for row in of_parts if all(row.get(axis) in values for axis, values in table.where.items())]
    return make_grid(table, rows, values, plan.names)


def make_grid(table: Table, rows: Sequence[Data], values: Data, names: Names = MappingProxyType({})) -> Grid:
    """A table as it is declared: a line for each row, or for those that agree in the index.

    Args:
        table: the declaration.
        rows: figures by name.
        values: what the note tells.
        names: what cells and columns call values, by axis.
    """
    note = fill(table.note, values)
    if not table.columns:
        texts = [*table.index.values(), *table.figures.values()]
        lines = [[_text(text, row, names) for text in texts] for row in rows]
        return Grid(table.title, [*table.index, *table.figures], lines, note)
    # Rows by their value of an axis if all values are numbers, or as they are.
    has_words = any(isinstance(row[table.columns], str) for row in rows)
    ordered = rows if has_words else sorted(rows, key=lambda row: row[table.columns])
    header = dict.fromkeys(_name(table.columns, row, names) for row in ordered)
    meeting: dict[tuple[str, ...], dict[str, list[Data]]] = {}
    for row in rows:
        line = meeting.setdefault(tuple(_text(text, row, names) for text in table.index.values()), {})
        line.setdefault(_name(table.columns, row, names), []).append(row)
    lines = [
        [*index, *(_text(table.figure, _row(line[name], table), names) if name in line else NONE for name in header)]
        for index, line in meeting.items()
    ]
    return Grid(table.title, [*table.index, *header], lines, note)


def _text(expression: str, row: Data, names: Names) -> str:
    """A cell: what an expression makes of a row, whose values may have other names."""
    named = {axis: known[row[axis]] for axis, known in names.items() if axis in row and row[axis] in known}
    return text(expression, {**row, **named, "row": row})


def _name(axis: str, row: Data, names: Names) -> str:
    """What a column of an axis is called: a name, or the value, whole numbers without a point."""
    value = row[axis]
    return names.get(axis, {}).get(value) or (f"{value:g}" if isinstance(value, float) else str(value))


def _row(rows: Sequence[Data], table: Table) -> Data:
    """The rows that meet in a cell, as one.

    Raises:
        UsageError: the rows have different values of the axis, which the plan calls by the same name.
    """
    values = {row[table.columns] for row in rows}
    if len(values) > 1:
        met = ", ".join(map(str, sorted(values)))
        raise UsageError(f"table {table.title!r}: {table.columns} {met} meet in a cell; they need different names")
    return pool(rows)
