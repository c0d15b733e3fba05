"""Intervals that may be looked at after every observation: against an oracle, over many runs, and at the bounds."""

import numpy as np
import pytest

from agents.judging.sequential import FRACTIONS, WEIGHTS, ConfidenceSequence
from benchmarks.studies.sequential import log_capital_path


def capital(values: np.ndarray, bound: float, mean: float) -> float:
    """What a gambler holds who bets each fraction, one observation after the other."""
    total = 0.0
    for fraction, weight in zip(FRACTIONS, WEIGHTS, strict=True):
        held = weight
        for value in values:
            held *= 1.0 - fraction + fraction * (bound + value) / (bound + mean)
        total += held
    return total


def test_limits_are_the_means_against_which_the_capital_suffices() -> None:
    values = np.random.default_rng(0).uniform(-1.0, 2.0, 60)
    interval = ConfidenceSequence(2.0, 0.05)
    interval.update(values, 60)
    assert (interval.low_since, interval.high_since, interval.outside) == (60, 60, False)
    assert capital(values, 2.0, interval.low) == pytest.approx(40.0)
    assert capital(-values, 2.0, -interval.high) == pytest.approx(40.0)
    assert interval.low < values.mean() == interval.value < interval.high
    assert np.exp(log_capital_path(values[None], 2.0)[0, -1]) == pytest.approx(capital(values, 2.0, 0.0))


def test_an_interval_only_narrows_and_mirrors() -> None:
    random = np.random.default_rng(1)
    interval, mirror = ConfidenceSequence(1.0, 0.05), ConfidenceSequence(1.0, 0.05)
    ends = [(interval.low, interval.high)]
    for block in range(20):
        values = random.uniform(-0.5, 1.0, 16)
        interval.update(values, block)
        mirror.update(-values, block)
        ends.append((interval.low, interval.high))
        assert (mirror.low, mirror.high) == pytest.approx((-interval.high, -interval.low))
    low, high = np.array(ends).T
    assert (np.diff(low) >= 0.0).all()
    assert (np.diff(high) <= 0.0).all()
    assert 0.0 < low[-1] < 0.25 < high[-1]
    assert high[-1] - low[-1] < 0.3


def test_equal_controllers_are_hardly_ever_told_apart() -> None:
    """Skewed differences of mean zero, looked at after each of 500 throws, 4,000 times."""
    random = np.random.default_rng(2)
    values = np.where(random.random((4000, 500)) < 0.1, 0.9, -0.1)
    paths = [log_capital_path(side * values, 1.0) for side in (1.0, -1.0)]
    ever = np.any([path.max(axis=1) >= np.log(2.0 / 0.05) for path in paths], axis=0)
    assert 0.0 < ever.mean() < 0.05


@pytest.mark.parametrize("value", [-1.0, 0.0, 1.0])
def test_observations_that_never_differ(value: float) -> None:
    interval = ConfidenceSequence(1.0, 0.05)
    interval.update(np.full(200, value), 200)
    assert not interval.outside
    assert interval.low <= value <= interval.high
    assert interval.high - interval.low < 0.06
    assert interval.excludes_zero == (value != 0.0)
    assert interval.is_within(0.05) == (value == 0.0)


def test_without_observations_all_is_possible() -> None:
    interval = ConfidenceSequence(3.0, 0.05)
    interval.update(np.zeros(0), 5)
    ends = {"low": -3.0, "high": 3.0, "excludes_zero": False, "outside": False, "low_since": 0, "high_since": 0}
    assert interval.as_json() == {"value": None, **ends, "count": 0}


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_mean_that_later_observations_move_out_is_told_as_it_is(side: float) -> None:
    """The limit that the first 200 observations set stays, and the mean lies beyond it."""
    interval = ConfidenceSequence(1.0, 0.05)
    interval.update(np.zeros(200), 7)
    low, high = interval.low, interval.high
    interval.update(np.full(20, side), 8)
    assert interval.value == pytest.approx(side * 20 / 220)
    assert interval.outside
    assert (interval.high_since if side > 0.0 else interval.low_since) == 7
    assert (interval.high == high) if side > 0.0 else (interval.low == low)


def test_settled_means_lie_farther_from_zero_than_the_truth() -> None:
    """Comparisons of a true mean of 0.05, each stopped at its first look at which zero is left out."""
    values = np.random.default_rng(3).normal(0.05, 0.1, (400, 600)).clip(-1.0, 1.0)
    crossed = log_capital_path(values, 1.0) >= np.log(2.0 / 0.05)
    assert crossed.any(axis=1).all()
    means = [row[: end + 1].mean() for row, end in zip(values, crossed.argmax(axis=1), strict=True)]
    assert np.mean(means) - 2.0 * np.std(means) / 20.0 > 0.05
