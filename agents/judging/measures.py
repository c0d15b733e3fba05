"""Measures: how a sequential comparison takes a figure of two controllers, unit by unit."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Final, Self, final

import numpy as np

from pnt_gym.arrays import Floats

from .figure import Figure

LARGER: Final = "{a} has the larger {label} more often than {b}, by {amount} of all {unit}"
"""Words for a figure without a largest difference, of which only the sign of each difference counts."""


@final
@dataclass(frozen=True)
class Measure:
    """Differences of one figure between two controllers: how far they count, and words for them."""

    figure: Figure
    cap: float | None = None
    """Largest difference of a unit that counts, in SI units; a larger one counts as this. None: only signs count."""
    words: str = "{a} has {amount} more {label} than {b}"
    """Sentence about the difference, where controller `a` is ahead."""
    sign: int = 1
    """1 if the controller with the larger figure is ahead in `words`, -1 if that with the smaller one is."""

    @classmethod
    def of_signs(cls, figure: Figure) -> Self:
        """Measure that counts the units with a larger and with a smaller figure."""
        shares = replace(figure, label=f"{figure.label} (sign)", unit="%", scale=100.0, digits=1)
        return cls(shares, words=LARGER.replace("{label}", figure.label))

    @property
    def bound(self) -> float:
        """Largest absolute value of a difference."""
        return 1.0 if self.cap is None else self.cap

    def differences(self, a: Floats, b: Floats) -> Floats:
        """Differences a - b of the units (U,) in which both figures are known, each up to the cap."""
        difference = a - b
        known = difference[np.isfinite(difference)]
        return np.sign(known) if self.cap is None else np.clip(known, -self.cap, self.cap)

    def sentence(self, pair: tuple[str, str], unit: str, value: float, low: float, high: float) -> str:
        """Sentence about a difference whose interval excludes zero, from the view of the controller that is ahead."""
        least, most = sorted((abs(low), abs(high)))
        ahead, behind = pair if (low > 0.0) == (self.sign > 0) else pair[::-1]
        amount = self.figure.text(value if low > 0.0 else -value)  # negative only for a mean beyond zero
        words = self.words.format(a=ahead, b=behind, amount=amount, label=self.figure.label, unit=unit)
        return f"{words} ({self.number(least)} to {self.number(most)})"

    def number(self, value: float) -> str:
        """Text of a value [SI] in the figure's unit, without the unit."""
        return f"{self.figure.scale * value:.{self.figure.digits}f}"

    def with_cap(self, cap: float) -> Self:
        """The same measure with another largest difference, given in the figure's unit."""
        return replace(self, cap=cap / self.figure.scale)

    def as_json(self) -> dict[str, Any]:
        """Label, unit, factor from SI units to that unit, and cap in SI units, as JSON values."""
        return {"label": self.figure.label, "unit": self.figure.unit, "scale": self.figure.scale, "cap": self.cap}
