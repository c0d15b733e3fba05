"""What one types is answered at once: help needs no simulation and nothing to learn with."""

import pytest

from tests.tools.commands import run_python

HEAVY = {"mujoco", "torch", "stable_baselines3", "sb3_contrib", "numba", "scipy", "matplotlib", "pydantic"}


@pytest.mark.parametrize(
    "command", [("agents.evaluate",), ("agents.compare",), ("agents.fit",), ("agents.doctor",), ("pnt_gym", "evaluate")]
)
def test_help_imports_nothing_heavy(command: tuple[str, ...]) -> None:
    done = run_python("-X", "importtime", "-m", *command, "--help", check=True)
    assert "--help" in done.stdout
    imported = {row.rpartition("|")[2].strip().partition(".")[0] for row in done.stderr.splitlines()}
    assert "tyro" in imported
    assert not imported & HEAVY
