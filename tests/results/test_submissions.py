"""Guards of what others handed in: its form, and its first throws."""

import ast
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from agents.ground.files import read_json
from agents.ground.places import SHIPPED as ROOT
from agents.ground.versions import world_of
from pnt_gym.constants import WORLD
from tests.tools.commands import call_here

FOLDER = ROOT / "results" / "submissions"
FILES = sorted(FOLDER.glob("*.json"))
EXAMPLE = ROOT / "examples" / "05_my_controller.py"


def test_there_is_one() -> None:
    assert "two_centimetres_shorter" in {file.stem for file in FILES}


class Here:
    """A worker without a process of its own and without a limit of time, which tests of `verify` have."""

    def call(self, function: Callable[..., Any], *given: Any) -> Any:
        return function(*given)


@contextmanager
def worker_here(_: float) -> Iterator[Here]:
    yield Here()


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_its_first_throws_are_thrown_again(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    monkeypatch.setattr("agents.ground.work.limited_worker", worker_here)
    options = ("--trust", "--rows", "1", "--throws", "48", "--longest", "1000")
    done = call_here("agents.benchmark.verify", str(file), *options, folder=ROOT)
    if (world := world_of(read_json(file))) < WORLD:
        # Throws of an older world differ, and the command says from which world the file is.
        assert done.returncode == 1
        assert f"the file was made with world {world}; here is {WORLD}" in " ".join(done.stdout.split())
        return
    words = f"{done.stderr}; the command in {file.name} measures it again after a change of the throws"
    assert done.returncode == 0, words


def test_the_first_one_is_the_example() -> None:
    names = (EXAMPLE, FOLDER / "two_centimetres_shorter.py")
    classes = [_class(file.read_text(encoding="utf-8")) for file in names]
    assert classes[0] == classes[1]


def _class(text: str) -> str:
    (node,) = [node for node in ast.parse(text).body if isinstance(node, ast.ClassDef)]
    return ast.dump(node)
