"""Confidence sequences: intervals for a mean that stay valid however often they are looked at.

Observations x lie in [-B, B], so y = B + x lies in [0, 2B]. A gambler who doubts that the mean of y is at most m bets
a fraction f of the capital on each observation; the capital is multiplied by 1 - f + f y / m. Where each observation,
given all earlier ones, has a mean of at most m, no strategy is expected to gain, and the capital ever reaches 1 / alpha
with a probability of at most alpha (Ville's inequality). The capital here is divided over many fractions f, as in
Cover's universal portfolio, so no variance has to be known. The lower limit is the largest m against which the capital
reached 1 / alpha; the upper limit is the lower limit of 2B - y. Each limit has half of the probability to err.

An interval is what the intervals after all updates share, so an interval never widens. The mean of the observations may
therefore lie outside of the interval: an earlier limit stays where later observations lie beyond that limit on average.

Assumed: the mean of an observation, given all earlier observations, is constant. Nothing is assumed of the distribution
but its bound. For observations of equal distribution that do not depend on one another this always holds.

Source: Waudby-Smith and Ramdas (2024), "Estimating means of bounded random variables by betting", Journal of the Royal
Statistical Society B 86(1), sections 4 and 5; Cover (1991), "Universal portfolios".
"""

from __future__ import annotations

from typing import Final, final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats

FRACTIONS: Final[Floats] = np.geomspace(0.01, 0.99, 16)
"""Fractions of the capital on each observation; small fractions find small differences after many observations."""
WEIGHTS: Final[Floats] = FRACTIONS / FRACTIONS.sum()
"""Shares of the first capital: fractions lie evenly on a logarithmic scale, so these shares spread it evenly over f."""
HALVINGS: Final = 40
"""Halvings of the range in which a limit lies: an error of 1e-12 of the range."""


@final
class ConfidenceSequence:
    """Interval for the mean of bounded observations, valid at all times together.

    Args:
        bound: largest absolute value of an observation.
        alpha: probability that the mean ever lies outside the interval.
    """

    def __init__(self, bound: float, alpha: float) -> None:
        self.bound, self.alpha = bound, alpha
        self.low, self.high = -bound, bound
        self.low_since, self.high_since = 0, 0
        """Dates of the limits, as `update` was told them."""
        self._values: Floats = np.zeros(0)

    @property
    def count(self) -> int:
        """Number of observations."""
        return len(self._values)

    @property
    def value(self) -> float:
        """Mean of the observations; NaN without observations."""
        # Rounding alone could move a mean of bounded numbers beyond the bound.
        return float(np.clip(self._values.mean(), -self.bound, self.bound)) if self.count else float("nan")

    @property
    def outside(self) -> bool:
        """Whether the mean of the observations lies outside of the interval."""
        return self.value < self.low or self.value > self.high

    @property
    def excludes_zero(self) -> bool:
        """Whether zero lies outside the interval."""
        return self.low > 0.0 or self.high < 0.0

    def is_within(self, margin: float) -> bool:
        """Whether the interval lies between -margin and margin."""
        return -margin <= self.low and self.high <= margin

    def as_json(self) -> dict[str, float | int | bool | None]:
        """Mean, limits, their dates and number of observations; the mean of no observations is None."""
        value = self.value if self.count else None
        ends = {"low": self.low, "high": self.high, "excludes_zero": self.excludes_zero, "outside": self.outside}
        return {"value": value, **ends, "low_since": self.low_since, "high_since": self.high_since, "count": self.count}

    def update(self, values: ArrayLike, date: int) -> None:
        """Narrow the interval by further observations (N,); a limit that they narrow gets the date."""
        self._values = np.concatenate([self._values, np.asarray(values, dtype=np.float64)])
        low = max(self.low, self._limit(self._values, self.low))
        high = min(self.high, -self._limit(-self._values, -self.high))
        if low > high:
            return  # the assumption, or luck of probability alpha, has failed: the interval stays
        if low > self.low:
            self.low, self.low_since = low, date
        if high < self.high:
            self.high, self.high_since = high, date

    def _limit(self, values: Floats, low: float) -> float:
        """Largest mean, at least `low`, against which the capital of now is 2 / alpha or more; `low` without one."""
        goal, high = np.log(2.0 / self.alpha), self.bound
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            gains = (values - middle) / (self.bound + middle)  # y / m - 1
            # Logarithm of the capital against "the mean is at most `middle`" after all values.
            capital = np.logaddexp.reduce(np.log(WEIGHTS) + np.log1p(np.outer(FRACTIONS, gains)).sum(axis=1))
            low, high = (middle, high) if capital >= goal else (low, middle)
        return low
