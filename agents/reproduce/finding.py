"""Findings of a reproduction: figures beside the published ones, with verdicts that are computed and never typed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final, Literal, TypeAlias, final

from ..ground.tables import Grid

Value: TypeAlias = float | str | None
Verdict: TypeAlias = Literal["reproduced", "differs", "misprint", "not reproducible", "ours"]
Conditions: TypeAlias = Literal["paper", "ours", "unpublished"]
"""Conditions of a computed figure: the paper's own; ours (another protocol, assumed scatter, other gains); or those
that the paper leaves out although they decide the figure."""


def agree(published: Value, reproduced: Value, tolerance: float | None) -> bool:
    """Whether two figures are the same: numbers within the tolerance (None: exactly), words to the letter."""
    if isinstance(published, int | float) and isinstance(reproduced, int | float):
        return math.isfinite(reproduced) and abs(reproduced - published) <= (tolerance or 0.0)
    return published == reproduced


@final
@dataclass(frozen=True)
class Row:
    """One figure of a paper, or a figure of ours that belongs beside the paper's.

    Attributes:
        quantity: name of the figure, parts joined by "/".
        published: the paper's value; None if the paper prints none.
        reproduced: the computed value; None where there is none.
        unit: SI unit, "-" for a pure number.
        note: one sentence for people: the definition used, or why the figures differ.
        tolerance: largest difference, in `unit`, at which both values count as equal; None for words and for values
            without a comparison.
        conditions: conditions of the computation.
        explained: the value that one slip in the paper would give (two names swapped, another formula); a difference is
            a misprint if this value equals the published one.
        holds: whether a claim in words ("> 0.3", "continuous") is true of the figure; None where the two values are
            compared.
        statement: name of the published statement that the row tests; rows that test one statement under several
            readings have one name, and the row's own quantity is the default.
        details: further figures of the same quantity by name, JSON values only.
    """

    quantity: str
    published: Value
    reproduced: Value
    unit: str
    note: str = ""
    tolerance: float | None = None
    conditions: Conditions = "paper"
    explained: Value = None
    holds: bool | None = None
    statement: str = ""
    details: Mapping[str, Any] = field(default_factory=dict[str, Any])

    @classmethod
    def compared(
        cls,
        quantity: str,
        published: Value,
        reproduced: Value,
        unit: str,
        *,
        within: float | None = None,
        note: str = "",
        holds: bool | None = None,
        statement: str = "",
        **details: Any,
    ) -> Row:
        """A figure of the paper under its own conditions; `within` is the tolerance (see `printed` and `share`)."""
        row = cls(quantity, published, reproduced, unit, note, within, holds=holds)
        return replace(row, statement=statement, details=details)

    def explain(self, value: Value) -> Row:
        """The row with the value that one slip in the paper would give."""
        return replace(self, explained=value)

    @classmethod
    def ours(
        cls, quantity: str, reproduced: Value, unit: str, *, beside: Value = None, note: str = "", **details: Any
    ) -> Row:
        """A figure that the paper does not give under these conditions; `beside` is the paper's most similar value."""
        return cls(quantity, beside, reproduced, unit, note, conditions="ours", details=details)

    @classmethod
    def missing(
        cls,
        quantity: str,
        published: Value,
        unit: str,
        *,
        reproduced: Value = None,
        note: str,
        statement: str = "",
        **details: Any,
    ) -> Row:
        """A figure whose conditions the paper leaves out; the note says in a sentence which one is missing."""
        return cls(
            quantity, published, reproduced, unit, note, conditions="unpublished", statement=statement, details=details
        )

    @property
    def verdict(self) -> Verdict:
        """Verdict from the two values, the tolerance and the conditions."""
        if self.conditions == "ours" or self.published is None:
            return "ours"
        if self.conditions == "unpublished" or self.reproduced is None:
            return "not reproducible"
        if self.holds or (self.holds is None and agree(self.published, self.reproduced, self.tolerance)):
            return "reproduced"
        slipped = self.explained is not None and agree(self.published, self.explained, self.tolerance)
        return "misprint" if slipped else "differs"

    def as_json(self) -> dict[str, Any]:
        """The row as JSON values: the main entries and the details; a detail cannot replace a main entry."""
        main = {
            "quantity": self.quantity,
            "published": self.published,
            "reproduced": self.reproduced,
            "unit": self.unit,
            "verdict": self.verdict,
            "tolerance": self.tolerance,
            "note": self.note,
        }
        claim: dict[str, Any] = {} if self.holds is None else {"holds": self.holds}
        if self.statement:
            claim["statement"] = self.statement
        return {**main, **self.details, **claim, **main}


KINDEST_FIRST: Final[tuple[Verdict, ...]] = ("reproduced", "misprint", "differs", "not reproducible")
"""Verdicts in the order in which one counts for a statement that several rows test: a paper is wrong only if it is
wrong under every reading."""


def judge(rows: Iterable[Mapping[str, Any]]) -> dict[str, Verdict]:
    """Verdict of each published statement, from rows as JSON; rows that are `ours` say nothing about a paper."""
    verdicts: dict[str, Verdict] = {}
    for row in rows:
        if row["published"] is None or row["verdict"] == "ours":
            continue
        name: str = row.get("statement", row["quantity"])
        verdicts[name] = min(verdicts.get(name, row["verdict"]), row["verdict"], key=KINDEST_FIRST.index)
    return verdicts


def printed(digits: int) -> float:
    """Tolerance of a figure printed with a number of decimals: half a unit of the last decimal, plus rounding."""
    return 0.5000001 * 10.0**-digits


def share(published: float, part: float) -> float:
    """Tolerance as a share of a published figure."""
    return abs(published) * part


@final
@dataclass(frozen=True)
class Findings:
    """Findings of one part of a reproduction.

    Attributes:
        rows: published beside reproduced figures.
        data: other useful JSON values by name (no NaN).
        figures: SVG texts by file name without folder, e.g. "hassan_scurve.svg".
        grids: tables for people, in the order of the report.
    """

    rows: tuple[Row, ...] = ()
    data: Mapping[str, Any] = field(default_factory=dict[str, Any])
    figures: Mapping[str, str] = field(default_factory=dict[str, str])
    grids: tuple[Grid, ...] = ()


Parts: TypeAlias = Mapping[str, Callable[[], Findings]]
"""The independent pieces of a reproduction by name, in the order of the report; each can run in another process."""


@final
@dataclass(frozen=True)
class Overview:
    """Overview of a paper's parts, made from all rows of the paper, as JSON, once its parts are done.

    Attributes:
        grids: tables over several parts, by a name that a README may refer to; these tables come first in the report.
        notes: sentences under a table, by the table's name.
        figures: drawings over several parts, SVG texts by file name.
    """

    grids: Mapping[str, Grid] = field(default_factory=dict[str, Grid])
    notes: Mapping[str, str] = field(default_factory=dict[str, str])
    figures: Mapping[str, str] = field(default_factory=dict[str, str])
