"""Answers to a design: its figures, judged by the same functions as `pnt-gym line plan`, and designs compared."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, Self, final

import numpy as np

from pnt_gym.cells.line.config import LineConfig
from pnt_gym.errors import ConfigError

from ..ground import metrics
from ..line import plans
from ..line.plans import Conditions, Planned

DURATION: Final = 120.0
"""Length of the shifts by which designs are judged [s], the default of `pnt-gym line plan`."""
PROVISIONAL: Final = Conditions(shifts=8, throws=256, check=0, threads=1)
"""Conditions of the first answer, which comes at once."""
SETTLED: Final = Conditions(shifts=16, throws=1024, check=0, threads=1)
"""Conditions of the second answer, which holds."""


@final
@dataclass(frozen=True)
class Answer:
    """What a design brings."""

    plan: Planned
    is_settled: bool
    """Whether the answer is settled, and not provisional."""

    @property
    def line(self) -> LineConfig:
        """The design."""
        return self.plan.config

    @property
    def row(self) -> dict[str, Any]:
        """Figures by the names of `pnt-gym line plan --json`."""
        return self.plan.row


def judge(line: LineConfig, is_settled: bool) -> Answer:
    """Judge a design.

    Raises:
        ConfigError: no object came in any shift.
    """
    numbers = {
        "robots": len(line.robots),
        "belt_speed": line.cell.belt.speed,
        "percent": max(line.cell.limits.percent),
        "skills": "level",
    }
    plan = plans.judge(numbers, line, SETTLED if is_settled else PROVISIONAL)
    if not np.isfinite(plan.row["recovery"]):
        raise ConfigError(f"no objects came in {PROVISIONAL.shifts} shifts of {line.duration:g} s; raise the infeed")
    return Answer(plan, is_settled)


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
