"""Folders for datasets: an empty one, and one with a dataset that the command has made."""

from pathlib import Path

import pytest

from tests.tools.commands import call_here
from tests.tools.datasets import NAME, SMALL


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a dataset that the command has made, with a worker process as a user has."""
    folder = tmp_path_factory.mktemp("data")
    who = ("--author", "Ada", "--author-email", "ada@here", "--code-permalink", "https://here/code")
    done = call_here(*SMALL, "--throws", "22", "--root", folder / "sets", *who, folder=folder)
    assert done.returncode == 0, done.stderr
    assert "done: throws-0" in done.stdout
    assert not (folder / "kept").exists()
    assert f"{NAME}" in done.stdout
    return folder / "sets"


@pytest.fixture
def sets(place: Path, desk: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Minari's folder with that dataset in it."""
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(place))
    return place


@pytest.fixture
def here(desk: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder, below which Minari's is."""
    monkeypatch.setenv("MINARI_DATASETS_PATH", "sets")
    return desk
