"""Jobs: done once, kept whole or not at all, and under a key of what they depend on."""

import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import pytest

from agents.ground import work
from agents.ground.cli import UsageError
from agents.ground.work import Job, do_missing, key, processes
from pnt_gym.errors import PntGymError
from tests.tools.commands import environment
from tests.tools.nightly import with_nightly


def noted(name: str, log: Path, kept: Path) -> dict[str, Any]:
    """A job that leaves a line each time it is done."""
    with log.open("a") as file:
        file.write(f"{name}\n")
    return {"name": name, "folder": kept.name, "threads": os.environ["OMP_NUM_THREADS"]}


def die(_: Path) -> dict[str, Any]:
    os._exit(9)


def refuse(_: Path) -> dict[str, Any]:
    raise PntGymError("there is no such thing")


def wait(_: Path) -> dict[str, Any]:
    time.sleep(60.0)
    return {}


def files(folder: Path) -> list[str]:
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())


def test_a_second_call_does_only_what_is_missing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    kept, log = tmp_path / "kept", tmp_path / "log"
    jobs = [Job(name, "k", partial(noted, name, log), cost) for name, cost in (("a", 1), ("b/c", 3), ("d", 2))]
    done = do_missing(jobs[:1], kept, processes(1))
    assert done == [{"seconds": done[0]["seconds"], "name": "a", "folder": "kept", "threads": "1"}]
    assert [found["name"] for found in do_missing(jobs, kept, processes(1))] == ["a", "b/c", "d"]
    assert log.read_text().split() == ["a", "b/c", "d"]  # the longest first
    assert files(kept) == ["a-k.json", "b/c-k.json", "d-k.json"]
    assert "done: b/c (0 s)" in capsys.readouterr().out
    do_missing(jobs, kept, processes(2))
    assert len(log.read_text().split()) == 3
    do_missing(jobs[:1], kept, processes(2), fresh=True)
    do_missing([Job("a", "another", partial(noted, "a", log))], kept, processes(2))
    assert log.read_text().split() == ["a", "b/c", "d", "a", "a"]


def test_a_process_that_dies_leaves_nothing_half_written(tmp_path: Path) -> None:
    kept, log = tmp_path / "kept", tmp_path / "log"
    well = Job("well", "k", partial(noted, "well", log), cost=2)
    with pytest.raises(UsageError, match=r"a worker process died.*fewer --jobs"):
        do_missing([well, Job("ill", "k", die)], kept, processes(1))
    assert files(kept) == ["well-k.json"]
    again = do_missing([well, Job("ill", "k", partial(noted, "ill", log))], kept, processes(1))
    assert [found["name"] for found in again] == ["well", "ill"]
    assert log.read_text().split() == ["well", "ill"]


def test_a_job_that_cannot_be_done_says_why(tmp_path: Path) -> None:
    with pytest.raises(PntGymError, match="there is no such thing"):
        do_missing([Job("ill", "k", refuse)], tmp_path, processes(1))
    assert not files(tmp_path)


def test_a_write_that_fails_leaves_what_was_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    job = Job("a", "k", partial(noted, "a", tmp_path / "log"))
    before = do_missing([job], tmp_path / "kept", processes(1))

    def full(*_: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("agents.ground.files.os.replace", full)
    with pytest.raises(UsageError, match="No space left"):
        do_missing([job], tmp_path / "kept", processes(1), fresh=True)
    assert files(tmp_path / "kept") == ["a-k.json"]
    assert do_missing([job], tmp_path / "kept", processes(1)) == before


@dataclass(frozen=True)
class Nothing:
    """Arguments of a command without any."""


@pytest.fixture
def working(tmp_path: Path) -> subprocess.Popen[bytes]:
    """A process whose two workers have done one job and are at others that take long."""
    code = (
        "import signal; from functools import partial; from pathlib import Path\n"
        "from agents.ground.cli import run\n"
        "from agents.ground.work import Job, do_missing, processes\n"
        "from tests.agents.ground.test_work import Nothing, noted, wait\n"
        "if __name__ == '__main__':\n"
        "    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs inherit deaf ears\n"
        "    waiting = [Job(f'w{n}', 'k', wait) for n in range(4)]\n"
        "    work = [Job('a', 'k', partial(noted, 'a', Path('log')), 9), *waiting]\n"
        "    run(lambda _: do_missing(work, Path('kept'), processes(2)), Nothing, 'work', [])\n"
    )
    (tmp_path / "script.py").write_text(code)
    command = [sys.executable, "script.py"]
    process = subprocess.Popen(
        command, cwd=tmp_path, env=environment(), start_new_session=True, stderr=subprocess.PIPE, stdout=subprocess.PIPE
    )
    deadline = time.monotonic() + 90.0
    while not (tmp_path / "kept" / "a-k.json").is_file() and time.monotonic() < deadline:
        time.sleep(0.1)
    return process


def all_ended(group: int) -> bool:
    """Whether no process of a group is left within ten seconds."""
    for _ in range(100):
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.1)
    return False


WORDS = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated", signal.SIGHUP: "hung up"}


@pytest.mark.parametrize(
    ("number", "whole_group"),
    with_nightly(product(WORDS, (True, False)), [(signal.SIGINT, True), (signal.SIGTERM, False)]),
)
def test_a_signal_ends_all_processes_and_keeps_what_is_done(
    number: signal.Signals, whole_group: bool, working: subprocess.Popen[bytes], tmp_path: Path
) -> None:
    """Ctrl-C and a closed terminal reach the whole group, a scheduler may signal the first process alone."""
    if whole_group:
        os.killpg(working.pid, number)
    else:
        working.send_signal(number)
    _, complaint = working.communicate(timeout=120)
    assert (working.returncode, complaint.decode()) == (128 + number, f"{WORDS[number]}\n")
    assert all_ended(working.pid)
    assert files(tmp_path / "kept") == ["a-k.json"]
    assert json.loads((tmp_path / "kept" / "a-k.json").read_text())["name"] == "a"


def test_workers_end_with_their_parent_when_that_is_killed(working: subprocess.Popen[bytes]) -> None:
    working.kill()
    assert working.wait(timeout=120) == -signal.SIGKILL
    assert all_ended(working.pid)


def test_keys_change_with_versions_and_inputs(monkeypatch: pytest.MonkeyPatch) -> None:
    before = key(a=1, b=[2])
    assert key(b=[2], a=1) == before
    assert key(a=1, b=[3]) != before
    monkeypatch.setattr(work, "versions", lambda: {"python": "1"})
    assert key(a=1, b=[2]) != before
