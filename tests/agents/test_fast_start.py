"""What one types is answered at once: help needs no simulation and nothing to learn with."""

import subprocess
import sys

import pytest

from tests.tools.commands import environment

HEAVY = {"mujoco", "torch", "stable_baselines3", "sb3_contrib", "numba", "scipy", "matplotlib", "pydantic"}


@pytest.mark.parametrize("command", [("agents.evaluate",), ("agents.doctor",), ("pnt_gym", "evaluate")])
def test_help_imports_nothing_heavy(command: tuple[str, ...]) -> None:
    line = [sys.executable, "-X", "importtime", "-m", *command, "--help"]
    done = subprocess.run(line, env=environment(), capture_output=True, text=True, check=True)
    assert "--help" in done.stdout
    imported = {row.rpartition("|")[2].strip().partition(".")[0] for row in done.stderr.splitlines()}
    assert "tyro" in imported
    assert not imported & HEAVY
