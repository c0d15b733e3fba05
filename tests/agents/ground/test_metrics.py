"""The figures behind every claim, against scipy and against cases with a known answer."""

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from agents.ground import metrics
from agents.ground.metrics import MetricError


@given(st.integers(1, 2000), st.floats(0, 1))
def test_wilson_equals_scipy(throws: int, share: float) -> None:
    successes = int(share * throws)
    ours = metrics.wilson(successes, throws)
    theirs = stats.binomtest(successes, throws).proportion_ci(0.95, method="wilson")
    assert ours.low == pytest.approx(theirs.low, abs=1e-12)
    assert ours.high == pytest.approx(theirs.high, abs=1e-12)
    assert 0.0 <= ours.low <= ours.value <= ours.high <= 1.0


@pytest.mark.parametrize(
    ("figure", "said"),
    [
        (lambda: metrics.wilson(0, 0), "at least 1 throw"),
        (lambda: metrics.wilson(5, 3), "5 successes in 3 throws"),
        (lambda: metrics.landing([np.nan]), "finite landing"),
        (lambda: metrics.throughput([True], [0.0]), "positive"),
        (lambda: metrics.difference([1.0, 2.0], [1.0]), "one length"),
        (lambda: metrics.interquartile_mean([]), "at least one throw"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_what_cannot_be_counted_is_refused(figure: Callable[[], object], said: str) -> None:
    with pytest.raises(MetricError, match=said):
        figure()


def test_landing_figures_are_those_of_the_errors() -> None:
    error = np.abs(0.03 + 0.01 * np.random.default_rng(1).standard_normal(50_000))
    found = metrics.landing(error)
    assert found.mean == pytest.approx(error.mean())
    assert found.p95 == pytest.approx(np.sort(error)[int(0.95 * 50_000)], rel=1e-3)


def test_near_is_closer_than_thirty_millimetres() -> None:
    """A share of the landings, however many throws have none; exactly 30 mm is not near."""
    assert metrics.landing([0.0, 0.0299, 0.030, 0.0301, 0.5]).near == pytest.approx(2 / 5)
    assert metrics.landing([0.01, np.nan, 0.2, np.inf]).near == pytest.approx(1 / 2)
    assert (metrics.landing([0.029]).near, metrics.landing([0.031]).near) == (1.0, 0.0)


@given(st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=200))
def test_interquartile_mean_equals_scipy(values: list[float]) -> None:
    assert metrics.interquartile_mean(values) == pytest.approx(stats.trim_mean(values, 0.25), abs=1e-9)


@given(st.lists(st.tuples(st.integers(-1, 3), st.booleans()), min_size=1, max_size=60))
def test_purity_counts_object_by_object(found: list[tuple[int, bool]]) -> None:
    ended_in, belongs = map(list, zip(*found, strict=True))
    judged = metrics.purity(ended_in, belongs, 3)
    everything = [own for place, own in found if place >= 0]
    assert judged.share == pytest.approx(sum(everything) / len(everything) if everything else np.nan, nan_ok=True)
    for place, share in enumerate(judged.by_bin):
        held = [own for at, own in found if at == place]
        assert share == pytest.approx(sum(held) / len(held) if held else np.nan, nan_ok=True)


def test_paired_mean_equals_scipy_bootstrap() -> None:
    random = np.random.default_rng(2)
    base = random.gamma(2.0, 0.01, 400)
    a, b = base + 0.001 * random.standard_normal(400), 1.3 * base
    ours = metrics.difference(a, b)
    theirs = stats.bootstrap(
        (a, b),
        lambda x, y, axis: (x - y).mean(axis=axis),
        paired=True,
        vectorized=True,
        n_resamples=4000,
        method="percentile",
        rng=np.random.default_rng(3),
    ).confidence_interval
    width = theirs.high - theirs.low
    assert ours.low == pytest.approx(theirs.low, abs=0.1 * width)
    assert ours.high == pytest.approx(theirs.high, abs=0.1 * width)
    assert ours.excludes_zero


def test_paired_rate_is_the_difference_of_the_rates() -> None:
    random = np.random.default_rng(5)
    sa, sb = random.random(600) < 0.95, random.random(600) < 0.70
    ta, tb = random.uniform(0.5, 0.7, 600), random.uniform(0.5, 0.7, 600)
    found = metrics.rate_difference(sa, ta, sb, tb)
    expected = metrics.throughput(sa, ta).sorted - metrics.throughput(sb, tb).sorted
    assert found.value == pytest.approx(expected)
    assert found.low < expected < found.high
    assert found.excludes_zero


def test_a_share_that_is_won_lies_between_the_rates_and_is_paired() -> None:
    random = np.random.default_rng(6)
    hard, seconds = random.uniform(-8.0, 8.0, 200), np.full(200, 45.0)  # some shifts are hard for everybody
    least, own, most = (np.stack([mean + hard, seconds], axis=1) for mean in (25.0, 34.0, 35.0))
    found = metrics.share_won(own, least, most)
    assert found.value == pytest.approx(0.9)
    assert found.high - found.low < 1e-6  # what all share is no doubt
    assert metrics.share_won(least, least, most).value == pytest.approx(0.0)
    assert metrics.share_won(most, least, most).value == pytest.approx(1.0)
    assert metrics.rate(*own.T).value == pytest.approx(60.0 * own[:, 0].sum() / own[:, 1].sum())
    assert metrics.rate(*own.T).high - metrics.rate(*own.T).low > 1.0
    with pytest.raises(metrics.MetricError, match=r"must all be \(N, 2\)"):
        metrics.share_won(own, least[:9], most)


def test_interval_covers_the_truth_as_often_as_it_says() -> None:
    random = np.random.default_rng(6)
    hits = 0
    for _ in range(200):
        found = metrics.interval(random.exponential(1.0, 80))
        hits += found.low <= 1.0 <= found.high
    # 95 % of 200 is 190; the percentile interval of a skewed sample of 80 covers a little less.
    assert 176 <= hits <= 199
