"""A folder in which somebody else works, with a package and controllers of theirs; and a line with short shifts."""

from __future__ import annotations

import pickle
import sys
from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import gymnasium as gym
import pytest

from agents.jobs import work
from tests.tools.lob import write_package


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A working folder with the package and the controllers of somebody else."""
    place = tmp_path_factory.mktemp("theirs")
    write_package(place)
    return place


@pytest.fixture
def here(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """That folder as the working folder of this process, whose modules are forgotten afterwards."""
    monkeypatch.chdir(folder)
    monkeypatch.syspath_prepend(str(folder))
    yield folder
    for name in ("lob", "theirs", "torn"):
        sys.modules.pop(name, None)
    for name in [name for name in gym.registry if name.startswith("Lob")]:
        gym.registry.pop(name)


@pytest.fixture
def short(tmp_path: Path) -> str:
    """A level of a line with shifts of ten seconds, as a file."""
    file = tmp_path / "short.yaml"
    file.write_text("base: value\nname: short\nduration: 10\n")
    return str(file)


@pytest.fixture
def worker_here(monkeypatch: pytest.MonkeyPatch) -> None:
    """A worker that is alone does its jobs in this process, which has imported already what takes seconds to.

    Several workers are processes as ever, and jobs are sent as they would be to a process.
    """
    side_by_side = work._side_by_side

    @contextmanager
    def here(
        count: int, jobs: Sequence[work.Job], folder: Path
    ) -> Generator[Iterator[tuple[work.Job, work.Completion]], None, None]:
        if count > 1:
            with side_by_side(count, jobs, folder) as ended:
                yield ended
        else:
            yield ((job, work.run_job(pickle.loads(pickle.dumps(job)), folder)) for job in jobs)

    monkeypatch.setattr(work, "_side_by_side", here)
