"""The results of a reproduction: figures beside the published ones, with computed verdicts."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, TypeAlias, final

from ..ground.tables import Grid

Value: TypeAlias = float | str | None
Verdict: TypeAlias = Literal["reproduced", "differs", "misprint", "not reproducible", "infeasible", "ours"]
Conditions: TypeAlias = Literal["paper", "ours", "unpublished", "infeasible"]
"""Under what a figure was computed: the paper's own conditions, ours (another protocol, assumed scatter, own gains),
conditions that the paper leaves out and that decide the figure, or conditions under which nothing feasible exists."""


def agree(one: Value, other: Value, tolerance: float | None) -> bool:
    """Whether two figures are the same: numbers within the tolerance (None: exactly), words to the letter."""
    if isinstance(one, int | float) and isinstance(other, int | float):
        return math.isfinite(other) and abs(other - one) <= (tolerance or 0.0)
    return one == other


@final
@dataclass(frozen=True)
class Row:
    """One figure of a paper, or one that belongs beside it.

    Attributes:
        quantity: name of the figure, parts joined by "/".
        published: what the paper prints; None if it prints nothing.
        reproduced: what was computed; None where there is none.
        unit: SI unit, "-" for a pure number.
        note: one sentence for people: the definition used, or why the figures differ.
        tolerance: largest difference, in `unit`, at which the two count as the same; None for words and for figures
            that are compared with nothing.
        conditions: what it was computed under.
        explained: the figure that one slip in the paper would give (two names swapped, another formula); it makes a
            difference a misprint if it is the published one.
        holds: whether a claim in words ("> 0.3", "continuous") is true of the figure; None where the two themselves
            are compared.
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
        explained: Value = None,
        holds: bool | None = None,
        **details: Any,
    ) -> Row:
        """A figure of the paper under its own conditions; `within` is the tolerance (see `printed` and `share`)."""
        return cls(
            quantity, published, reproduced, unit, note, within, explained=explained, holds=holds, details=details
        )

    @classmethod
    def ours(
        cls, quantity: str, reproduced: Value, unit: str, *, beside: Value = None, note: str = "", **details: Any
    ) -> Row:
        """A figure that the paper does not give, or not under these conditions; `beside` is what it prints nearest."""
        return cls(quantity, beside, reproduced, unit, note, conditions="ours", details=details)

    @classmethod
    def missing(
        cls,
        quantity: str,
        published: Value,
        unit: str,
        why: Literal["unpublished", "infeasible"],
        *,
        reproduced: Value = None,
        note: str,
        **details: Any,
    ) -> Row:
        """A figure of the paper that cannot be set beside one of ours, and why: the note says it in a sentence."""
        return cls(quantity, published, reproduced, unit, note, conditions=why, details=details)

    @property
    def verdict(self) -> Verdict:
        """How the two figures compare."""
        if self.conditions == "infeasible":
            return "infeasible"
        if self.conditions == "ours" or self.published is None:
            return "ours"
        if self.conditions == "unpublished" or self.reproduced is None:
            return "not reproducible"
        if self.holds or (self.holds is None and agree(self.published, self.reproduced, self.tolerance)):
            return "reproduced"
        slipped = self.explained is not None and agree(self.published, self.explained, self.tolerance)
        return "misprint" if slipped else "differs"

    def as_json(self) -> dict[str, Any]:
        """The row with its details beside the main entries, which no detail can take the place of."""
        main = {
            "quantity": self.quantity,
            "published": self.published,
            "reproduced": self.reproduced,
            "unit": self.unit,
            "verdict": self.verdict,
            "tolerance": self.tolerance,
            "note": self.note,
        }
        claim = {} if self.holds is None else {"holds": self.holds}
        return {**main, **self.details, **claim, **main}


def printed(digits: int) -> float:
    """The tolerance of a figure printed with so many decimals: half a unit of the last one, and a rounding more."""
    return 0.5000001 * 10.0**-digits


def share(published: float, part: float) -> float:
    """The tolerance that is a part of a published figure."""
    return abs(published) * part


@final
@dataclass(frozen=True)
class Findings:
    """The results of one part of a reproduction.

    Attributes:
        rows: published beside reproduced figures.
        data: what else is useful, JSON values by name (no NaN).
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
    """What a paper's parts show together; made from all rows of a paper, as JSON, once its parts are done.

    Attributes:
        grids: tables that draw on several parts, by a name that a README may ask for; they come first in the report.
        notes: sentences that stand under a table, by the table's name.
        figures: SVG texts by file name of what is drawn of several parts' rows.
    """

    grids: Mapping[str, Grid] = field(default_factory=dict[str, Grid])
    notes: Mapping[str, str] = field(default_factory=dict[str, str])
    figures: Mapping[str, str] = field(default_factory=dict[str, str])
