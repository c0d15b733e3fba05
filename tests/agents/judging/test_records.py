"""Records of a user: truth values and whole numbers are numbers for every command, and all else is refused."""

import sys
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agents.ground.cli import UsageError
from agents.judging.figures import Figure
from agents.judging.record import Record
from agents.judging.trials import open_trial
from agents.results.compare import compare
from tests.tools.commands import call_here, output_of

TRIAL = '''
"""A trial by bursts of four throws."""
from agents.judging.loop import throw_held_out
from agents.judging.record import Figure, Record
from agents.judging.trial import Trial

class Bursts(Record):
    """Whether all throws of a burst are a success, and how many are."""
    figures = {"whole": Figure("whole", "%", 100.0), "hits": Figure("hits")}

class BurstTrial(Trial):
    """Bursts of four throws."""
    unit = "bursts"
    usual = 8
    record = Bursts

    def run(self, controller, count, seed, *, online=False, progress=None):
        success = throw_held_out(controller, self.env, 4 * count, seed).is_success.reshape(count, 4)
        return Bursts({"whole": success.all(axis=1), "hits": success.sum(axis=1)})
'''
EVALUATE = "evaluate --env ToyThrow-v0 --controller analytic --num-envs 4 --picks 6 --trial"


class Whole(Record):
    """One figure of each unit."""

    figures = {"whole": Figure("whole", "%", 100.0)}  # noqa: RUF012


@pytest.mark.parametrize(
    "values", [np.array([True, False, True]), np.array([1, 0, 1]), [True, False, True], [1, 0, 1], [1.0, 0.0, 1.0]]
)
def test_truth_values_and_whole_numbers_are_numbers(values: Any) -> None:
    record = Whole({"whole": values})
    summary = record.summary()
    assert summary["whole"] == pytest.approx(2 / 3)
    assert 0.0 <= summary["whole_low"] <= summary["whole"] <= summary["whole_high"] <= 1.0
    assert record.report()["throws"] == [{"whole": value} for value in (1.0, 0.0, 1.0)]
    a, b = record.observations()["whole"], Whole({"whole": [0, 0, 0]}).observations()["whole"]
    assert Whole.measures()["whole"].differences(a, b).tolist() == [1.0, 0.0, 1.0]
    columns = record.columns()
    Whole.form().model_validate(columns, context={"count": 3})
    result = {"columns": columns, "seed": 0, "learn_seconds": 0.0}
    base = {**result, "columns": Whole({"whole": [False] * 3}).columns()}
    assert Whole.summarise([result], 16)["whole"] == summary["whole"]
    assert compare(Whole, [result], [base], 16)["whole"]["value"] == pytest.approx(2 / 3)


@pytest.mark.parametrize(
    ("env_id", "level", "name", "least"),
    [("PnTRelease-v0", "waste", "random", 17), ("PnTLine-v0", {"base": "single", "duration": 5.0}, "fifo", 13)],
)
def test_figures_of_kept_columns_are_those_of_the_evaluation(env_id: str, level: Any, name: str, least: int) -> None:
    """A benchmark's columns are rounded, and their totals stand for single units; figures are the same ones."""
    with closing(open_trial(env_id, level, 2, 1)) as trial:
        record = trial.run(trial.controller(name), 8, 0)
    live = record.summary()
    kept = type(record).summarise([{"columns": record.columns(), "seed": 0, "learn_seconds": 0.0}], 2)
    names = (live.keys() & kept.keys()) - type(record).timings  # a short time is rounded away
    numbers = [name for name in names if isinstance(live[name], int | float)]
    assert len(numbers) >= least
    for figure in numbers:
        assert kept[figure] == pytest.approx(live[figure], rel=1e-3, abs=1e-5), figure


def test_a_unit_without_a_value_is_left_out() -> None:
    assert Whole({"whole": [True, None, float("nan"), False]}).summary()["whole"] == 0.5
    assert Whole({"whole": [None]}).summary()["whole"] is None


@pytest.mark.parametrize(
    ("columns", "words"),
    [
        ({"whole": ["yes", "no"]}, "column 'whole' of Whole is ['yes', 'no']; it must be a list of numbers"),
        ({"whole": [[1.0], [2.0]]}, "it must be a list of numbers, one for each unit"),
        ({"whole": []}, "it must be a list of numbers, one for each unit"),
        ({"whole": [1, 2], "more": [1]}, "column 'more' of Whole has 1 entries; 'whole' has 2"),
        ({"other": [1]}, "Whole has no column 'whole', from which a figure is computed"),
    ],
)
def test_other_rows_are_refused_in_a_sentence(columns: dict[str, Any], words: str) -> None:
    with pytest.raises(UsageError) as error:
        Whole(columns)
    assert words in str(error.value)


@pytest.fixture
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a user's trial, which is forgotten afterwards."""
    (tmp_path / "their_bursts.py").write_text(TRIAL, encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, "their_bursts", raising=False)
    return tmp_path


def test_an_environment_is_judged_by_another_trial(desk: Path) -> None:
    shown = output_of(f"{EVALUATE} their_bursts:BurstTrial", desk)
    assert "6 bursts" in shown
    assert "whole" in shown
    pair = "compare analytic random --env ToyThrow-v0 --num-envs 4 --budget 8 --trial their_bursts:BurstTrial"
    assert "whole (sign)" in output_of(pair, desk)


@pytest.mark.parametrize(
    ("trial", "words"),
    [
        ("throws", "--trial is 'throws'; it must be MODULE:CLASS of a subclass of"),
        ("their_bursts:Bursts", "--trial is 'their_bursts:Bursts'; it must be MODULE:CLASS of a subclass of"),
        ("nowhere:Trial", "module 'nowhere' cannot be imported"),
    ],
)
def test_a_trial_that_there_is_not_is_one_sentence(desk: Path, trial: str, words: str) -> None:
    done = call_here("agents.evaluate", *f"{EVALUATE} {trial}".split()[1:], folder=desk)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert words in done.stderr
