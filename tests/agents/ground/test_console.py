"""The command `pnt-gym` and what only it has."""

import sys

import pytest

from agents.ground import console
from pnt_gym.__main__ import main
from pnt_gym.cells.conveyor.config import ConveyorConfig


@pytest.fixture
def say(capsys, monkeypatch):
    """What the command prints for some words, and how it exits."""

    def run(*words):
        monkeypatch.setattr(sys, "argv", ["pnt-gym", *words])
        code = 0
        try:
            main()
        except SystemExit as end:
            code = end.code or 0
        said = capsys.readouterr()
        return code, said.out, said.err

    return run


def test_without_a_word_it_lists_the_commands(say):
    code, out, _ = say()
    assert code == 0
    assert all(f"  {name}" in out for name in console.COMMANDS)
    assert say("--help")[1] == out


@pytest.mark.parametrize("words", ["evaluat", "line", "line calibrat"])
def test_an_unknown_command_is_one_sentence(say, words):
    code, _, error = say(*words.split(), *(["x"] if words == "line" else []))
    said = "line x" if words == "line" else words
    assert code == 2
    assert error.startswith(f"error: unknown command {said!r}")


@pytest.mark.parametrize("words", [["line"], ["line", "--help"]])
def test_the_tools_of_lines_are_listed(say, words):
    code, out, _ = say(*words)
    assert code == 0
    assert [line.split()[:2] for line in out.splitlines() if line.startswith("  ")] == [
        ["line", name] for name in ("plan", "tune", "calibrate")
    ]


def test_the_levels_are_listed_with_their_purpose(say):
    code, out, _ = say("levels")
    assert code == 0
    assert all(f"PnT/{name}" in out for name in ConveyorConfig.level_names())
    assert "Fifteen kinds of waste" in out


def test_the_demo_lets_all_throw_the_same(say):
    code, out, _ = say("demo", "--picks", "16")
    assert code == 0
    assert [name for name in ("analytic", "virtual_goal", "trained policy (sac)") if name not in out] == []
    assert "the same 16 throws each" in out


def test_the_doctor_throws(say):
    code, out, _ = say("doctor")
    assert code == 0
    assert all(name in out for name in ("mujoco", "torch", "MUJOCO_GL", " a second, "))
