"""The command lines as a user meets them, on the real cell: each in a process of its own, mistakes in this one."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
import warnings
from pathlib import Path
from typing import Any

import pytest
import yaml

from agents import doctor
from agents.ground.cli import run
from agents.learning import runs
from tests.tools.commands import call, call_here, environment

CONTRACT = {
    "env",
    "controller",
    "level",
    "seed",
    "picks",
    "picks_per_min",
    "sorted_per_min",
    "success_rate",
    "success_low",
    "success_high",
    "landing_error_mean_m",
    "landing_error_p95_m",
    "cycle_time_mean_s",
    "dwell_s",
    "throws",
}


def assert_one_sentence(done: subprocess.CompletedProcess[str], said: str) -> None:
    assert done.returncode == 2, done.stderr
    assert "Traceback" not in done.stderr
    assert done.stderr.startswith("error: ")
    assert done.stderr.count("\n") == 1
    assert said in done.stderr


@pytest.mark.parametrize("env", ["PnTConveyor-v0", "PnTRelease-v0"])
def test_evaluate_writes_the_contract(tmp_path: Path, env: str) -> None:
    arguments = ("--env", env, "--controller", "analytic", "--picks", "20", "--num-envs", "8", "--json", "out.json")
    done = call("agents.evaluate", *arguments, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "sorted per minute" in done.stdout
    data: dict[str, Any] = json.loads((tmp_path / "out.json").read_text())
    assert set(data) >= CONTRACT
    assert (data["env"], data["controller"], data["level"], data["picks"]) == (env, "analytic", "nominal", 20)
    assert len(data["throws"]) == 20
    assert data["success_rate"] == pytest.approx(sum(t["success"] for t in data["throws"]) / 20)
    assert data["picks_per_min"] == pytest.approx(60 * 20 / sum(t["cycle_time_s"] for t in data["throws"]))
    assert data["success_low"] <= data["success_rate"] <= data["success_high"]
    assert {t["item"] for t in data["throws"]} <= {"paper", "metal_can", "plastic_package"}


def test_own_level_file(tmp_path: Path) -> None:
    cell = {"items": ["can"], "bins": {"fixed": [{"name": "here", "x": 0.1, "y": 0.4}]}, "motion": {"dwell": 0.2}}
    (tmp_path / "mine.yaml").write_text(yaml.safe_dump(cell))
    arguments = (
        "--controller",
        "analytic",
        "--picks",
        "4",
        "--num-envs",
        "4",
        "--level",
        "mine.yaml",
        "--json",
        "o.json",
    )
    done = call("agents.evaluate", *arguments, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    data = json.loads((tmp_path / "o.json").read_text())
    assert (data["level"], data["dwell_s"]) == ("mine", 0.2)
    assert {t["item"] for t in data["throws"]} == {"can"}


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--controller", "nobody"), "'nobody' is neither a controller nor a run folder"),
        (("--controller", "runs/none"), "'runs/none' is neither a controller nor a run folder"),
        (("--controller", "."), "is not a run folder: it has no args.yml"),
        (("--controller", "analytic", "--env", "Nowhere-v0"), "unknown environment 'Nowhere-v0'; known are PnT"),
        (("--controller", "analytic", "--level", "nowhere"), "unknown level 'nowhere'; shipped levels are"),
        (("--controller", "analytic", "--level", "none.yaml"), "level file 'none.yaml' does not exist"),
        (("--controller", "analytic", "--level", "bad.yaml"), "unknown key 'gravity'"),
        (("--controller", "analytic", "--level", "belt.yaml"), "lies on the belt"),
        (("--controller", "analytic", "--picks", "0"), "--picks is 0; it must be at least 1"),
        (("--controller", "ridge", "--practice", "-1"), "--practice is -1"),
        (("--controller", "ridge", "--action-mode", "release_xyz"), "needs an action of 2 numbers, not 3"),
        (
            ("--controller", "analytic", "--action-mode", "telepathy"),
            "action_mode is 'telepathy'; it must be one of rel",
        ),
        (("--controller", "analytic", "--json", "."), "cannot write '.': it is a folder"),
        (("--controller", "ridge", "--load", "none.npz"), "'none.npz' does not exist"),
        (("--controller", "analytic", "--save", "a.npz"), "learns nothing that could be kept"),
    ],
)
def test_evaluate_explains_mistakes(tmp_path: Path, arguments: tuple[str, ...], said: str) -> None:
    bins = {"fixed": [{"name": "here", "x": 0.1, "y": 0.4}]}
    (tmp_path / "bad.yaml").write_text(yaml.safe_dump({"bins": bins, "gravity": 1}))
    (tmp_path / "belt.yaml").write_text(yaml.safe_dump({"bins": {"fixed": [{"name": "b", "x": 0.0, "y": -0.3}]}}))
    before = sorted(tmp_path.iterdir())
    assert_one_sentence(call_here("agents.evaluate", *arguments, folder=tmp_path), said)
    assert sorted(tmp_path.iterdir()) == before


def test_a_mistake_ends_the_process_in_one_sentence(tmp_path: Path) -> None:
    done = call("agents.evaluate", "--controller", "nobody", folder=tmp_path)
    assert_one_sentence(done, "'nobody' is neither a controller nor a run folder")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("module", "arguments"),
    [
        ("agents.evaluate", ("--picks", "x", "--controller", "analytic")),
        ("agents.evaluate", ()),
        ("agents.train", ("--algo", "dqn")),
        ("agents.train", ("--stpes", "5")),
        ("agents.benchmark", ("--jobs", "many")),
        ("agents.report", ("--nonsense",)),
    ],
)
def test_usage_errors_exit_with_2(tmp_path: Path, module: str, arguments: tuple[str, ...]) -> None:
    done = call_here(module, *arguments, folder=tmp_path)
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert done.stderr
    assert not list(tmp_path.iterdir())


def test_train_resume_evaluate(tmp_path: Path) -> None:
    start = ("--env", "PnTConveyor-v0", "--steps", "200", "--num-envs", "8", "--out", "run", "--eval-picks", "8")
    done = call("agents.train", *start, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    for name in ("analytic", "virtual_goal", "learned (sac)"):
        assert name in done.stdout
    assert_one_sentence(call_here("agents.train", *start, folder=tmp_path), "'run' exists already")
    assert_one_sentence(call_here("agents.train", "--resume", "run", folder=tmp_path), "give a larger --steps")
    more = call_here("agents.train", "--resume", "run", "--steps", "240", "--eval-picks", "0", folder=tmp_path)
    assert more.returncode == 0, more.stderr
    assert runs.load_model(tmp_path / "run").num_timesteps == 240
    judged = call_here("agents.evaluate", "--controller", "run", "--picks", "8", "--json", "o.json", folder=tmp_path)
    assert judged.returncode == 0, judged.stderr
    data = json.loads((tmp_path / "o.json").read_text())
    assert (data["env"], data["level"], data["controller"]) == ("PnTConveyor-v0", "waste", "run")


def test_train_explains_mistakes(tmp_path: Path) -> None:
    for arguments, said in (
        (("--env", "Nowhere-v0"), "unknown environment"),
        (("--level", "nowhere"), "unknown level"),
        (("--action-mode", "telepathy"), "action_mode is 'telepathy'; it must be one of release_point, release_xyz"),
        (("--steps", "0"), "--steps is 0"),
        (("--resume", "none"), "run folder 'none' does not exist"),
        (("--config", "none.yml"), "cannot read hyperparameters 'none.yml'"),
    ):
        assert_one_sentence(call_here("agents.train", *arguments, folder=tmp_path), said)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_leaves_a_run_that_resume_continues(number: signal.Signals, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "agents.train", "--num-envs", "8", "--steps", "5000", "--out", "run"]
    process = subprocess.Popen(
        command, cwd=tmp_path, env=environment(), stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
    )
    deadline = time.monotonic() + 60
    while not (tmp_path / "run" / "args.yml").exists() and time.monotonic() < deadline:
        time.sleep(0.05)
    time.sleep(1.0)
    process.send_signal(number)
    _, said = process.communicate(timeout=60)
    assert process.returncode == 128 + number, said
    assert "continue with: python -m agents.train --resume run" in said
    assert "Traceback" not in said
    done = runs.load_model(tmp_path / "run").num_timesteps
    steps = str(done + 16)
    more = call_here("agents.train", "--resume", "run", "--steps", steps, "--eval-picks", "0", folder=tmp_path)
    assert more.returncode == 0, more.stderr
    assert runs.load_model(tmp_path / "run").num_timesteps == done + 16


def test_benchmark_and_report_from_end_to_end(tmp_path: Path) -> None:
    plan = {
        "name": "tiny",
        "train_level": "waste",
        "levels": ["waste"],
        "picks": 16,
        "seeds": [0],
        "num_envs": 8,
        "entries": [
            {"label": "analytic", "controller": "analytic"},
            {"label": "mean_shift", "controller": "mean_shift", "throws": [16]},
        ],
        "learned": [{"label": "mean_shift", "throws": 16}],
        "references": [{"label": "analytic"}],
    }
    (tmp_path / "plan.yaml").write_text(yaml.safe_dump(plan))
    arguments = ("--config", "plan.yaml", "--jobs", "1", "--out", "results/tiny.json", "--work", "work")
    first = call("agents.benchmark", *arguments, folder=tmp_path)
    assert first.returncode == 0, first.stderr
    assert first.stdout.count("done: ") == 2
    written = (tmp_path / "results" / "tiny.json").read_bytes()
    again = call_here("agents.benchmark", *arguments, folder=tmp_path)
    assert "done: " not in again.stdout
    assert (tmp_path / "results" / "tiny.json").read_bytes() == written
    page = call("agents.report", "--results", "results", "--readme", "none.md", folder=tmp_path)
    assert page.returncode == 0, page.stderr
    assert (tmp_path / "results" / "report.html").is_file()
    assert_one_sentence(
        call_here("agents.benchmark", "--config", "none.yaml", folder=tmp_path), "cannot read benchmark"
    )


def test_a_warning_is_one_line_while_a_command_runs_and_python_s_own_afterwards(
    capsys: pytest.CaptureFixture[str],
) -> None:
    def command(_: Any) -> None:
        warnings.warn("of two\nlines", stacklevel=1)

    before = (warnings.showwarning, warnings.formatwarning, list(warnings.filters))
    run(command, doctor.Arguments, "agents.doctor", ())
    assert capsys.readouterr().err == "warning: of two lines\n"
    assert (warnings.showwarning, warnings.formatwarning, list(warnings.filters)) == before
