"""Tables of text from rows of figures, for all papers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Final, TypeAlias

from ..ground.drawings import Figure, svg
from ..ground.tables import Grid
from .finding import Findings, Row

JsonRow: TypeAlias = Mapping[str, Any]
Rows: TypeAlias = Mapping[str, JsonRow]
"""Rows as JSON by quantity."""
NONE: Final = "-"
"""Text of a cell without a figure."""
_FOLDERS: Final = ("statement", "claim", "misprint")
"""First parts of a quantity's name that tables leave out, because the verdict says as much."""
JUDGED: Final = "verdict"
"""Column of the tables whose rows are judged."""


def by_quantity(rows: Iterable[Row]) -> dict[str, JsonRow]:
    """Rows as JSON by quantity, as `overview` takes them."""
    return {row.quantity: row.as_json() for row in rows}


def plain(headline: str, rows: Iterable[JsonRow], *, verdict: bool = True, drop: str = "") -> Grid:
    """Table of rows, one per line; `drop` is a common prefix of their quantities that is left out."""
    header = ["figure", "published", "reproduced", *([JUDGED] if verdict else []), "note"]
    lines: list[list[str]] = []
    for row in rows:
        values = [with_unit(row["published"], row["unit"]), with_unit(row["reproduced"], row["unit"])]
        judged = [row["verdict"]] if verdict else []
        lines.append([short(row["quantity"].removeprefix(drop)), *values, *judged, row["note"]])
    return Grid(headline, header, lines)


def row_grids(headline: str, rows: Iterable[Row], *, drop: str) -> tuple[Grid, ...]:
    """Table of the judged rows, and table of the rows that are ours, each if it has rows; `drop` as in `plain`."""
    judged: list[JsonRow] = []
    ours: list[JsonRow] = []
    for row in by_quantity(rows).values():
        (ours if row["verdict"] == "ours" else judged).append(row)
    tables = (
        plain(headline, judged, drop=drop),
        plain(f"{headline}: ours", ours, verdict=False, drop=drop),
    )
    return tuple(grid for grid in tables if grid.rows)


def table_findings(
    headline: str,
    rows: Iterable[Row],
    figures: Mapping[str, Figure] | None = None,
    data: Mapping[str, Any] | None = None,
    *,
    drop: str,
) -> Findings:
    """Findings with the tables of all rows, and figures by file name; `drop` as in `plain`."""
    table = tuple(rows)
    drawn = {name: svg(figure) for name, figure in (figures or {}).items()}
    return Findings(table, data or {}, drawn, row_grids(headline, table, drop=drop))


def short(quantity: str) -> str:
    """Name of a quantity for people."""
    pieces = [piece for piece in quantity.split("/") if piece]
    return " ".join(pieces[1:] if pieces[0] in _FOLDERS else pieces)


def with_unit(value: object, unit: str) -> str:
    """Text of a figure with its unit; words have no unit."""
    written = text(value)
    return f"{written} {unit}" if isinstance(value, float) and unit != "-" else written


def text(value: object) -> str:
    """Text of a figure."""
    return NONE if value is None else f"{value:.5g}" if isinstance(value, float) else str(value)


def number(row: JsonRow | None, name: str, digits: int) -> str:
    """Text of a row's entry with a fixed number of decimals; a dash for a missing entry."""
    entry = None if row is None else row.get(name)
    return NONE if entry is None else f"{entry:.{digits}f}" if isinstance(entry, float) else str(entry)


def value(rows: Rows, quantity: str, form: str) -> str:
    """Text of a quantity's reproduced value in a form of `str.format`; a dash for a missing value."""
    row = rows.get(quantity)
    return NONE if row is None or row["reproduced"] is None else form.format(row["reproduced"])
