"""Statistics of runs, by cases that were computed by hand."""

import numpy as np
import pytest

from agents.report.pays import crossover_grid, improvement_grid, profiles_figure
from agents.report.runs_compared import improvement_interval, performance_profile, probability_of_improvement


@pytest.mark.parametrize(
    ("mine", "theirs", "expected"),
    [
        ([1.0, 2.0], [3.0, 4.0], 1.0),
        ([3.0, 4.0], [1.0, 2.0], 0.0),
        ([1.0, 3.0], [2.0, 4.0], 0.75),  # of four pairs 1<2, 1<4, 3<4
        ([1.0, 1.0, 1.0], [1.0], 0.5),  # ties count half
        ([1.0, 2.0, 3.0], [2.0, 5.0], (0.5 + 1.0 + 1.0 + 1.0 + 1.0) / 6),  # 2=2 half; 3>2 none
    ],
)
def test_probability_of_improvement_counts_pairs(mine, theirs, expected) -> None:
    assert probability_of_improvement(mine, theirs) == pytest.approx(expected)
    assert probability_of_improvement(theirs, mine) == pytest.approx(1.0 - expected)


def test_its_interval_covers_half_for_equal_learners_and_excludes_it_for_learners_that_differ() -> None:
    random = np.random.default_rng(3)
    equal = improvement_interval(random.normal(size=30).tolist(), random.normal(size=30).tolist())
    better = improvement_interval(random.normal(size=30).tolist(), random.normal(2.0, size=30).tolist())
    assert equal.low < 0.5 < equal.high
    assert 0.5 < better.low < better.value <= better.high <= 1.0


def test_a_profile_is_the_share_of_runs_below_a_bound() -> None:
    assert performance_profile([0.1, 0.2, 0.2, 0.4], [0.1, 0.2, 0.3, 1.0]).tolist() == [0.0, 0.25, 0.75, 1.0]


def _gain(effect: str, dial: float, low: float, high: float) -> dict:
    interval = {"value": (low + high) / 2, "low": low, "high": high}
    return {"effect": effect, "controller": "ridge", "mismatch": dial, "landing_error_m": interval}


def test_learning_pays_from_where_all_later_gains_are_clear() -> None:
    rows = [_gain("air", 1.0, -0.03, -0.02), _gain("air", 0.0, -0.02, -0.01), _gain("air", 0.5, -0.01, 0.01)]
    rows += [_gain("none", dial, -0.001, 0.001) for dial in (0.0, 1.0)]
    cells = {row[0]: row[2:] for row in crossover_grid({"rows": rows}).rows}
    assert cells["air"] == ["1", "25.0 mm (20.0..30.0)"]
    assert cells["none"][0] == "-"


def test_learners_are_compared_after_the_most_throws() -> None:
    names = {"ridge": (0.02, 0.03), "MLP": (0.01, 0.02)}
    rows = [
        {"part": "learners", "controller": name, "throws": throws, "landing_error_mean_m": error, "seed": seed}
        for name, errors in names.items()
        for seed, error in enumerate(errors)
        for throws in (10, 100)
    ]
    (row,) = improvement_grid({"rows": rows}).rows
    assert row[:3] == ["MLP", "2", "15.0 mm"]
    assert row[3].startswith("88 %")  # 3.5 of 4 pairs
    assert profiles_figure({"rows": rows}).axes[0].get_title() == "after 100 throws"
