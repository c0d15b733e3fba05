"""Run folders: what a command reads of them."""

import os
import shutil
from pathlib import Path
from typing import Any

import pytest

from agents.ground.places import POLICY
from agents.learning.runs import RunFolder
from tests.tools.commands import output_of

COMMANDS = {
    "evaluate": "evaluate --controller run --picks 8",
    "publish": "publish run --to kept --picks 8 --levels waste unseen --no-video --no-model",
}


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_reads_the_arguments_of_a_run_once(name: str, tmp_path: Path, monkeypatch: Any) -> None:
    shutil.copytree(POLICY, tmp_path / "run")
    opened, real = list[str](), os.open
    monkeypatch.setattr(os, "open", lambda path, *rest, **more: opened.append(str(path)) or real(path, *rest, **more))
    output_of(COMMANDS[name], tmp_path)
    assert len([path for path in opened if path.endswith("args.yml")]) == 1


def test_arguments_that_change_are_read_anew(tmp_path: Path) -> None:
    run = RunFolder(tmp_path)
    run.write(RunFolder(POLICY).arguments)
    more = {**run.arguments, "steps": run.arguments["steps"] + 1}
    run.write(more)
    assert run.arguments == more


def test_who_changes_arguments_changes_none_of_others(tmp_path: Path) -> None:
    before = RunFolder(POLICY).arguments
    RunFolder(POLICY).arguments["steps"] = 0
    assert RunFolder(POLICY).arguments == before
