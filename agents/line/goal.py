"""What a plan of a line has to reach: a recovery, or a number of sorted objects a minute."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final, Literal

from ..ground.cli import UsageError
from ..ground.tables import percent

USUAL: Final = 0.95
"""Recovery to reach where nothing else is asked for."""
FORM: Final = re.compile(r"\s*(\d+(?:\.\d+)?)\s*(%|/\s*min)\s*")


@dataclass(frozen=True)
class Goal:
    """A figure of plans, and its least value."""

    figure: Literal["recovery", "sorted_per_min"]
    least: float

    @classmethod
    def of(cls, recovery: float = USUAL, want: str | None = None) -> Goal:
        """The goal that options ask for: `want`, such as 95% or 90/min, or else a recovery.

        Raises:
            UsageError: the recovery is no share, or `want` has another form.
        """
        if want is None:
            if not isinstance(recovery, float | int) or not 0.0 < recovery < 1.0:
                raise UsageError(f"--recovery is {recovery!r}; it must lie between 0 and 1")
            return cls("recovery", recovery)
        if recovery != USUAL:
            raise UsageError(f"--want is {want!r} and --recovery {recovery!r}; leave one of them out")
        match = FORM.fullmatch(want) if isinstance(want, str) else None
        value = 0.0 if match is None else float(match[1])
        if match is None or not value > 0.0 or (match[2] == "%" and not value < 100.0):
            raise UsageError(f"--want is {want!r}; it must be a recovery below 100 % or a pace, such as 95% or 90/min")
        return cls("recovery", value / 100.0) if match[2] == "%" else cls("sorted_per_min", value)

    def is_reached(self, row: Mapping[str, Any]) -> bool:
        """Whether the whole interval of a plan's figure lies above the least value."""
        return bool(row[f"{self.figure}_low"] >= self.least)

    def text(self, value: float) -> str:
        """A value of the figure in words."""
        return f"a recovery of {percent(value)}" if self.figure == "recovery" else f"{value:.1f} sorted a minute"
