"""A resumed training is what the run was asked for: no option is dropped, and no column begins anew."""

from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from agents.ground.cli import UsageError
from agents.ground.files import read_json
from agents.learning.progress import ProgressCallback, Stop
from agents.learning.runs import ARGUMENTS, LATER, RunFolder
from agents.learning.windows import ThrowWindow
from agents.train import Arguments, main
from agents.training.session import ANEW, DEFAULTS, request
from benchmarks.kill_trials.commands import LEARNER

ELSEWHERE = {"config": "config.yml, a file of the folder", "out": "the folder itself"}
"""Options that a run folder keeps beside args.yml."""
OF_THE_COMMAND = {"resume", "threads"}
"""Options that each command line gives for itself."""
ASKED: dict[str, Any] = {
    "env": "ToyThrow-v0",
    "level": "waste",
    "fidelity": "flight",
    "full_last": 3,
    "algo": "ppo",
    "steps": 77,
    "seed": 5,
    "num_envs": 3,
    "action_mode": "release_xyz",
    "checkpoint_every": 11,
    "stack": 2,
    "over": "kalman",
    "eval_picks": 9,
    "tensorboard": True,
}
"""A value of each argument that is not the default."""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "run").mkdir()
    RunFolder(tmp_path / "run").write(ASKED)
    return tmp_path / "run"


def test_each_option_is_kept_in_the_folder_or_taken_from_the_new_command_line() -> None:
    names = {field.name for field in fields(Arguments)}
    assert names == {*DEFAULTS, *ELSEWHERE, *OF_THE_COMMAND}
    assert {*DEFAULTS} == {*ARGUMENTS, *LATER} == {*ASKED}
    assert not [name for name in DEFAULTS if ASKED[name] == DEFAULTS[name]]


@pytest.mark.parametrize("name", DEFAULTS)
def test_a_resume_goes_on_with_what_the_run_was_asked_for(folder: Path, name: str) -> None:
    assert request(vars(Arguments(resume=folder)))[name] == ASKED[name]


@pytest.mark.parametrize("name", [*DEFAULTS, "out", "config"])
def test_an_option_given_with_a_resume_counts_or_is_refused(folder: Path, name: str) -> None:
    other = {"eval_picks": 0, "steps": 99}.get(name, ASKED.get(name, folder))
    given = vars(replace(Arguments(resume=folder), **{name: other}))
    if name in (*ANEW, "env"):  # the environment may be named once more, to import its module
        assert request(given)[name] == other
        return
    with pytest.raises(UsageError, match=f"--{name.replace('_', '-')} cannot be changed with --resume"):
        request(given)


@pytest.mark.parametrize("name", LATER)
def test_a_folder_of_an_older_version_has_the_default_of_a_new_run(folder: Path, name: str) -> None:
    older = {key: value for key, value in ASKED.items() if key != name}
    RunFolder(folder).write(older)
    assert request(vars(Arguments(resume=folder))) == {**ASKED, name: DEFAULTS[name]}


@pytest.mark.parametrize(
    ("name", "value"),
    [("eval_picks", -1), ("eval_picks", True), ("eval_picks", "9"), ("tensorboard", 1), ("tensorboard", None)],
)
def test_a_damaged_argument_is_one_sentence(folder: Path, name: str, value: object) -> None:
    RunFolder(folder).write({**ASKED, name: value})
    with pytest.raises(UsageError, match=f"is damaged: args.yml has {name} {value!r}"):
        request(vars(Arguments(resume=folder)))


def test_a_resumed_run_logs_and_judges_as_it_was_asked_for(tmp_path: Path) -> None:
    config = tmp_path / "sac.yml"
    config.write_text(yaml.safe_dump({"default": LEARNER}))
    run = tmp_path / "run"
    small = {"env": "ToyThrow-v0", "level": "waste", "num_envs": 4, "checkpoint_every": 8, "config": config}
    main(Arguments(out=run, steps=8, eval_picks=12, tensorboard=True, **small))
    events = len([*(run / "tensorboard").iterdir()])
    (first,) = progress(run)
    main(Arguments(resume=run, steps=16))
    assert len([*(run / "tensorboard").iterdir()]) == events + 1
    assert [row["throws"] for row in progress(run)] == [8, 16]
    assert progress(run)[0] == first
    assert progress(run)[1]["seconds"] >= first["seconds"]
    judged = read_json(run / "evaluation.json")
    assert {row["picks"] for row in judged} == {12}
    main(Arguments(resume=run, steps=24, eval_picks=0))
    assert RunFolder(run).arguments | {"steps": 24, "eval_picks": 0, "tensorboard": True} == RunFolder(run).arguments
    assert not (run / "evaluation.json").exists()


def progress(run: Path) -> list[Any]:
    """Rows of progress.csv by the names of the columns."""
    table = np.genfromtxt(run / "progress.csv", delimiter=",", names=True)
    return [*np.atleast_1d(table)]


@pytest.mark.parametrize(
    ("lines", "kept", "before"),
    [
        (["8,100.25,0.5,0.01,0.2", "16,200.50,0.5,0.01,0.2"], 1, 100.25),  # the second leg is repeated
        (["8,100.25,0.5,0.01,0.2", "8,soon,0.5,0.01,0.2"], 1, 100.25),
        ([], 0, 0.0),
    ],
)
def test_seconds_go_on_where_the_kept_legs_ended(tmp_path: Path, lines: list[str], kept: int, before: float) -> None:
    file = tmp_path / "progress.csv"
    file.write_text("\n".join(["throws,seconds,success_rate,landing_error_mean_m,reward_mean", *lines]) + "\n")
    callback = ProgressCallback(file, 8, Stop(), ThrowWindow(), lambda *_: None)
    callback.num_timesteps = 16
    callback.locals = {"rewards": np.array([0.1]), "infos": [{"is_success": True, "landing_error": 0.02}]}
    callback._on_step()
    callback._on_training_end()
    rows = progress(tmp_path)
    assert len(rows) == kept + 1
    assert before <= rows[-1]["seconds"] < before + 60.0
