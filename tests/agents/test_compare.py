"""The command that settles which of several controllers is better."""

import json
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from agents.compare import Arguments, main
from agents.ground.cli import UsageError
from agents.ground.places import POLICY
from agents.judging.comparison import Comparison
from agents.learning.trained import resolve_shared_task
from tests.tools.commands import figures_of, output_of

TOY = "--env ToyThrow-v0 --level waste --num-envs 8 --threads 1"


def test_the_verdict_is_printed_written_and_drawn(tmp_path: Path) -> None:
    said = output_of(f"compare analytic ridge {TOY} --json out.json --picture out.svg", tmp_path)
    report = json.loads((tmp_path / "out.json").read_text())
    assert said.splitlines()[-1] == report["sentences"][0]
    assert "ridge lands" in said
    assert said.splitlines()[-2:-1] == report["notes"]
    assert f"level waste, {report['count']} throws each" in said
    assert (report["env"], report["seed"], report["practice"]) == ("ToyThrow-v0", 0, {"analytic": 0, "ridge": 120})
    assert (tmp_path / "out.svg").read_text().count("<svg") == 1


def test_the_same_command_gives_the_same_report(tmp_path: Path) -> None:
    line = f"compare analytic random {TOY} --budget 40 --seed 5"
    assert figures_of(line, tmp_path) == figures_of(line, tmp_path)
    assert figures_of(line, tmp_path)["pairs"] != figures_of(line.replace("seed 5", "seed 6"), tmp_path)["pairs"]


def test_ctrl_c_gives_the_verdict_so_far(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    blocks = Comparison.blocks

    def interrupted(self: Comparison) -> Iterator[int]:
        for units in blocks(self):
            yield units
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(Comparison, "blocks", interrupted)
    monkeypatch.chdir(tmp_path)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    options = {"env": "ToyThrow-v0", "level": "waste", "num_envs": 8, "threads": 1, "json": Path("out.json")}
    with pytest.raises(KeyboardInterrupt):
        main(Arguments(("analytic", "random"), figures=("success",), **options))
    report = json.loads(Path("out.json").read_text())
    assert report["count"] == 8
    assert report["sentences"][0] in capsys.readouterr().out


def test_a_run_folder_brings_its_environment_to_all() -> None:
    env_id, level, mode = resolve_shared_task(["analytic", str(POLICY)], None, None)
    assert (env_id, mode) == ("PnTRelease-v0", "release_point")
    assert level is not None
    assert level.startswith(str(POLICY))
    assert resolve_shared_task(["analytic", "mlp"], None, "tight") == ("PnTConveyor-v0", "tight", None)
    assert resolve_shared_task([str(POLICY), "mlp"], "PnTConveyor-v0", "tight")[:2] == ("PnTConveyor-v0", "tight")


def test_run_folders_of_several_tasks_need_to_be_told(run: Path) -> None:
    with pytest.raises(UsageError, match="controllers were trained in PnTRelease-v0 and ToyThrow-v0"):
        resolve_shared_task([str(POLICY), str(run)], None, None)
