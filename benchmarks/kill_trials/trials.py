"""Commands that are killed: at a file operation, at a byte, or at a moment, each in a fork of this process.

A fork has imported already what takes seconds to, and nothing else: this process has started no thread, opened no
environment and thrown nothing. What is killed is the whole command: the process that the user started with SIGKILL, and
a worker of it that came to the operation; its other workers have to end by themselves.
"""

from __future__ import annotations

import contextlib
import ctypes
import hashlib
import io
import json
import multiprocessing
import os
import resource
import runpy
import signal
import subprocess
import sys
import time
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, final
from unittest import mock
from zipfile import ZipFile

from agents.benchmark.run import Part
from agents.ground.files import LOCK
from agents.reproduce import papers
from agents.results import plan
from tests.tools.commands import environment

Line = Sequence[str]
FORK: Final = multiprocessing.get_context("fork")
CHANGES: Final = {
    "os.rename", "os.remove", "os.mkdir", "os.rmdir", "os.truncate", "os.link", "os.symlink", "os.chmod", "os.utime",
}  # fmt: skip
"""What Python tells an audit hook before it changes a folder; opening a file to write is the other."""
CLOCK: Final = ("seconds", "learn_seconds")
"""Keys of a JSON file that tell how long something took."""
PATIENCE: Final = 120.0
"""A command that takes longer hangs [s]."""
TORN: Final = -int(signal.SIGXFSZ)
SUBREAPER: Final = 36
"""Of prctl(2): a worker whose parent was killed is this process's child, and waited for."""


@final
@dataclass(frozen=True)
class Command:
    """A command that goes on when it is given again.

    Attributes:
        name: for people.
        prepare: fills the working folder before the first try.
        line: module and arguments, given the working folder as it was left.
    """

    name: str
    prepare: Callable[[Path], None]
    line: Callable[[Path], Line]


@final
@dataclass(frozen=True)
class Kill:
    """When a command is killed: at most one is given.

    Attributes:
        operation: before this change of its folder, counted from 1 over all of its processes.
        size: as soon as one of its files grows beyond so many bytes.
        moment: this long after it began [s].
    """

    operation: int = 0
    size: int = 0
    moment: float = 0.0


def start_fork(line: Line, folder: Path, log: Path, kill: Kill) -> int:
    """The exit code of a command in a fork of this process; negative for the signal that ended it.

    Raises:
        AssertionError: it hangs, or its workers outlive it.
    """
    ctypes.CDLL(None).prctl(SUBREAPER, 1, 0, 0, 0)
    counter = FORK.Value("q", 0)
    process = os.fork()
    if process == 0:
        code = 70
        try:
            os.setpgid(0, 0)
            _watch(folder, kill, counter)
            code = _run(line, folder, log)
        finally:
            os._exit(code)
    with contextlib.suppress(OSError):  # the child was faster
        os.setpgid(process, process)
    return _wait(process, kill.moment)


def start_process(line: Line, folder: Path, log: Path, kill: Kill) -> int:
    """The exit code of a command as a user starts it: in a new interpreter with new workers."""
    ctypes.CDLL(None).prctl(SUBREAPER, 1, 0, 0, 0)
    with log.open("w", encoding="utf-8") as words:
        command = [sys.executable, "-m", *line]
        process = subprocess.Popen(
            command, cwd=folder, env=environment(), stdout=words, stderr=words, start_new_session=True
        )
    code = _wait(process.pid, kill.moment)
    process.returncode = code  # it is waited for already
    return code


def _wait(process: int, moment: float) -> int:
    began = time.monotonic()
    while True:
        ended, status = os.waitpid(process, os.WNOHANG)
        if ended:
            break
        passed = time.monotonic() - began
        if passed > PATIENCE or 0.0 < moment < passed:
            os.kill(process, signal.SIGKILL)
            assert passed <= PATIENCE, "the command hangs"
        time.sleep(0.001)
    for _ in range(2000):
        try:
            if not os.waitpid(-process, os.WNOHANG)[0]:
                time.sleep(0.005)
        except ChildProcessError:
            return os.waitstatus_to_exitcode(status)
    os.killpg(process, signal.SIGKILL)
    raise AssertionError("workers outlive their command")


def _watch(folder: Path, kill: Kill, counter: Any) -> None:
    """Arrange in the child that the command is killed where it should be."""
    main, place = os.getpid(), str(folder.resolve())
    if kill.size:
        signal.signal(signal.SIGXFSZ, signal.SIG_DFL)  # Python ignores it and gets an error instead
        resource.setrlimit(resource.RLIMIT_FSIZE, (kill.size, kill.size))

    def heed(event: str, arguments: tuple[Any, ...]) -> None:
        if event == "open":
            path, _, flags = arguments
            if isinstance(path, int) or not flags & (os.O_WRONLY | os.O_RDWR):
                return
        elif event in CHANGES:
            path = arguments[0]
        else:
            return
        if not os.path.abspath(os.fsdecode(path)).startswith(place):
            return
        with counter.get_lock():
            counter.value += 1
            if counter.value == kill.operation:
                os.kill(main, signal.SIGKILL)
                os.kill(os.getpid(), signal.SIGKILL)

    if kill.operation:
        sys.addaudithook(heed)


def _run(line: Line, folder: Path, log: Path) -> int:
    """Run a command as `python -m` would, its words going to a file, or nowhere where sizes are watched."""
    os.chdir(folder)
    sys.argv = list(line)
    module = line[0]
    place = os.devnull if resource.getrlimit(resource.RLIMIT_FSIZE)[0] != resource.RLIM_INFINITY else log
    with (
        open(place, "w", encoding="utf-8") as words,
        contextlib.redirect_stdout(words),
        contextlib.redirect_stderr(words),
        mock.patch("agents.ground.work.multiprocessing.get_context", lambda _: FORK),
        mock.patch.object(plan, "code_digest", lambda *_, **__: "code"),
        mock.patch.object(papers, "code_digest", lambda *_, **__: "code"),
        mock.patch("agents.learning.runs.git_state", lambda: "commit\n"),
    ):
        warnings.filterwarnings("ignore", message=".*found in sys.modules", category=RuntimeWarning)
        try:
            runpy.run_module(module, run_name="__main__", alter_sys=True)
        except SystemExit as end:
            return end.code if isinstance(end.code, int) else int(end.code is not None)
        except BaseException:
            import traceback  # noqa: PLC0415 - rarely

            traceback.print_exc(file=words)
            return 1
    return 0


def state(folder: Path) -> dict[str, str]:
    """Digests of all files below a folder, by name, without the time that things took; leftovers too."""
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(_stable_content(path)).hexdigest()[:16] for path in files
    }


def _stable_content(path: Path) -> bytes:
    """What of a file has to be the same in every run."""
    if path.suffix == ".zip":
        return _model(path)
    if path.suffix == ".json":
        return json.dumps(_timeless(json.loads(path.read_text(encoding="utf-8"))), sort_keys=True).encode()
    if path.suffix == ".npz" and path.parent.name == "work":
        part = Part.read(path)
        return repr([_timeless([*part.results]), sorted(part.policies.items())]).encode()
    if path.name == "progress.csv":
        lines = [line.split(",") for line in path.read_text(encoding="utf-8").splitlines()]
        return repr([[*line[:1], *line[2:]] for line in lines]).encode()
    return b"" if path.name == "git.txt" else path.read_bytes()


def _model(path: Path) -> bytes:
    """Every tensor of a model, and what it counts."""
    import torch  # noqa: PLC0415 - only commands that learn need it

    def flat(value: Any, name: str) -> Iterator[str]:
        if isinstance(value, torch.Tensor):
            yield f"{name} {value.dtype} {tuple(value.shape)} {value.detach().numpy().tobytes().hex()}"
        elif isinstance(value, dict):
            for key in value:
                yield from flat(value[key], f"{name}/{key}")
        elif isinstance(value, list | tuple):
            for place, part in enumerate(value):
                yield from flat(part, f"{name}/{place}")
        else:
            yield f"{name} {value!r}"

    with ZipFile(path) as parts:
        data = json.loads(parts.read("data"))
        lines = [f"{name} {data.get(name)}" for name in ("num_timesteps", "_n_updates", "_episode_num")]
        for name in sorted(name for name in parts.namelist() if name.endswith(".pth")):
            tensors = torch.load(io.BytesIO(parts.read(name)), map_location="cpu", weights_only=True)
            lines += flat(tensors, name)
    return "\n".join(lines).encode()


def _timeless(data: Any) -> Any:
    if isinstance(data, dict):
        return {key: _timeless(value) for key, value in data.items() if key not in CLOCK}
    return [_timeless(value) for value in data] if isinstance(data, list) else data


def half_files(folder: Path) -> list[str]:
    """Files that are there under their name and not whole; temporary files are nobody's, and a lock is empty."""
    faults: list[str] = []
    for path in sorted(folder.rglob("*")):
        parts = path.relative_to(folder).parts
        temporary = any(part.startswith(".") and part.endswith(".tmp") for part in parts)
        if not path.is_file() or path.name == LOCK or temporary:
            continue
        try:
            if path.suffix in (".zip", ".npz"):
                with ZipFile(path) as file:
                    assert file.testzip() is None
            elif path.suffix == ".json":
                json.loads(path.read_text(encoding="utf-8"))
            else:
                text = path.read_text(encoding="utf-8")
                assert text.endswith("\n") or path.suffix == ".svg", "no end"
        except Exception as error:
            faults.append(f"{'/'.join(parts)}: {error!r}")
    return faults


def stale_models(folder: Path) -> list[str]:
    """Run folders whose model or policy on top is not that of their last checkpoint."""
    faults: list[str] = []
    for place in folder.rglob("checkpoints"):
        last = max(path for path in place.iterdir() if path.name.isdigit())
        names = ("model.zip", "policy.npz")
        if any((place.parent / name).read_bytes() != (last / name).read_bytes() for name in names):
            faults.append(str(place.parent))
    return faults


@final
class Trials:
    """Kills one command again and again, each time in a fresh folder, and lets it go on.

    Args:
        command: what is killed.
        folder: for the working folders.
        start: `start_fork` or `start_process`.
    """

    def __init__(
        self, command: Command, folder: Path, start: Callable[[Line, Path, Path, Kill], int] = start_fork
    ) -> None:
        self.start = start
        self.command, self.folder, self.log = command, folder, folder / f"{command.name}.log"
        self.kills, self.lost = 0, list[str]()
        began = time.monotonic()
        place = self._fresh("whole")
        code = self._start(place, Kill())
        assert code == 0, self.log.read_text(encoding="utf-8")
        self.seconds = time.monotonic() - began
        """How long the undisturbed command took [s]."""
        self.whole = state(place)
        self.largest = max(path.stat().st_size for path in place.rglob("*") if path.is_file())
        """Size of the largest file that it left [bytes]."""

    def kill_once(self, kill: Kill) -> bool:
        """Kill the command and let it go on; False if it came to its end before."""
        place = self._fresh("killed")
        code = self._start(place, kill)
        if code not in (-signal.SIGKILL, TORN):
            assert code == 0 or (kill.size and code), self.log.read_text(encoding="utf-8")
            return False
        self.kills += 1
        faults = "; ".join(self._find_faults(place))
        if faults:
            self.lost.append(f"{self.command.name} killed at {kill}: {faults}")
        return True

    def every_operation(self, step: int = 1) -> Iterator[Kill]:
        """Kill before every change of the folder, or every `step`-th, until the command comes to its end."""
        kill = Kill(operation=1)
        while self.kill_once(kill):
            yield kill
            kill = Kill(operation=kill.operation + step)

    def _find_faults(self, place: Path) -> list[str]:
        """What is wrong after a kill, and after the command was given again."""
        faults = half_files(place)
        code = self._start(place, Kill())
        if code != 0:
            words = " ".join(self.log.read_text(encoding="utf-8").split())
            # Nothing was left to do; that is said, and not done twice.
            if code != 2 or "give a larger --steps" not in words:
                return [*faults, f"exit code {code}: {words[-300:]}"]
        now = state(place)
        differ = sorted(name for name in now.keys() | self.whole.keys() if now.get(name) != self.whole.get(name))
        return [*faults, *(f"{name} differs" for name in differ), *stale_models(place)]

    def _start(self, place: Path, kill: Kill) -> int:
        return self.start(self.command.line(place), place, self.log, kill)

    def _fresh(self, name: str) -> Path:
        import shutil  # noqa: PLC0415

        place = self.folder / name
        shutil.rmtree(place, ignore_errors=True)
        place.mkdir(parents=True)
        self.command.prepare(place)
        return place
