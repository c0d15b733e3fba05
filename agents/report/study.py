"""The tables of a study, from its plan and the rows that were measured."""

from __future__ import annotations

import math
import re
import string
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from functools import partial
from typing import Any, Final

from ..ground.cli import UsageError
from ..ground.metrics import wilson
from ..ground.tables import Grid
from ..results.study import StudyPlan, Table, shipped_study

Data = Mapping[str, Any]
UNITS: Final = {"%": 100.0, "mm": 1000.0, "deg": 180.0 / math.pi}
"""Units that a format may end with, and the factor of each on the SI value."""
FORMAT: Final = re.compile(rf"(.*?)({'|'.join(UNITS)})?")
NONE: Final = "-"


def study_grids(data: Data) -> list[Grid]:
    """Every table of a study."""
    plan = shipped_study(data["study"])
    return [study_grid(plan, table, data) for table in plan.tables]


def study_grid(plan: StudyPlan, table: Table, data: Data) -> Grid:
    """A table of a study."""
    shown = [row for row in data["rows"] if _is_shown(row, table)]
    show = partial(cell, names=plan.names)
    rows = {id(row): [show(text, row) for text in table.columns.values()] for row in shown}
    note = text_of(table.note, {**data, **_head(plan, table, data)}, plan.names)
    if not table.across:
        return Grid(table.title, [*table.columns], [rows[id(row)] for row in shown], note)
    headings = {value: show(f"{{{table.across}:g}}", {table.across: value}) for value in _values_across(shown, table)}
    meeting: dict[tuple[str, ...], dict[str, list[Data]]] = {}
    for row in shown:
        meeting.setdefault(tuple(rows[id(row)]), {}).setdefault(headings[row[table.across]], []).append(row)
    header = list(dict.fromkeys(headings.values()))
    lines = [
        [*key, *(show(table.cell, _of_a_cell(of[heading], table)) if heading in of else NONE for heading in header)]
        for key, of in meeting.items()
    ]
    return Grid(table.title, [*table.columns, *header], lines, note)


def _values_across(rows: Sequence[Data], table: Table) -> list[Any]:
    """The values of the axis that has columns: numbers in their order, names in that of the rows."""
    values = list(dict.fromkeys(row[table.across] for row in rows))
    return values if any(isinstance(value, str) for value in values) else sorted(values)


def _of_a_cell(rows: Sequence[Data], table: Table) -> Data:
    """The mean of the rows that meet in a cell.

    Raises:
        UsageError: the rows have different values of the axis, which the plan calls by the same name.
    """
    values = {row[table.across] for row in rows}
    if len(values) > 1:
        met = ", ".join(map(str, sorted(values)))
        raise UsageError(f"table {table.title!r}: {table.across} {met} meet in a cell; they need different names")
    return mean(rows)


def _is_shown(row: Data, table: Table) -> bool:
    of_part = not table.parts or row["part"] in table.parts
    return of_part and all(row.get(axis) in values for axis, values in table.where.items())


def _head(plan: StudyPlan, table: Table, data: Data) -> dict[str, Any]:
    """What the note of a table tells of its first part: throws of each case, and settings."""
    part = plan.parts[table.parts[0] if table.parts else next(iter(plan.parts))]
    return {"throws": part.count(data["throws"]), "settings": part.settings}


def share(cases: Sequence[bool]) -> dict[str, float]:
    """Share of true cases with Wilson's interval, as a figure of a row; shares of rows that meet are pooled."""
    return _share(sum(cases), len(cases))


def _share(true: int, count: int) -> dict[str, float]:
    return {**asdict(wilson(true, count)), "true": true, "count": count}


def mean(rows: Sequence[Data]) -> Data:
    """Rows as one, each number the mean of theirs, and each share that of all their cases."""
    first = rows[0]
    if len(rows) == 1:
        return first
    numbers = [name for name, value in first.items() if isinstance(value, float)]
    shares = [name for name, value in first.items() if isinstance(value, Mapping) and "count" in value]
    return {
        **first,
        **{name: sum(row[name] for row in rows) / len(rows) for name in numbers},
        **{name: _share(*(sum(row[name][part] for row in rows) for part in ("true", "count"))) for name in shares},
    }


def cell(text: str, row: Data, names: Mapping[str, Mapping[Any, str]]) -> str:
    """A cell of a row; a dash where a figure is missing."""
    try:
        return text_of(text, row, names)
    except KeyError:
        return NONE


def text_of(text: str, figures: Data, names: Mapping[str, Mapping[Any, str]]) -> str:
    """Text with figures in place of what stands in braces.

    Raises:
        KeyError: a figure is missing.
    """
    return _Formatter(figures, names).vformat(text, (), {})


class _Formatter(string.Formatter):
    """Finds figures by dotted paths, and knows units, intervals and what tables call values."""

    def __init__(self, figures: Data, names: Mapping[str, Mapping[Any, str]]) -> None:
        self._figures, self._names = figures, names

    def get_field(self, field_name: str, args: Any, kwargs: Any) -> tuple[Any, str]:
        value = _at(self._figures, field_name)
        known = self._names.get(field_name, {})
        if value in known if not isinstance(value, Mapping | list) else False:
            return known[value], field_name
        if value is None:
            raise KeyError(field_name)
        return value, field_name

    def format_field(self, value: Any, format_spec: str) -> str:
        if isinstance(value, str):
            return value
        match = FORMAT.fullmatch(format_spec)
        spec, unit = (f"{match[1]}f", match[2]) if match and match[2] else (format_spec, "")
        ends = [value["value"], value["low"], value["high"]] if isinstance(value, Mapping) else [value]
        middle, *interval = (format(UNITS[unit] * end if unit else end, spec) for end in ends)
        shown = f"{middle} {unit}" if unit else middle
        return f"{shown} ({'..'.join(interval)})" if interval else shown


def _at(figures: Data, path: str) -> Any:
    """What stands at a dotted path, in mappings by name and in lists by number.

    Raises:
        KeyError: nothing does.
    """
    value: Any = figures
    for key in [path] if path in figures else path.split("."):
        try:
            value = value[int(key)] if isinstance(value, Sequence) else value[key]
        except (IndexError, TypeError, ValueError):
            raise KeyError(path) from None
    return value
