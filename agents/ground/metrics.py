"""Figures of throws: throughput, success, landing error, and paired comparisons.

All arrays have one entry per throw. Every interval is a 95 % interval. Two controllers that threw the same objects are
compared throw by throw (paired), which removes the variance that both share through the objects.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from statistics import NormalDist
from typing import final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pnt_gym.arrays import Floats
from pnt_gym.errors import PntGymError

CONFIDENCE = 0.95
RESAMPLES = 4000
NEAR = 0.030
"""Largest error of a near landing [m]."""
_BLOCK = 250  # resamples at once: bounds the memory at 250 x N numbers


class MetricError(PntGymError):
    """Throws from which a figure cannot be computed."""


@final
@dataclass(frozen=True)
class Interval:
    """An estimate with its confidence interval."""

    value: float
    low: float
    high: float

    @property
    def excludes_zero(self) -> bool:
        """Whether zero lies outside the interval."""
        return self.low > 0.0 or self.high < 0.0


@final
@dataclass(frozen=True)
class Landing:
    """Landing errors of objects: distances from their targets [m]."""

    mean: float
    p95: float
    iqm: float
    """Mean of the middle half of the errors."""
    near: float
    """Share of the measured landings that are closer than `NEAR`."""
    unmeasured: int
    """Number of throws without a landing; the figures above leave these throws out."""


@final
@dataclass(frozen=True)
class Throughput:
    """Picks per minute of one robot doing the throws one after another."""

    attempted: float
    sorted: float
    cycle_time: float
    """Mean [s]."""


@final
@dataclass(frozen=True)
class Purity:
    """Purity of bins: share of the objects in a bin that belong there; NaN for empty bins."""

    share: float
    """Purity over all bins."""
    by_bin: tuple[float, ...]
    """Purity of each bin."""


def purity(ended_in: ArrayLike, belongs: ArrayLike, bins: int = 0) -> Purity:
    """Purity of the bins after throws; an object that missed its own bin counts in the bin where it fell.

    Args:
        ended_in: index of the bin in which each object lies, -1 for none (N,).
        belongs: whether that bin takes objects of this kind (N,).
        bins: number of bins in `by_bin`.
    """
    where, right = _columns(ended_in=ended_in, belongs=belongs)
    counts, matches = np.bincount(where[where >= 0].astype(np.int64), minlength=bins), right[where >= 0]
    good = np.bincount(where[where >= 0].astype(np.int64), weights=matches, minlength=bins)
    shares = [float(g / h) if h else np.nan for g, h in zip(good, counts, strict=True)]
    return Purity(float(matches.mean()) if len(matches) else np.nan, tuple(shares[:bins]))


def recovery(sorted_: ArrayLike, passed: ArrayLike) -> float:
    """Share of all objects on the belt that were sorted: the objects of all throws, and the objects passed before them.

    Args:
        sorted_: whether the object of each throw, or of a pick that failed, was sorted (N,).
        passed: number of objects that left unpicked since the previous throw (N,).
    """
    successes, gone = _columns(sorted_=sorted_, passed=passed)
    return float(successes.sum() / (len(successes) + gone.sum()))


def wilson(successes: int, throws: int) -> Interval:
    """Success rate with Wilson's score interval (Wilson 1927), which is valid near 0 and 1 too.

    Raises:
        MetricError: no throws, or more successes than throws.
    """
    if throws < 1 or not 0 <= successes <= throws:
        raise MetricError(
            f"{successes} successes in {throws} throws: need at least 1 throw and 0 to {throws} successes"
        )
    z = NormalDist().inv_cdf(0.5 + CONFIDENCE / 2.0)
    rate = successes / throws
    # The interval holds all rates p with |rate - p| <= z sqrt(p (1 - p) / throws), a quadratic in p.
    centre = (rate + z**2 / (2 * throws)) / (1.0 + z**2 / throws)
    half = z / (1.0 + z**2 / throws) * np.sqrt(rate * (1.0 - rate) / throws + z**2 / (4 * throws**2))
    # Rounding may put an end of the interval slightly beyond the rate at 0 and 1.
    return Interval(rate, min(rate, max(0.0, float(centre - half))), max(rate, min(1.0, float(centre + half))))


def landing(error: ArrayLike) -> Landing:
    """Figures of landing errors (N,) [m], NaN where a landing was not measured.

    Raises:
        MetricError: no throw has a finite landing.
    """
    (rows,) = _columns(error=error)
    measured = rows[np.isfinite(rows)]
    if measured.size == 0:
        raise MetricError(f"none of {len(rows)} throws has a finite landing")
    return Landing(
        mean=float(measured.mean()),
        p95=float(np.percentile(measured, 95)),
        iqm=interquartile_mean(measured),
        near=float((measured < NEAR).mean()),
        unmeasured=len(rows) - len(measured),
    )


def interquartile_mean(values: ArrayLike) -> float:
    """Mean of the middle half of the values."""
    (column,) = _columns(values=values)
    rows = np.sort(column)
    cut = len(rows) // 4
    return float(rows[cut : len(rows) - cut].mean())


def mean(values: ArrayLike) -> float:
    """Mean of the finite values; NaN where there is none, as before the first successful pick."""
    numbers = np.asarray(values)
    return float(numbers[np.isfinite(numbers)].mean()) if np.isfinite(numbers).any() else np.nan


def throughput(success: ArrayLike, cycle_time: ArrayLike) -> Throughput:
    """Attempted and sorted picks per minute.

    Args:
        success: whether each object ended in its bin (N,).
        cycle_time: time from pick to pick, with dwell (N,) [s].

    Raises:
        MetricError: the arrays differ in shape, or a cycle time is not positive and finite.
    """
    successes, seconds = _columns(success=success, cycle_time=cycle_time)
    if not (np.isfinite(seconds).all() and (seconds > 0).all()):
        raise MetricError(f"cycle times must be positive and finite; the smallest is {seconds.min()} s")
    total = float(seconds.sum())
    return Throughput(60.0 * len(seconds) / total, 60.0 * float(successes.sum()) / total, total / len(seconds))


def interval(values: ArrayLike) -> Interval:
    """Mean of values (N,) with its bootstrap percentile interval."""
    (rows,) = _columns(values=values)
    return _interval(float(rows.mean()), _sample(rows) / len(rows))


def difference(a: ArrayLike, b: ArrayLike) -> Interval:
    """Mean of a - b over throws (N,) of the same objects, with its paired bootstrap interval.

    Throws in which either value is not finite are left out.

    Raises:
        MetricError: the arrays differ in shape.
    """
    x, y = _columns(a=a, b=b)
    return interval((x - y)[np.isfinite(x) & np.isfinite(y)])


def rate_difference(success_a: ArrayLike, time_a: ArrayLike, success_b: ArrayLike, time_b: ArrayLike) -> Interval:
    """Sorted picks per minute of a minus those of b, over throws (N,) of the same objects.

    The rates are ratios of sums, so the bootstrap resamples whole throws, with success and time of both controllers.

    Args:
        success_a: whether a's throws ended in their bin; a share where several seeds are averaged.
        time_a: a's cycle times [s].
        success_b: likewise of b.
        time_b: likewise of b [s].

    Raises:
        MetricError: the arrays differ in shape.
    """
    columns = np.stack(_columns(success_a=success_a, time_a=time_a, success_b=success_b, time_b=time_b), axis=1)

    def difference(sums: Floats) -> Floats:
        # Picks per second to picks per minute.
        return 60.0 * (_ratio(sums[..., :2]) - _ratio(sums[..., 2:]))

    return _interval(float(difference(columns.sum(axis=0))), difference(_sample(columns)))


def rate(events: ArrayLike, amounts: ArrayLike, scale: float = 60.0) -> Interval:
    """Ratio of sums over parts (N,), such as shifts, with its bootstrap interval: sorted picks per minute by default.

    Args:
        events: what is counted in each part, such as sorted objects.
        amounts: what it is divided by, such as seconds.
        scale: factor of the ratio.

    Raises:
        MetricError: the arrays differ in shape.
    """
    columns = np.stack(_columns(events=events, amounts=amounts), axis=1)
    return _interval(float(scale * _ratio(columns.sum(axis=0))), scale * _ratio(_sample(columns)))


def share_won(own: ArrayLike, least: ArrayLike, most: ArrayLike) -> Interval:
    """Share of the way from a least to a most rate that a controller goes, with its paired bootstrap interval.

    Args:
        own: objects sorted and seconds of parts, such as shifts (N, 2).
        least: the same of another controller in the same parts (N, 2).
        most: the same of a third one (N, 2).

    Raises:
        MetricError: the arrays differ in shape.
    """
    parts = [np.asarray(part, dtype=np.float64) for part in (own, least, most)]
    if len({part.shape for part in parts}) > 1 or parts[0].ndim != 2 or parts[0].shape[1] != 2 or len(parts[0]) == 0:
        raise MetricError(f"paired parts must all be (N, 2), got {', '.join(str(part.shape) for part in parts)}")
    columns = np.concatenate(parts, axis=1)

    def share(sums: Floats) -> Floats:
        of_own, of_least, of_most = (_ratio(sums[..., k : k + 2]) for k in (0, 2, 4))
        return (of_own - of_least) / (of_most - of_least)

    return _interval(float(share(columns.sum(axis=0))), share(_sample(columns)))


def _ratio(sums: Floats) -> Floats:
    """Ratios of the first to the second of two sums (..., 2)."""
    return sums[..., 0] / sums[..., 1]


def _sample(rows: Floats) -> Floats:
    """Sums over the rows (N, ...) of each bootstrap resample (RESAMPLES, ...)."""
    counts = _resample_counts(len(rows))
    blocks = range(0, RESAMPLES, _BLOCK)
    return np.concatenate([counts[first : first + _BLOCK].astype(np.float64) @ rows for first in blocks])


@lru_cache(maxsize=8)
def _resample_counts(count: int) -> NDArray[np.uint16]:
    """How often each bootstrap resample draws each of `count` rows (RESAMPLES, count); the same for all figures."""
    random = np.random.default_rng(0)
    first_cells = count * np.arange(_BLOCK)[:, None]
    counts = np.empty((RESAMPLES, count), dtype=np.uint16)
    for first in range(0, RESAMPLES, _BLOCK):
        cells = random.integers(count, size=(_BLOCK, count))
        cells += first_cells
        counts[first : first + _BLOCK] = np.bincount(cells.ravel(), minlength=_BLOCK * count).reshape(_BLOCK, count)
    return counts


def _interval(value: float, drawn: Floats) -> Interval:
    tail = 50.0 * (1.0 - CONFIDENCE)
    low, high = np.percentile(drawn, [tail, 100.0 - tail])
    return Interval(value, float(low), float(high))


def _columns(**values: ArrayLike) -> list[Floats]:
    """Arrays (N,) of floats from values by name, after checking that all have the same length."""
    columns: list[Floats] = []
    for name, column_values in values.items():
        column = np.asarray(column_values, dtype=np.float64)
        if column.ndim != 1 or column.size == 0:
            raise MetricError(f"{name} must hold one number per throw and at least one throw, got shape {column.shape}")
        columns.append(column)
        if len(column) != len(columns[0]):
            raise MetricError(f"paired arrays must be of one length, got {len(columns[0])} and {len(column)}")
    return columns
