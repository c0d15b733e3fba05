"""The command lines as a user meets them, on the real cell: some in a process of their own, most in this one."""

import signal
import subprocess
import sys
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from agents import doctor
from agents.ground.cli import run
from agents.learning.runs import RunFolder
from tests.tools.commands import answer, call, call_here, environment, output_of
from tests.tools.nightly import with_nightly

pytestmark = pytest.mark.usefixtures("worker_here")
Start = Callable[..., "subprocess.CompletedProcess[str]"]
CONTRACT = {
    "env", "controller", "level", "seed", "picks", "picks_per_min", "sorted_per_min", "success_rate", "success_low",
    "success_high", "landing_error_mean_m", "landing_error_p95_m", "cycle_time_mean_s", "dwell_s", "throws",
}  # fmt: skip


STARTS = [("PnTConveyor-v0", call_here), ("PnTConveyor-v0", call), ("PnTRelease-v0", call_here)]


@pytest.mark.parametrize(("env", "start"), with_nightly(STARTS, STARTS[:1]))
def test_evaluate_writes_the_contract(tmp_path: Path, env: str, start: Start) -> None:
    line = f"agents.evaluate --env {env} --controller analytic --picks 20 --num-envs 8 --json out.json"
    done = start(line, folder=tmp_path)
    data = answer(done, tmp_path / "out.json")
    assert "sorted per minute" in done.stdout
    assert set(data) >= CONTRACT
    assert (data["env"], data["controller"], data["level"], data["picks"]) == (env, "analytic", "nominal", 20)
    assert len(data["throws"]) == 20
    assert data["success_rate"] == pytest.approx(sum(t["success"] for t in data["throws"]) / 20)
    assert data["picks_per_min"] == pytest.approx(60 * 20 / sum(t["cycle_time_s"] for t in data["throws"]))
    assert data["success_low"] <= data["success_rate"] <= data["success_high"]
    assert {t["item"] for t in data["throws"]} <= {"paper", "metal_can", "plastic_package"}


@pytest.mark.parametrize("start", with_nightly([call_here, call], [call_here]))
def test_a_mistake_ends_the_process_in_one_sentence(tmp_path: Path, start: Start) -> None:
    done = start("agents.evaluate", "--controller", "nobody", folder=tmp_path)
    assert done.returncode == 2, done.stderr
    assert done.stderr.startswith("error: unknown controller 'nobody'; known are")
    assert done.stderr.count("\n") == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("line", "sentence"),
    [
        ("train --steps 1.5", "--steps is '1.5'; it must be a whole number; see"),
        ("train --num-envs two", "--num-envs is 'two'; it must be a whole number; see"),
        ("compare analytic ridge --margin wide", "--margin is 'wide'; it must be a number; see"),
        ("play --at now", "--at is 'now'; it must be a number; see"),
        ("line plan --speeds 0.3 fast", "--speeds is '0.3', 'fast'; each must be a number; see"),
        ("line plan --robots a", "--robots is 'a'; it must be a whole number; see"),
        ("train --steps", "--steps needs a value; see"),
        (
            "evaluate --controller analytic --throws some",
            "--throws: unknown value 'some'; known are flight, full, table",
        ),
        ("train --step 3", "unknown options: --step, 3; perhaps you meant --steps N; see"),
        ("evaluate", "give --controller NAME|"),
        ("publish", "give RUN_DIR; see"),
        ("benchmark.submit", "give MODULE:CLASS|RUN_DIR|NAME and --by STR; see"),
    ],
)
def test_options_of_another_form_are_refused_in_words_of_people(tmp_path: Path, line: str, sentence: str) -> None:
    done = call_here(f"agents.{line}", folder=tmp_path)
    assert done.returncode == 2, done.stderr
    assert done.stderr.startswith(f"error: {sentence}")
    assert done.stderr.count("\n") == 1
    assert not list(tmp_path.iterdir())


SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


@pytest.mark.parametrize("number", with_nightly(SIGNALS, SIGNALS[:1]))
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
    assert "Traceback" not in said
    done = RunFolder(tmp_path / "run").load().num_timesteps
    assert f"stopped after {done} throws; continue with: python -m agents.train --resume run" in said
    output_of(f"train --resume run --steps {done + 16} --eval-picks 0", tmp_path)
    assert RunFolder(tmp_path / "run").load().num_timesteps == done + 16


def test_a_warning_is_one_line_while_a_command_runs_and_python_s_own_afterwards(
    capsys: pytest.CaptureFixture[str],
) -> None:
    def command(_: Any) -> None:
        warnings.warn("of two\nlines", stacklevel=1)

    before = (warnings.showwarning, warnings.formatwarning, list(warnings.filters))
    run(command, doctor.Arguments, "agents.doctor", ())
    assert capsys.readouterr().err == "warning: of two lines\n"
    assert (warnings.showwarning, warnings.formatwarning, list(warnings.filters)) == before
