"""Tables of text made from rows of figures: what the tables of all papers have in common."""

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
"""What a table shows where there is no figure."""
_FOLDERS: Final = ("inconsistency", "claim", "misprint")
"""First parts of a quantity that say nothing beside its verdict."""


def by_quantity(rows: Iterable[Row]) -> dict[str, JsonRow]:
    """Rows as JSON by quantity, as `overview` gets them."""
    return {row.quantity: row.as_json() for row in rows}


def plain(headline: str, rows: Iterable[JsonRow], *, verdict: bool = True, drop: str = "") -> Grid:
    """Rows as they are, one a line; `drop` is a beginning that all their quantities share."""
    header = ["figure", "published", "reproduced", *(["verdict"] if verdict else []), "note"]
    lines: list[list[str]] = []
    for row in rows:
        values = [with_unit(row["published"], row["unit"]), with_unit(row["reproduced"], row["unit"])]
        judged = [row["verdict"]] if verdict else []
        lines.append([short(row["quantity"].removeprefix(drop)), *values, *judged, row["note"]])
    return Grid(headline, header, lines)


def listed(
    headline: str,
    rows: Iterable[Row],
    figures: Mapping[str, Figure] | None = None,
    data: Mapping[str, Any] | None = None,
    *,
    drop: str,
) -> Findings:
    """Findings whose rows all stand in one table, and figures by file name; `drop` as in `plain`."""
    found = tuple(rows)
    drawn = {name: svg(figure) for name, figure in (figures or {}).items()}
    return Findings(found, data or {}, drawn, (plain(headline, by_quantity(found).values(), drop=drop),))


def short(quantity: str) -> str:
    """A quantity for people."""
    pieces = [piece for piece in quantity.split("/") if piece]
    return " ".join(pieces[1:] if pieces[0] in _FOLDERS else pieces)


def with_unit(value: object, unit: str) -> str:
    """A figure with its unit; words stand alone."""
    written = text(value)
    return f"{written} {unit}" if isinstance(value, float) and unit != "-" else written


def text(value: object) -> str:
    """A figure for people."""
    return NONE if value is None else f"{value:.5g}" if isinstance(value, float) else str(value)


def number(row: JsonRow | None, name: str, digits: int) -> str:
    """An entry of a row with a fixed number of decimals; a dash where there is none."""
    found = None if row is None else row.get(name)
    return NONE if found is None else f"{found:.{digits}f}" if isinstance(found, float) else str(found)


def value(rows: Rows, quantity: str, form: str) -> str:
    """The reproduced figure of a quantity in a form of `str.format`; a dash where there is none."""
    row = rows.get(quantity)
    return NONE if row is None or row["reproduced"] is None else form.format(row["reproduced"])


def below(rows: Rows, folder: str) -> dict[str, JsonRow]:
    """Rows of a folder by the rest of their names."""
    start = f"{folder}/"
    return {name.removeprefix(start): row for name, row in rows.items() if name.startswith(start)}
