"""Statistics of runs, by cases that were computed by hand."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agents.report import profiles
from agents.report.pays import crossover_grid, improvement_grid, profiles_figure
from agents.report.profiles import probability_of_improvement, profile_band
from agents.report.questions import QUESTIONS

RLIABLE = {
    "improvement": 0.5666666666666667,
    "improvement_ends": (0.33333333, 0.78888889),
    "profile": [0.94444444, 0.44444444, 0.11111111],
    "profile_ends": [[0.83333333, 0.22222222, 0.0], [1.0, 0.66666667, 0.27777778]],
}
"""Of rliable 1.2.0 with arch 7.2.0 and pandas 2: `metrics.probability_of_improvement`, `library.get_interval_estimates`
of it with 5,000 resamples, and `library.create_performance_profile` with 50,000."""


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


def _gain(effect: str, dial: float, low: float, high: float, pace: float = 1.0) -> dict:
    interval = {"value": (low + high) / 2, "low": low, "high": high}
    return {
        "part": "mismatch", "effect": effect, "controller": "ridge", "mismatch": dial, "landing_error_m": interval,
        "sorted_per_min": {"value": pace, "low": pace - 0.5, "high": pace + 0.5}, "analytic_m": 0.05, "learned_m": 0.02,
    }  # fmt: skip


def test_learning_pays_from_where_all_later_gains_are_clear() -> None:
    rows = [_gain("air", 1.0, -0.03, -0.02), _gain("air", 0.0, -0.02, -0.01), _gain("air", 0.5, -0.01, 0.01)]
    rows += [_gain("none", dial, -0.001, 0.001, 0.0) for dial in (0.0, 1.0)]
    cells = {row[0]: row[2:] for row in crossover_grid({"rows": rows}).rows}
    assert cells["air"] == ["1", "0", "25.0 mm (20.0..30.0)"]
    assert cells["none"][:2] == ["-", "-"]


def test_the_sentence_of_the_mismatch_names_the_effects_where_learning_pays_first_and_last() -> None:
    rows = [_gain("air", dial, -0.02, -0.01, pace) for dial, pace in ((0.0, 0.1), (0.5, 3.0), (1.0, 4.0))]
    rows += [_gain("spin", dial, -0.02, -0.01, pace) for dial, pace in ((0.0, 0.1), (0.5, 0.2), (1.0, 4.0))]
    rows += [_gain("all together", dial, -0.02, -0.01, 5.0) for dial in (0.5, 1.0)]
    text = _answer("mismatch", rows)
    assert text is not None
    assert "depends on the effect: it is 0.5 at best (air) and 1 at worst (spin)" in text
    assert "At a mismatch of 1 with all effects together, the planner lands 50.0 mm off, and ridge after" in text
    assert "after 1,000 flights 20.0 mm" in text


def _answer(name: str, rows: list[dict[str, Any]]) -> str | None:
    """The answer to a question from the rows of the study that has its name."""
    (question,) = (question for question in QUESTIONS if question.name == name)
    return question.answer_from({name: {"rows": rows}}, Path())


def _curve(part: str, label: str, throws: int, error: float) -> dict:
    return {"part": part, "controller": label, "throws": throws, "landing_error_mean_m": error}


def test_the_sentence_of_the_curves_names_who_is_near_first() -> None:
    rows = [_curve("fixed", "analytic", 0, 0.05), _curve("fixed", "floor", 20000, 0.010)]
    rows += [_curve("learners", "ridge", throws, error) for throws, error in ((10, 0.03), (100, 0.014), (1000, 0.012))]
    rows += [_curve("learners", "MLP", throws, error) for throws, error in ((10, 0.04), (100, 0.013), (1000, 0.0101))]
    text = _answer("curves", rows)
    others = (
        " Of all that learn without physics, ridge is nearest after 10 throws, with 30.0 mm, and MLP "
        "comes within 1.25 times the floor of 10.0 mm first, with 10.1 mm after 1,000 throws."
    )
    assert text == f"The planner lands 50.0 mm off.{others}"
    fitted = [_curve("learners", "fitted planner", throws, error) for throws, error in ((1, 0.012), (10, 0.011))]
    assert _answer("curves", rows + fitted) == (
        f"The planner lands 50.0 mm off, and fitted to 10 throws 11.0 mm.{others}"
    )
    rows += [_curve("without a planner", "SAC alone", throws, error) for throws, error in ((300, 0.3), (3000, 0.09))]
    assert _answer("curves", rows) == (
        f"{text} SAC alone lands 90.0 mm off after 3,000 throws, farther than the planner, which learns nothing."
    )


def test_levels_count_alike_and_are_resampled_by_themselves() -> None:
    """Of two levels, one learner is always better on the first and always worse on the second."""
    first, second = [[1.0, 9.0], [2.0, 9.5]], [[3.0, 5.0], [4.0, 6.0], [5.0, 7.0]]
    assert probability_of_improvement(first, second) == 0.5
    interval = profiles.interval(first, second)
    assert (interval.low, interval.high) == (0.5, 0.5)
    assert profiles.profile(first, [0.0, 1.5, 5.0, 9.2, 10.0]).tolist() == [0.0, 0.25, 0.5, 0.75, 1.0]
    low, high = profile_band(first, [5.0, 1.5])
    assert (low[0], high[0]) == (0.5, 0.5), "each level has as many runs as before"
    assert (low[1], high[1]) == (0.0, 0.5)


def test_formulas_agree_with_rliable() -> None:
    """What rliable 1.2.0 gives for the same scores, of which larger ones are better there."""
    random = np.random.default_rng(7)
    first, second = random.normal(size=(6, 3)), random.normal(0.4, size=(5, 3))
    assert probability_of_improvement(-first, -second) == pytest.approx(RLIABLE["improvement"])
    bounds = np.array([-1.0, 0.0, 0.5])
    assert profiles.profile(-first, -bounds).tolist() == pytest.approx(RLIABLE["profile"])
    interval, (low, high) = profiles.interval(-first, -second), profile_band(-first, -bounds)
    # Bootstraps with other random numbers: ends agree to a step of a share, and to two points.
    assert (interval.low, interval.high) == pytest.approx(RLIABLE["improvement_ends"], abs=0.02)
    np.testing.assert_allclose([low, high], RLIABLE["profile_ends"], atol=0.06)


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
