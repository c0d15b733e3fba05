"""What a reproduction finds: rows of published and reproduced figures, data behind them, and pictures."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, TypeAlias, final

Value: TypeAlias = float | str | None
Verdict: TypeAlias = Literal["reproduced", "differs", "misprint", "not reproducible", "infeasible", "ours"]
"""`ours` marks a figure that the paper does not give; `infeasible` one that the stated bounds rule out."""


@final
@dataclass(frozen=True)
class Row:
    """One figure of a paper, or one that belongs beside it.

    Attributes:
        quantity: name of the figure, parts joined by "/".
        published: what the paper prints; None if it prints nothing.
        reproduced: what was computed; None where there is none (verdict `infeasible`).
        unit: SI unit, "-" for a pure number.
        verdict: how the two compare.
        note: one sentence for people: the definition used, or why the figures differ.
        details: further figures of the same quantity by name, JSON values only.
    """

    quantity: str
    published: Value
    reproduced: Value
    unit: str
    verdict: Verdict
    note: str = ""
    details: Mapping[str, Any] = field(default_factory=dict[str, Any])

    def as_json(self) -> dict[str, Any]:
        """The row with its details beside the six main entries."""
        main = {
            "quantity": self.quantity,
            "published": self.published,
            "reproduced": self.reproduced,
            "unit": self.unit,
            "verdict": self.verdict,
            "note": self.note,
        }
        return {**main, **self.details}


@final
@dataclass(frozen=True)
class Findings:
    """What one part of a reproduction found.

    Attributes:
        rows: published beside reproduced figures.
        data: what else is useful, JSON values by name (no NaN).
        figures: SVG texts by file name without folder, e.g. "hassan_scurve.svg".
    """

    rows: tuple[Row, ...] = ()
    data: Mapping[str, Any] = field(default_factory=dict[str, Any])
    figures: Mapping[str, str] = field(default_factory=dict[str, str])


@final
@dataclass(frozen=True)
class Part:
    """One independent piece of a reproduction; `run` takes no argument and can run in another process."""

    name: str
    run: Callable[[], Findings]


def merged(findings: Iterable[Findings]) -> Findings:
    """All findings as one, in their order."""
    found = list(findings)
    data: dict[str, Any] = {}
    figures: dict[str, str] = {}
    for one in found:
        data.update(one.data)
        figures.update(one.figures)
    return Findings(tuple(row for one in found for row in one.rows), data, figures)
