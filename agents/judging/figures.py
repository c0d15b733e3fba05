"""Figures of records: how each is called and written, how it follows from rows, and how controllers differ in it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Final, Self, TypeAlias, final

import numpy as np

from pnt_gym.arrays import Floats

from ..ground import metrics
from ..ground.files import jsonable
from .rows import Rows

Kind: TypeAlias = Callable[..., Any]
"""Function of the columns of a figure, (S, U) or (S, U, K) each, that returns a JSON value."""
SIGNS: Final = "{a} has the larger {label} more often than {b}, by {amount} of all {unit}"
"""Words for a figure without a largest difference, of which only the sign of each difference counts."""


def mean(values: Floats) -> Any:
    """Mean of all finite values, or of those of each of K items or robots; None for a mean of none."""
    rows = values.reshape(-1, *values.shape[2:])
    finite = np.isfinite(rows)
    total = np.where(finite, rows, 0.0).sum(axis=0)
    return jsonable(np.divide(total, finite.sum(axis=0), out=np.full_like(total, np.nan), where=finite.any(axis=0)))


def count(values: Floats) -> int:
    """Number of the units of one seed."""
    return values.shape[1]


def total(values: Floats) -> int:
    """Sum of whole numbers."""
    return round(float(values.sum()))


def ratio(part: Floats, whole: Floats) -> float | None:
    """One sum over another one; None if the other one is 0."""
    return float(part.sum() / whole.sum()) if whole.sum() else None


def share(part: Floats, whole: Floats) -> float | None:
    """A ratio of counts, whose interval is Wilson's."""
    return ratio(part, whole)


def rate(amount: Floats, seconds: Floats) -> float:
    """Sum of amounts per minute of a time [s]."""
    return metrics.throughput(amount.ravel(), seconds.ravel()).sorted


@final
@dataclass(frozen=True)
class Figure:
    """A figure of a record.

    A label is enough for a mean of the column that has the figure's name; unit and scale say how the figure is written.
    """

    label: str = ""
    """Name in tables; a figure without a name stands in JSON alone."""
    unit: str = ""
    scale: float = 1.0
    """Factor from the SI value to the unit."""
    digits: int = 1
    kind: Kind = mean
    of: tuple[str, ...] = ()
    """Columns of the rows from which the figure is computed; none: the column with the figure's name."""
    ends: tuple[str, str] | None = None
    """Names of the ends of the 95 % interval in a summary; None for no interval."""
    head: str = ""
    """Name in tables of several controllers; none: the figure is not shown there."""
    cap: float | None = None
    """Largest difference of two controllers in a unit that counts, in SI units. None: only its sign counts."""
    words: str = "{a} has {amount} more {label} than {b}"
    """Sentence about the difference, where controller `a` is ahead."""
    sign: int = 1
    """1 if the controller with the larger figure is ahead in `words`, -1 if that with the smaller one is."""

    def columns(self, name: str) -> tuple[str, ...]:
        """Columns from which the figure with a name is computed."""
        return self.of or (name,)

    def summary(self, name: str, rows: Rows) -> dict[str, Any]:
        """The figure by name, with its interval; empty where the rows lack a column."""
        names = self.columns(name)
        if not all(column in rows for column in names):
            return {}
        value = self.kind(*(rows[column] for column in names))
        if self.ends is None:
            return {name: value}
        interval = self._interval(name, rows)
        ends = (None, None) if interval is None else (interval.low, interval.high)
        return {name: value, **dict(zip(self.ends, ends, strict=True))}

    def units(self, name: str, rows: Rows) -> tuple[Floats, ...]:
        """The figure of each unit, or run of units, that depends on no other one: columns (S, N).

        A mean has one column; a rate has two, its sums and their times.
        """
        columns = [rows.runs(column) for column in self.columns(name)]
        if self.kind is rate:
            return tuple(column.sum(axis=1) for column in columns)
        finite = np.isfinite(columns[0])
        sums, counts = np.where(finite, columns[0], 0.0).sum(axis=1), finite.sum(axis=1)
        return (np.divide(sums, counts, out=np.full_like(sums, np.nan), where=counts > 0),)

    def _interval(self, name: str, rows: Rows) -> metrics.Interval | None:
        """The 95 % interval; of means it is bootstrapped over units, averaged over the seeds."""
        if self.kind is share:
            part, whole = (rows[column] for column in self.columns(name))
            throws = round(float(whole.sum())) // len(whole)
            return metrics.wilson(round(float(part.sum() / whole.sum()) * throws), throws)
        values = self.units(name, rows)[0].mean(axis=0)
        return metrics.interval(values[np.isfinite(values)]) if np.isfinite(values).any() else None

    # Texts

    def text(self, value: float | None) -> str:
        """Text of a value with its unit; "-" for None or NaN."""
        return "-" if value is None or not np.isfinite(value) else self.with_unit(self.number(value))

    def number(self, value: float) -> str:
        """Text of a value [SI] in the figure's unit, without the unit."""
        return f"{self.scale * value:.{self.digits}f}"

    def interval(self, interval: metrics.Interval, sign: str = "") -> str:
        """Text of a value with its 95 % interval and unit."""
        value, low, high = (
            f"{self.scale * number:{sign}.{self.digits}f}" for number in (interval.value, interval.low, interval.high)
        )
        return self.with_unit(f"{value} ({low}..{high})")

    def shown(self, name: str, summary: Mapping[str, Any]) -> str:
        """Text of the figure in a summary, with its interval if there is one."""
        if self.ends is None or summary[name] is None:
            return self.text(summary[name])
        low, high = (summary[end] for end in self.ends)
        if self.kind is share:
            return f"{self.text(summary[name])} ({self.number(low)}..{self.number(high)})"
        return self.interval(metrics.Interval(summary[name], low, high))

    def with_unit(self, text: str) -> str:
        """Text of a figure with its unit, which some figures have not."""
        return f"{text} {self.unit}".rstrip()

    def style(self) -> dict[str, Any]:
        """How the figure is called and written, as JSON values."""
        return {"label": self.label, "unit": self.unit, "scale": self.scale, "digits": self.digits}

    # Differences of two controllers, unit by unit

    def compared(self) -> Self:
        """The figure as a comparison takes it: without a cap the share of the units with a larger figure."""
        if self.cap is not None:
            return self
        words = SIGNS.replace("{label}", self.label)
        return replace(self, label=f"{self.label} (sign)", unit="%", scale=100.0, digits=1, words=words)

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
        amount = self.text(value if low > 0.0 else -value)  # negative only for a mean beyond zero
        words = self.words.format(a=ahead, b=behind, amount=amount, label=self.label, unit=unit)
        return f"{words} ({self.number(least)} to {self.number(most)})"
