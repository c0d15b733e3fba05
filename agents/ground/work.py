"""Jobs whose results are kept in files until something changes that a result depends on."""

from __future__ import annotations

import hashlib
import json
import multiprocessing
import os
import threading
import time
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple, Protocol, TypeAlias, TypeVar, final

from pnt_gym.errors import PntGymError

from .cli import UsageError, user_code
from .files import lock_folder, read_json, write_bytes
from .outputs import check_writable
from .streams import block_signals
from .tables import throws_bar
from .versions import versions

JobValues: TypeAlias = dict[str, Any]
"""Result of a job, JSON values by name."""


@final
@dataclass(frozen=True)
class Job:
    """A piece of work that one process does and whose result one file keeps.

    Attributes:
        name: name for people and for the file; "/" makes a folder.
        key: digest of everything that the result depends on (see `key`).
        run: function that a process calls with the folder of all results; returns JSON values, or the content of the
            file.
        cost: amount of work, relative to the other jobs.
        suffix: suffix of the file.
    """

    name: str
    key: str
    run: Callable[[Path], Mapping[str, Any] | bytes]
    cost: int = 1
    suffix: str = "json"

    @property
    def file(self) -> str:
        """Name of the file that keeps the result, in the folder of all results."""
        return f"{self.name}-{self.key}.{self.suffix}"


class Completion(NamedTuple):
    """Result of a job that is done.

    Attributes:
        content: content of the file that keeps the result.
        seconds: duration of the job [s].
        where: the machine that did the job, as text for the progress line; empty for this machine.
    """

    content: bytes
    seconds: float
    where: str = ""


class Pool(Protocol):
    """A way to do jobs: processes of this machine, or the machines of a cluster."""

    def __call__(
        self, jobs: Sequence[Job], folder: Path, /
    ) -> AbstractContextManager[Iterator[tuple[Job, Completion]]]:
        """Jobs as they end, begun in the given order; the end of the block ends the work.

        Args:
            jobs: the jobs, at least one.
            folder: folder of all results on this machine; jobs on other machines get an empty folder.
        """
        ...


def key(**inputs: Any) -> str:
    """Digest of the versions of packages and of all other inputs of a result, JSON values by name."""
    text = json.dumps({**inputs, "versions": versions()}, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def do_missing(
    jobs: Sequence[Job], folder: Path, pool: Pool, *, fresh: bool = False, unit: str = "parts"
) -> list[JobValues]:
    """Results of all jobs as JSON values; the arguments are those of `keep_missing`."""
    return [read_json(path) for path in keep_missing(jobs, folder, pool, fresh=fresh, unit=unit)]


def keep_missing(
    jobs: Sequence[Job], folder: Path, pool: Pool, *, fresh: bool = False, unit: str = "parts"
) -> list[Path]:
    """Do the jobs without a kept result; the files of all results, in the order of the jobs.

    Each result is kept as soon as its job ends, so an interrupted command goes on where it stopped.

    Args:
        jobs: the jobs.
        folder: folder of all results.
        pool: does the jobs.
        fresh: repeat jobs that have a kept result.
        unit: unit of the costs, for the progress bar.

    Raises:
        UsageError: a process died, for instance for lack of memory, or another command works in the folder.
    """
    check_writable(folder / "piece.json")
    folder.mkdir(parents=True, exist_ok=True)
    with lock_folder(folder):
        missing = [job for job in jobs if fresh or not (folder / job.file).is_file()]
        if missing:
            left, total = (sum(job.cost for job in group) for group in (missing, jobs))
            longest_first = sorted(missing, key=lambda job: -job.cost)
            with pool(longest_first, folder) as ended, throws_bar() as bar:
                task = bar.add_task(unit, total=total, completed=total - left)
                for job, completion in ended:
                    write_bytes(folder / job.file, completion.content)
                    bar.advance(task, job.cost)
                    bar.console.print(f"done: {job.name} ({completion.seconds:.0f} s{completion.where})", markup=False)
    return [folder / job.file for job in jobs]


def processes(count: int) -> Pool:
    """A pool of processes on this machine."""
    return partial(_side_by_side, count)


@contextmanager
def _side_by_side(
    count: int, jobs: Sequence[Job], folder: Path
) -> Generator[Iterator[tuple[Job, Completion]], None, None]:
    """Do jobs in processes of one thread each; the end of the block ends the processes.

    Raises:
        UsageError: a process died, for instance for lack of memory.
    """
    pool = _start(min(count, len(jobs)))
    try:
        with block_signals():
            futures = {pool.submit(run, job, folder): job for job in jobs}
        yield ((futures[future], future.result()) for future in as_completed(futures))
    except BrokenProcessPool:
        raise UsageError(
            "a worker process died, perhaps for lack of memory; run the command again with fewer --jobs to go on"
        ) from None
    finally:
        _end(pool)


def _start(count: int) -> ProcessPoolExecutor:
    """Processes of one thread each, which end with this process."""
    os.environ["OMP_NUM_THREADS"] = "1"  # the workers inherit the variable: more threads would compete for the cores
    spawning = multiprocessing.get_context("spawn")
    with block_signals():
        # Python's resource tracker starts here too.
        return ProcessPoolExecutor(count, spawning, initializer=_end_with_parent)


def _end(pool: ProcessPoolExecutor) -> None:
    """End processes at once, whatever they do."""
    pool.shutdown(wait=False, cancel_futures=True)
    for process in multiprocessing.active_children():
        process.kill()  # workers block all other signals


def run(job: Job, folder: Path) -> Completion:
    """Run a job; its result as file content, and its duration."""
    began = time.perf_counter()
    with user_code(f"{job.name}: a module or class of yours"):
        outcome = job.run(folder)
    seconds = time.perf_counter() - began
    if isinstance(outcome, bytes):
        return Completion(outcome, seconds)
    text = json.dumps({"seconds": round(seconds, 1), **outcome}, allow_nan=False)
    return Completion(f"{text}\n".encode(), seconds)


def _end_with_parent() -> None:
    """End this worker process when its parent process ends, however the parent ends."""
    parent = multiprocessing.parent_process()

    def watch() -> None:
        if parent is not None:
            parent.join()
            os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


Answer = TypeVar("Answer")


class UnfinishedError(PntGymError):
    """A call that was not done in time, or whose process died; the message says which."""


@final
class LimitedWorker:
    """A process that does one call after the other, each within a limited time.

    Args:
        seconds: longest time of a call [s].
    """

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds
        self._pool: ProcessPoolExecutor | None = None

    def call(self, function: Callable[..., Answer], *arguments: object) -> Answer:
        """What a function returns in the process; its errors are raised here.

        Raises:
            UnfinishedError: the call took too long, or the process died.
        """
        if self._pool is None:
            self._pool = _start(1)
            self._pool.submit(_begin).result()  # the start of the process takes no time of the call
        with block_signals():
            future = self._pool.submit(function, *arguments)
        try:
            return future.result(self.seconds)
        except TimeoutError:
            self.close()
            raise UnfinishedError(f"not done after {self.seconds:g} s") from None
        except BrokenProcessPool:
            self.close()
            raise UnfinishedError("its process died, perhaps for lack of memory") from None

    def close(self) -> None:
        """End the process; the next call starts another one."""
        if self._pool is not None:
            _end(self._pool)
        self._pool = None


@contextmanager
def limited_worker(seconds: float) -> Generator[LimitedWorker, None, None]:
    """A process for calls of at most so many seconds each, which ends with the block."""
    worker = LimitedWorker(seconds)
    try:
        yield worker
    finally:
        worker.close()


def _begin() -> None:
    """Call of a process that has just started."""
