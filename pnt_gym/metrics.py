"""What throws are worth: throughput, success, landing error, and paired comparisons.

Pure arrays with one entry per throw. Every interval is a 95 % interval unless asked otherwise. Two
controllers that threw the same objects are compared throw by throw (paired), which removes what the
objects have in common.
"""

from __future__ import annotations

from dataclasses import dataclass
from statistics import NormalDist
from typing import final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.errors import PntGymError
from pnt_gym.planning.arrays import Bools, Floats, Ints

CONFIDENCE = 0.95
RESAMPLES = 4000
_BLOCK = 250  # resamples drawn at once: bounds the memory at 250 x N indices


class MetricError(PntGymError):
    """Throws that a figure cannot be computed from."""


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
    """Where objects crossed the rim plane against the target, in the throw's frame [m]."""

    mean: float
    p95: float
    iqm: float
    """Mean of the middle half of the errors."""
    bias_along: float
    bias_across: float
    spread_along: float
    """Standard deviation about the bias."""
    spread_across: float
    unmeasured: int
    """Throws without a landing; they are left out of the figures above."""


@final
@dataclass(frozen=True)
class Throughput:
    """Picks per minute of one robot doing the throws one after another."""

    attempted: float
    sorted: float
    cycle_time: float
    """Mean [s]."""


def wilson(successes: int, throws: int, confidence: float = CONFIDENCE) -> Interval:
    """Success rate with Wilson's score interval (Wilson 1927), sound near 0 and 1 too.

    Raises:
        MetricError: no throws, or more successes than throws.
    """
    if throws < 1 or not 0 <= successes <= throws:
        raise MetricError(
            f"{successes} successes in {throws} throws: need at least 1 throw and 0 to {throws} successes"
        )
    z = NormalDist().inv_cdf(0.5 + confidence / 2.0)
    rate = successes / throws
    centre = (rate + z**2 / (2 * throws)) / (1.0 + z**2 / throws)
    half = z / (1.0 + z**2 / throws) * np.sqrt(rate * (1.0 - rate) / throws + z**2 / (4 * throws**2))
    # Rounding may leave the interval a hair inside the rate at its ends.
    return Interval(rate, min(rate, max(0.0, float(centre - half))), max(rate, min(1.0, float(centre + half))))


def landing(along: ArrayLike, across: ArrayLike) -> Landing:
    """Landing figures of throws that landed `along` too far and `across` too far left, both (N,) [m].

    Raises:
        MetricError: the arrays differ in shape, or no throw has a finite landing.
    """
    x, y = _rows("along", along), _rows("across", across)
    _same(x, y)
    measured = np.isfinite(x) & np.isfinite(y)
    if not measured.any():
        raise MetricError(f"none of {len(x)} throws has a finite landing")
    unmeasured = int((~measured).sum())
    x, y = x[measured], y[measured]
    error = np.hypot(x, y)
    return Landing(
        mean=float(error.mean()),
        p95=float(np.percentile(error, 95)),
        iqm=interquartile_mean(error),
        bias_along=float(x.mean()),
        bias_across=float(y.mean()),
        spread_along=float(x.std()),
        spread_across=float(y.std()),
        unmeasured=unmeasured,
    )


def interquartile_mean(values: ArrayLike) -> float:
    """Mean of the middle half of the values."""
    rows = np.sort(_rows("values", values))
    cut = len(rows) // 4
    return float(rows[cut : len(rows) - cut].mean())


def throughput(success: ArrayLike, cycle_time: ArrayLike) -> Throughput:
    """Attempted and sorted picks per minute.

    Args:
        success: whether each throw ended in its bin (N,).
        cycle_time: pick to pick, with dwell (N,) [s].

    Raises:
        MetricError: the arrays differ in shape, or a cycle time is not positive and finite.
    """
    done, seconds = _rows("success", success), _rows("cycle_time", cycle_time)
    _same(done, seconds)
    if not (np.isfinite(seconds).all() and (seconds > 0).all()):
        raise MetricError(f"cycle times must be positive and finite; the smallest is {seconds.min()} s")
    total = float(seconds.sum())
    return Throughput(60.0 * len(seconds) / total, 60.0 * float(done.sum()) / total, total / len(seconds))


def purity(landed_in: ArrayLike, meant_for: ArrayLike) -> float | None:
    """Share of the objects in bins that lie in the bin they were meant for; None if no object lies in any.

    Args:
        landed_in: bin each object ended in, -1 for none (N,).
        meant_for: bin it was thrown at (N,).
    """
    ended: Ints = np.asarray(landed_in, dtype=np.int64)
    meant: Ints = np.asarray(meant_for, dtype=np.int64)
    inside: Bools = ended >= 0
    return float((ended == meant)[inside].mean()) if inside.any() else None


def mean_interval(values: ArrayLike, *, seed: int = 0) -> Interval:
    """Mean of values (N,) with its bootstrap percentile interval."""
    rows = _rows("values", values)
    return _percentiles(float(rows.mean()), np.concatenate([rows[i].mean(axis=1) for i in _resamples(len(rows), seed)]))


def paired_mean(a: ArrayLike, b: ArrayLike, *, seed: int = 0) -> Interval:
    """Mean of a - b over throws (N,) of the same objects, with its paired bootstrap interval.

    Throws in which either value is not finite are left out.

    Raises:
        MetricError: the arrays differ in shape.
    """
    x, y = _rows("a", a), _rows("b", b)
    _same(x, y)
    difference = (x - y)[np.isfinite(x) & np.isfinite(y)]
    return mean_interval(difference, seed=seed)


def paired_rate(
    success_a: ArrayLike, time_a: ArrayLike, success_b: ArrayLike, time_b: ArrayLike, *, seed: int = 0
) -> Interval:
    """Sorted picks per minute of a less those of b, over throws (N,) of the same objects.

    The rates are ratios of sums, so whole throws are drawn again, with both controllers' success and time.

    Args:
        success_a: whether a's throws ended in their bin; a share where several seeds are averaged.
        time_a: a's cycle times [s].
        success_b: likewise of b.
        time_b: likewise of b [s].
        seed: of the bootstrap.

    Raises:
        MetricError: the arrays differ in shape.
    """
    rows = [_rows("throws", v) for v in (success_a, time_a, success_b, time_b)]
    for other in rows[1:]:
        _same(rows[0], other)
    sa, ta, sb, tb = rows

    def rate(index: Ints | slice) -> Floats:
        return 60.0 * (sa[index].sum(-1) / ta[index].sum(-1) - sb[index].sum(-1) / tb[index].sum(-1))

    drawn = np.concatenate([rate(index) for index in _resamples(len(sa), seed)])
    return _percentiles(float(rate(slice(None))), drawn)


def _resamples(count: int, seed: int) -> list[Ints]:
    """Blocks of bootstrap indices (B, count)."""
    random = np.random.default_rng(seed)
    blocks = RESAMPLES // _BLOCK
    return [random.integers(count, size=(_BLOCK, count)) for _ in range(blocks)]


def _percentiles(value: float, drawn: Floats) -> Interval:
    tail = 50.0 * (1.0 - CONFIDENCE)
    low, high = np.percentile(drawn, [tail, 100.0 - tail])
    return Interval(value, float(low), float(high))


def _rows(name: str, values: ArrayLike) -> Floats:
    rows = np.asarray(values, dtype=np.float64)
    if rows.ndim != 1 or rows.size == 0:
        raise MetricError(f"{name} must hold one number per throw and at least one throw, got shape {rows.shape}")
    return rows


def _same(a: Floats, b: Floats) -> None:
    if len(a) != len(b):
        raise MetricError(f"paired arrays must be of one length, got {len(a)} and {len(b)}")
