"""Tables of text made from rows of figures: what the chapters of all reproduced papers have in common."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Final, NamedTuple

from agents.report.tables import escaped, markdown

Row = Mapping[str, Any]
Rows = Mapping[str, Row]
"""Rows by quantity."""

WORDS: Final = ("verdict", "note")
"""Columns of text."""
ODD: Final = ("misprint", "not reproducible", "differs", "infeasible")
"""Verdicts that ask for an explanation."""


class Grid(NamedTuple):
    """A table of text."""

    headline: str
    header: Sequence[str]
    rows: Sequence[Sequence[str]]

    def markdown(self) -> str:
        """The table as Markdown."""
        return markdown(self.header, escaped(self.rows), words=WORDS)


def plain(rows: Iterable[Row], *, verdict: bool = False) -> tuple[list[str], list[list[str]]]:
    """Header and lines of rows as they are."""
    header = ["figure", "published", "reproduced", *(["verdict"] if verdict else []), "note"]
    lines: list[list[str]] = []
    for row in rows:
        values = [with_unit(row["published"], row["unit"]), with_unit(row["reproduced"], row["unit"])]
        lines.append([short(row), *values, *([row["verdict"]] if verdict else []), row["note"]])
    return header, lines


def short(row: Row) -> str:
    """A quantity without the name of its paper and of its folder."""
    pieces = row["quantity"].split("/")
    own = pieces[1:] if pieces[0] == row["paper"] else pieces
    return " ".join(own[1:] if own[0] in ("inconsistency", "claim", "misprint") else own)


def with_unit(value: object, unit: str) -> str:
    """A figure with its unit; words stand alone."""
    written = text(value)
    return f"{written} {unit}" if isinstance(value, float) and unit != "-" else written


def number(row: Row | None, name: str, digits: int) -> str:
    """A figure of a row with a fixed number of decimals; a dash where there is none."""
    value = None if row is None else row.get(name)
    return "-" if value is None else f"{value:.{digits}f}" if isinstance(value, float) else str(value)


def text(value: object) -> str:
    """A figure for people."""
    return "-" if value is None else f"{value:.5g}" if isinstance(value, float) else str(value)


def below(rows: Rows, folder: str) -> dict[str, Row]:
    """Rows of a folder by the rest of their names."""
    start = f"{folder}/"
    return {name.removeprefix(start): row for name, row in rows.items() if name.startswith(start)}


def value(rows: Rows, quantity: str, form: str) -> str:
    """The reproduced figure of a quantity in a form of `str.format`; a dash where there is none."""
    row = rows.get(quantity)
    return "-" if row is None or row["reproduced"] is None else form.format(row["reproduced"])
