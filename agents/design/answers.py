"""Answers to a design: its figures, judged by the same functions as `pnt-gym line plan`, and designs compared."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, Self, final

import numpy as np

from pnt_gym.cells.line.config import LineConfig

from ..ground import metrics
from ..line.estimate import estimate
from ..line.flown import PROVISIONAL, SETTLED, FlightTable
from ..line.plans import Conditions, Planned

DURATION: Final = 120.0
"""Length of the shifts by which designs are judged [s], the default of `pnt-gym line plan`."""
FIRST: Final = Conditions(shifts=8, check=0, threads=1)
"""Conditions of the provisional answer."""
LAST: Final = Conditions(shifts=16, check=0, threads=1)
"""Conditions of the settled answer."""
KEPT: Final = 12
"""Tables of chances that are kept, of the cells judged last."""


@final
@dataclass(frozen=True)
class Answer:
    """What a design brings."""

    line: LineConfig
    """The design."""
    plan: Planned
    is_settled: bool
    """Whether the answer is settled, and not provisional."""

    @property
    def row(self) -> dict[str, Any]:
        """Figures by the names of `pnt-gym line plan --json`."""
        return self.plan.row


@final
class Judge:
    """Judges designs by flights, and keeps their tables, which other designs of the same cells share."""

    def __init__(self) -> None:
        self._tables = dict[str, FlightTable]()

    def answer(self, line: LineConfig, is_settled: bool) -> Answer:
        """Judge a design.

        Raises:
            PntGymError: no robot can throw into its bins, or no object came.
        """
        near = self._tables.get(line.digest(), next(reversed(self._tables.values()), None))
        conditions, flights = (LAST, SETTLED) if is_settled else (FIRST, PROVISIONAL)
        found = estimate(line, conditions, flights, near)
        self._tables.pop(found.table.digest, None)
        self._tables[found.table.digest] = found.table
        if len(self._tables) > KEPT:
            self._tables.pop(next(iter(self._tables)))
        return Answer(line, found.planned, is_settled)


@final
@dataclass(frozen=True)
class Gain:
    """Recovery of a design less that of another design, on the same objects, with its 95 % interval."""

    value: float
    low: float
    high: float

    @classmethod
    def of(cls, answer: Answer, other: Answer) -> Self:
        """What one design gains over another.

        Throws that are counted anew for another cell make the difference less certain.
        """
        paired = answer.plan.recovery - other.plan.recovery
        over = metrics.interval(paired[np.isfinite(paired)])
        is_same = answer.line.digest() == other.line.digest()
        counts = 0.0 if is_same else float(np.hypot(answer.row["recovery_counts"], other.row["recovery_counts"]))
        below, above = (float(np.hypot(end - over.value, counts)) for end in (over.low, over.high))
        return cls(over.value, over.value - below, over.value + above)

    @property
    def is_clear(self) -> bool:
        """Whether the interval does not contain zero."""
        return not self.low <= 0.0 <= self.high

    @property
    def text(self) -> str:
        """The difference in words."""
        interval = f"{100.0 * self.low:+.1f}..{100.0 * self.high:+.1f}"
        if not self.is_clear:
            return f"no difference in recovery ({interval} points)"
        return f"{100.0 * self.value:+.1f} points of recovery ({interval})"
