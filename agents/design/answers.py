"""Answers to a design: its figures, judged by the same functions as `pnt-gym line plan`, and designs compared."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, final

from pnt_gym.cells.line.config import LineConfig

from ..ground.metrics import Interval
from ..line.changes import Change, gain
from ..line.estimate import estimate
from ..line.flown import PROVISIONAL, SETTLED, FlightTable
from ..line.plans import Conditions, Planned

DURATION: Final = 120.0
"""Length of the shifts by which designs are judged [s], the default of `pnt-gym line plan`."""
FIRST: Final = Conditions(shifts=4, check=0, threads=1, quiet=True)
"""Conditions of the provisional answer."""
LAST: Final = Conditions(shifts=16, check=0, threads=1, quiet=True)
"""Conditions of the settled answer."""
SEARCH: Final = Conditions(shifts=8, check=2, threads=1, quiet=True)
"""Conditions of a search of places, whose find is judged in the full physics."""
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


def difference(answer: Answer, other: Answer) -> Interval:
    """Recovery of a design less that of another design, on the same objects."""
    return gain(Change(answer.line.name, "", answer.line), answer.plan, other.plan).points


def in_points(over: Interval) -> str:
    """A difference of recoveries in words."""
    interval = f"{100.0 * over.low:+.1f}..{100.0 * over.high:+.1f}"
    if over.low <= 0.0 <= over.high:
        return f"no difference in recovery ({interval} points)"
    return f"{100.0 * over.value:+.1f} points of recovery ({interval})"
