"""The trial of an environment: found by the config of its levels, the same for every command."""

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest

import pnt_gym
from agents.ground.cli import UsageError
from agents.ground.environments import config_of, core_of, make_vector
from agents.judging import trials
from agents.judging.evaluation import evaluate, evaluate_all
from agents.judging.figures import Figure
from agents.judging.record import Record
from agents.judging.shift_trial import ShiftTrial
from agents.judging.throw_trial import ThrowTrial
from agents.judging.trial import Trial
from agents.judging.trials import open_trial
from pnt_gym.cells.base.config import LevelConfig
from tests.tools.commands import output_of


class Halves(Record):
    """Two figures of each unit, of which one is not always known."""

    figures = {"share": Figure("share", "%", 100.0), "length_m": Figure("length", "mm", 1000.0)}  # noqa: RUF012

    def __init__(self) -> None:
        super().__init__({"share": [0.0, 1.0, 0.5], "length_m": [0.1, None, 0.3]})


class Lost(LevelConfig):
    """A level of no kind of task."""

    trial = "nowhere"


@pytest.fixture
def opened(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[Any]]:
    """What is opened with Gymnasium."""
    made: list[Any] = []
    make = gymnasium.make_vec
    monkeypatch.setattr(gymnasium, "make_vec", lambda *given, **more: made.append(given) or make(*given, **more))
    yield made


@pytest.mark.parametrize("env_id", pnt_gym.ENV_IDS)
def test_configs_and_trials_are_known_without_opening_an_environment(env_id: str, opened: list[Any]) -> None:
    config = config_of(env_id)
    kind = trials.find(config)
    assert opened == []
    assert kind is (ShiftTrial if env_id == "PnTLine-v0" else ThrowTrial)
    with closing(make_vector(env_id, num_envs=1, threads=1)) as env:
        assert core_of(env).config == config
        assert type(trials.of(env)) is kind


def test_the_config_of_an_environment_that_cannot_tell_is_asked_of_its_core() -> None:
    assert config_of("ToyThrow-v0", "waste").name == "waste"


def test_a_kind_of_task_that_there_is_not_is_one_sentence() -> None:
    with pytest.raises(UsageError, match="unknown trial 'nowhere'; known are throws, work_shifts, or MODULE:CLASS"):
        trials.find(Lost())


@pytest.mark.parametrize(
    "words", ["analytic --picks 16", "fifo --env PnTLine-v0 --shifts 1 --num-envs 1 --throws table"]
)
def test_an_evaluation_opens_its_environment_once(tmp_path: Path, opened: list[Any], words: str) -> None:
    output_of(f"evaluate --controller {words}", tmp_path)
    assert len(opened) == 1


@pytest.mark.parametrize(
    ("env_id", "level", "name"),
    [("PnTRelease-v0", "waste", "analytic"), ("PnTLine-v0", {"base": "single", "duration": 5.0}, "fifo")],
)
def test_one_and_several_controllers_are_judged_alike(env_id: str, level: Any, name: str) -> None:
    alone = evaluate(name, env_id, 4, level=level, num_envs=2)
    with closing(open_trial(env_id, level, 2, 1)) as trial:
        rows = evaluate_all(trial, [("a", trial.controller(name), 0), ("b", trial.controller(name), 9)], 4, 0)
    assert [row[:2] for row in rows] == [("a", 0), ("b", 9)]
    for _, _, summary in rows:
        assert {key: alone[key] for key in summary if "ms_per" not in key} == {
            key: value for key, value in summary.items() if "ms_per" not in key
        }


def test_a_record_of_two_figures_tells_all_that_follows_from_them() -> None:
    record = Halves()
    summary, report, columns = record.summary(), record.report(), record.columns()
    assert (summary["count"], summary["share"], summary["length_m"]) == (3, 0.5, 0.2)
    assert summary["length_m_low"] <= 0.2 <= summary["length_m_high"]
    assert report["throws"][1] == {"share": 1.0, "length_m": None}
    results = [{"columns": columns, "seed": seed, "learn_seconds": 1.0} for seed in (0, 1)]
    assert Halves.summarise(results, 16) == {**summary, "seeds": [0, 1], "learn_seconds": 1.0}
    np.testing.assert_array_equal(Halves.paired_columns(results, [results], 16)["share"], [[[0.0, 1.0, 0.5]] * 2])


def test_figures_that_nobody_knows_are_a_dash() -> None:
    assert Figure("x", "mm", 1000.0).text(None) == Figure("x").text(float("nan")) == "-"
    assert Figure("x", "mm", 1000.0).text(0.0123) == "12.3 mm"


def test_a_trial_without_pictures_says_so() -> None:
    class Bare(Trial):
        unit = "salvos"
        record = Halves

        def run(self, *_: Any, **__: Any) -> Halves:
            return Halves()

    with closing(make_vector("PnTRelease-v0", num_envs=1, threads=1)) as env:
        trial = Bare(env)
        with pytest.raises(UsageError, match="salvos of this environment cannot be shown"):
            trial.steps(trial.controller("analytic"), 0)
