"""Sequential comparisons: the same blocks for every controller, stopped as soon as the order is settled."""

from contextlib import closing
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from agents.controllers.own import Policy
from agents.ground.cli import UsageError
from agents.ground.environments import core_of, make_vector, stream_seed
from agents.judging import trials
from agents.judging.comparison import EARLY, Comparison, Rules, compare
from agents.judging.figures import Figure
from agents.judging.record import Record
from agents.judging.throw_record import ThrowRecord, depend, run_length
from agents.judging.trial import Trial
from agents.judging.trials import open_trial

SMALL = {"level": "waste", "num_envs": 8}


def planner(observations: np.ndarray) -> np.ndarray:
    """The planner's own throw."""
    return np.zeros((len(observations), 2))


def far(observations: np.ndarray) -> np.ndarray:
    """A throw that is too long by a constant."""
    return np.full((len(observations), 2), 0.3)


def near(observations: np.ndarray) -> np.ndarray:
    """A throw that is hardly corrected."""
    return np.full((len(observations), 2), 1e-4)


def test_a_clear_difference_is_settled_early() -> None:
    report = compare(planner, "mlp", "ToyThrow-v0", **SMALL)
    (pair,) = report["pairs"]
    error = pair["figures"]["landing_error_m"]
    assert (report["settled"], pair["settled"]) == (True, report["count"])
    assert 0 < report["count"] < report["budget"] == 1000
    assert 0.0 < error["low"] <= error["value"] <= error["high"]
    assert report["practice"] == {"planner": 0, "mlp": 120}
    (sentence,) = report["sentences"]
    assert sentence.startswith(f"mlp lands {1000 * error['value']:.1f} mm closer than planner (")
    assert sentence.endswith(f"settled after {report['count']} throws")
    assert [entry[0] for entry in pair["trace"]] == list(range(8, report["count"] + 1, 8))
    assert not error["outside"]
    assert error["low_since"] == report["count"]
    assert report["notes"] == [EARLY]
    assert pair["trace"][-1][1:] == [error["value"], error["low"], error["high"]]


def test_controllers_throw_the_same_blocks_which_no_evaluation_sees() -> None:
    seen: dict[str, list[np.ndarray]] = {"a": [], "b": []}

    def watch(name: str) -> Policy:
        def act(features: np.ndarray) -> np.ndarray:
            seen[name].append(features)
            return np.zeros((len(features), 2))

        return Policy(act, name)

    report = compare(watch("a"), watch("b"), "ToyThrow-v0", budget=40, seed=3, **SMALL)
    a, b = np.array(seen["a"]), np.array(seen["b"])
    np.testing.assert_array_equal(a, b)
    assert len(np.unique(a[:, :, 0])) == a[:, :, 0].size == 40
    with closing(open_trial("ToyThrow-v0", "waste", 8, 1)) as trial:
        trial.run(watch("a"), 8, stream_seed("compare", 3, 1))
        np.testing.assert_array_equal(seen["a"][-1], a[1])
        trial.run(watch("a"), 40, 3)
    assert not np.isin(np.array(seen["a"][-5:])[:, :, 0], a[:, :, 0]).any()
    figures = report["pairs"][0]["figures"]
    assert all(figure["value"] == 0.0 and figure["count"] == 40 for figure in figures.values())
    assert not report["settled"]
    assert report["notes"] == []
    assert report["sentences"][0].startswith(
        "not settled after 40 throws: landing error of a minus that of b is 0.0 mm"
    )


def test_a_difference_below_the_margin_is_settled_as_such() -> None:
    report = compare(planner, near, "ToyThrow-v0", margin=5.0, **SMALL)
    (pair,) = report["pairs"]
    assert pair["within_margin"]
    assert pair["settled"] == report["count"] < 1000
    assert "planner and near differ by less than the margin of 5.0 mm in landing error" in report["sentences"][0]


def test_three_controllers_make_three_pairs_with_wider_intervals() -> None:
    two = compare(planner, far, "ToyThrow-v0", budget=16, **SMALL)
    three = compare(planner, far, "ToyThrow-v0", budget=16, others=[near], **SMALL)
    assert [(pair["a"], pair["b"]) for pair in three["pairs"]] == [
        ("planner", "far"),
        ("planner", "near"),
        ("far", "near"),
    ]
    alone, among = (report["pairs"][0]["figures"]["landing_error_m"] for report in (two, three))
    assert alone["value"] == among["value"]
    assert among["low"] < alone["low"] < alone["high"] < among["high"]


def test_fewer_figures_narrow_the_interval() -> None:
    reports = [
        compare(planner, near, "ToyThrow-v0", budget=16, figures=names, **SMALL) for names in (None, ["success"])
    ]
    all_three, alone = (report["pairs"][0]["figures"]["success"] for report in reports)
    assert alone["high"] - alone["low"] < all_three["high"] - all_three["low"]
    assert list(reports[1]["figures"]) == ["success"]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"margin": -1.0}, "--margin is -1; it must be from 0 to below the cap of 100 mm"),
        ({"margin": 60.0, "cap": 50.0}, "--margin is 60; it must be from 0 to below the cap of 50 mm"),
        ({"cap": 0.0}, "--cap is 0; it must be a number above 0"),
        ({"cap": "wide"}, "cap is 'wide': input should be a valid number"),
        ({"budget": 0}, "--budget is 0; it must be at least 1"),
        ({"seed": 1.5}, "--seed is 1.5; it must be a whole number, at least 0"),
        ({"figures": "success"}, "figures is 'success': input should be a valid list"),
        ({"picks": 8}, "unknown argument 'picks'; known are level, num_envs, threads, action_mode"),
        ({"figures": ["speed"]}, "unknown figure 'speed'; known are landing_error_m, success, sorted_per_min"),
        ({"figures": []}, "no figure is given"),
        ({"others": ["mlp"], "practice": 0}, "--practice is 0, but controller 'mlp' has learned nothing"),
        ({"others": "mlp"}, "others is 'mlp'; it must be a list"),
        ({"others": [planner]}, "controller 'planner' is given twice"),
    ],
)
def test_mistakes_are_one_sentence(options: dict[str, Any], words: str) -> None:
    with pytest.raises(UsageError, match=words.replace("(", r"\(")):
        compare(planner, far, "ToyThrow-v0", **SMALL, **options)


def test_differences_count_up_to_the_cap_where_both_figures_are_known() -> None:
    a, b = np.array([0.5, 0.1, np.nan, 0.2]), np.array([0.1, 0.2, 0.1, np.nan])
    measure = ThrowRecord.measures()["landing_error_m"]
    np.testing.assert_allclose(measure.differences(a, b), [0.1, -0.1])
    np.testing.assert_allclose(replace(measure, cap=0.03).differences(a, b), [0.03, -0.03])
    signs = Figure("spread", "mm", 1000.0).compared()
    np.testing.assert_array_equal(signs.differences(a, b), [1.0, -1.0])
    assert signs.bound == 1.0


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (0.004, "b lands 4.0 mm closer than a (3.0 to 6.0)"),
        (0.007, "b lands 7.0 mm closer than a (3.0 to 6.0)"),
        (-0.001, "b lands -1.0 mm closer than a (3.0 to 6.0)"),
    ],
)
def test_the_better_controller_by_the_interval_is_the_subject(value: float, words: str) -> None:
    """The mean is told as it is, inside the interval or outside of it, and the interval alone says who is ahead."""
    sentence = ThrowRecord.measures()["landing_error_m"].sentence
    assert sentence(("a", "b"), "throws", value, 0.003, 0.006) == words
    assert sentence(("b", "a"), "throws", -value, -0.006, -0.003) == words


class Salvos(Record):
    """One figure of each salvo, of which only is known that it is a number."""

    figures = {"spread_m": Figure("spread", "mm", 1000.0)}  # noqa: RUF012


class SalvoTrial(Trial):
    """A kind of task that says nothing of comparisons."""

    unit = "salvos"
    record = Salvos

    def run(self, controller: Any, count: int, seed: int, **_: Any) -> Salvos:
        wide = 10.0 if controller.name == "far" else 1.0
        return Salvos({"spread_m": wide * np.random.default_rng(seed).random(count)})


def test_a_third_kind_of_task_is_compared_by_signs() -> None:
    with closing(make_vector("ToyThrow-v0", "waste", 4, 1)) as env:
        trial = SalvoTrial(env)
        controllers = {policy.__name__: trial.controller(policy) for policy in (planner, far)}
        comparison = Comparison(trial, controllers, 0, Rules())
        assert sum(comparison.blocks()) == comparison.count < 40
    (sentence,) = comparison.report()["sentences"]
    assert sentence.startswith("far has the larger spread more often than planner, by 100.0 % of all salvos (")


class TurningTrial(SalvoTrial):
    """Salvos in blocks of 100, alike at first; from the fourth block on, those of the controller "far" are wider."""

    def block(self, left: int) -> int:
        return 100

    def run(self, controller: Any, count: int, seed: int, **_: Any) -> Salvos:
        self.done = getattr(self, "done", 0) + count  # of both controllers
        wide = controller.name == "far" and self.done > 600
        return Salvos({"spread_m": np.full(count, 2.0 if wide else 1.0)})


def test_a_mean_outside_of_its_interval_is_announced_with_its_reason() -> None:
    with closing(make_vector("ToyThrow-v0", "waste", 4, 1)) as env:
        trial = TurningTrial(env)
        controllers = {policy.__name__: trial.controller(policy) for policy in (planner, far)}
        comparison = Comparison(trial, controllers, 0, Rules(budget=400))
        assert sum(comparison.blocks()) == 400
    report = comparison.report()
    figure = report["pairs"][0]["figures"]["spread_m"]
    assert figure["value"] == pytest.approx(-0.25) == report["pairs"][0]["trace"][-1][1]
    assert figure["outside"]
    assert figure["low"] > figure["value"]
    assert (report["settled"], figure["low_since"]) == (False, 300)
    ends = f"({100 * figure['low']:.1f} to {100 * figure['high']:.1f})"
    assert report["sentences"][0].endswith(f"is -25.0 % {ends}")
    (note,) = report["notes"]
    assert note.startswith(
        f"The mean of planner minus far in spread (sign), -25.0 %, lies outside of its interval {ends}"
    )
    assert "its lower limit dates from after 300 salvos, and later salvos lie below this limit on average" in note


@pytest.mark.parametrize(
    ("env_id", "level", "whole", "length"),
    [
        ("PnTRelease-v0", "waste", False, 1),
        ("PnTConveyor-v0", "waste", False, 10),
        ("PnTAdapt-v0", "day", True, 50),
        ("OneJointAssembly-v0", None, True, 2),
    ],
)
def test_throws_that_depend_on_one_another_are_one_observation(
    env_id: str, level: str | None, whole: bool, length: int
) -> None:
    with closing(make_vector(env_id, level, 2, 1)) as env:
        trial, core = trials.of(env), core_of(env)
        assert (depend(core), run_length(core)) == (whole, length)
        assert trial.block(3) == (2 * length if whole else min(2 * length, 3))
        if env_id == "OneJointAssembly-v0":
            record: Any = trial.run(trial.controller("analytic"), 4, 0)
            columns, throws = record.observations(), record.throws
            np.testing.assert_allclose(columns["landing_error_m"], throws.landing_error.reshape(2, 2).mean(axis=0))
            sorted_, seconds = throws.sorted.reshape(2, 2).sum(axis=0), throws.cycle_time.reshape(2, 2).sum(axis=0)
            np.testing.assert_allclose(columns["sorted_per_min"], 60.0 * sorted_ / seconds)


def test_shifts_of_a_line_are_compared_by_value() -> None:
    level = {"base": "value", "duration": 20.0}
    report = compare("random", "price", "PnTLine-v0", budget=32, level=level, num_envs=4)
    assert next(iter(report["figures"])) == "value_per_min"
    assert report["sentences"][0].startswith("price earns ")
    assert report["unit"] == "work shifts"
