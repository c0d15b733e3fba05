"""Figures of records: label, unit and number format."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from ..ground import metrics


@final
@dataclass(frozen=True)
class Figure:
    """Label, unit and number format of a record's figure."""

    label: str
    unit: str = ""
    scale: float = 1.0
    """Factor from the SI value to the unit."""
    digits: int = 1

    def text(self, value: float | None) -> str:
        """Text of a value with its unit; "-" for None or NaN."""
        return (
            "-" if value is None or not np.isfinite(value) else self._with_unit(f"{self.scale * value:.{self.digits}f}")
        )

    def interval(self, interval: metrics.Interval, sign: str = "") -> str:
        """Text of a value with its 95 % interval and unit."""
        value, low, high = (
            f"{self.scale * number:{sign}.{self.digits}f}" for number in (interval.value, interval.low, interval.high)
        )
        return self._with_unit(f"{value} ({low}..{high})")

    def _with_unit(self, text: str) -> str:
        return f"{text} {self.unit}".rstrip()
