"""A folder in which somebody else works, a small training that is done, and a line with short shifts."""

import pickle
import shutil
import sys
from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import gymnasium as gym
import pytest
import yaml

from agents.ground import work
from agents.ground.work import LimitedWorker
from agents.train import Arguments, main
from benchmarks.kill_trials.commands import LEARNER
from tests.tools.lob import write_package
from tests.tools.toy_cell import register_toy

register_toy()


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
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder as the working folder of this process."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(scope="session")
def toy_training(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Run folder of a training on the cell on paper, let to its end: two legs of eight throws, and its table."""
    place = tmp_path_factory.mktemp("toy")
    (place / "sac.yml").write_text(yaml.safe_dump({"default": LEARNER}))
    few = {"steps": 16, "num_envs": 4, "checkpoint_every": 8, "eval_picks": 4}
    main(Arguments(env="ToyThrow-v0", config=place / "sac.yml", out=place / "run", **few))
    return place / "run"


@pytest.fixture
def run(toy_training: Path, tmp_path: Path) -> Path:
    """A copy of that folder."""
    return Path(shutil.copytree(toy_training, tmp_path / "run"))


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
            yield ((job, work.run(pickle.loads(pickle.dumps(job)), folder)) for job in jobs)

    monkeypatch.setattr(work, "_side_by_side", here)
    monkeypatch.setattr(
        LimitedWorker, "call", lambda _, function, *arguments: function(*pickle.loads(pickle.dumps(arguments)))
    )
