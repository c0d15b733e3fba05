"""Jobs that are done once, here or elsewhere, each kept until something changes that it depends on."""

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
from typing import Any, NamedTuple, Protocol, TypeAlias, final

from ..ground.cli import UsageError
from ..ground.files import held, read_json, write_bytes
from ..ground.outputs import check_writable
from ..ground.signals import blocked
from ..ground.tables import throws_bar
from ..ground.versions import versions

Found: TypeAlias = dict[str, Any]
"""What a job found, JSON values by name."""


@final
@dataclass(frozen=True)
class Job:
    """A piece of work that one process does and one file keeps.

    Attributes:
        name: for people and for the file; "/" makes a folder.
        key: changes when anything changes that the result depends on (see `key`).
        run: does the work; it is sent to a process, gets the folder of all that is kept, and returns JSON values, or
            the file that keeps what it found.
        cost: how much work it is compared with the other jobs.
        suffix: of that file.
    """

    name: str
    key: str
    run: Callable[[Path], Mapping[str, Any] | bytes]
    cost: int = 1
    suffix: str = "json"

    @property
    def file(self) -> str:
        """Name of the file that keeps what it found, in the folder of all that is kept."""
        return f"{self.name}-{self.key}.{self.suffix}"


class Done(NamedTuple):
    """What became of a job.

    Attributes:
        found: the file that keeps it.
        seconds: that it took.
        where: it was done, if not here; for the line that says that it is done.
    """

    found: bytes
    seconds: float
    where: str = ""


class Pool(Protocol):
    """Who does jobs."""

    def __call__(self, jobs: Sequence[Job], folder: Path, /) -> AbstractContextManager[Iterator[tuple[Job, Done]]]:
        """The jobs as they end, begun in their order; whatever ends the block ends the work.

        Args:
            jobs: what to do, at least one.
            folder: of all that is kept on this machine; jobs done elsewhere get another, which is empty.
        """
        ...


def key(**inputs: Any) -> str:
    """Digest of the versions of packages and of whatever else a result depends on, JSON values by name."""
    text = json.dumps({**inputs, "versions": versions()}, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def do_missing(
    jobs: Sequence[Job], folder: Path, pool: Pool, *, fresh: bool = False, unit: str = "parts"
) -> list[Found]:
    """What every job found as JSON values; the arguments are those of `keep_missing`."""
    return [read_json(path) for path in keep_missing(jobs, folder, pool, fresh=fresh, unit=unit)]


def keep_missing(
    jobs: Sequence[Job], folder: Path, pool: Pool, *, fresh: bool = False, unit: str = "parts"
) -> list[Path]:
    """The files of what every job found, in their order; those without a kept result are done first.

    A result is kept as soon as it is there, so what was interrupted goes on where it was.

    Args:
        jobs: what to do.
        folder: of all that is kept.
        pool: who does it.
        fresh: do also what has been done.
        unit: what the costs count, for the progress bar.

    Raises:
        UsageError: a process died, for instance for lack of memory; or another command works in the folder.
    """
    check_writable(folder / "piece.json")
    with held(folder):
        missing = [job for job in jobs if fresh or not (folder / job.file).is_file()]
        if missing:
            left, total = (sum(job.cost for job in some) for some in (missing, jobs))
            longest_first = sorted(missing, key=lambda job: -job.cost)
            with pool(longest_first, folder) as ended, throws_bar() as bar:
                task = bar.add_task(unit, total=total, completed=total - left)
                for job, done in ended:
                    write_bytes(folder / job.file, done.found)
                    bar.advance(task, job.cost)
                    bar.console.print(f"done: {job.name} ({done.seconds:.0f} s{done.where})", markup=False)
    return [folder / job.file for job in jobs]


def processes(count: int) -> Pool:
    """A pool of processes on this machine."""
    return partial(_side_by_side, count)


@contextmanager
def _side_by_side(count: int, jobs: Sequence[Job], folder: Path) -> Generator[Iterator[tuple[Job, Done]], None, None]:
    """Processes of one thread each; whatever ends the block ends them.

    Raises:
        UsageError: a process died, for instance for lack of memory.
    """
    os.environ["OMP_NUM_THREADS"] = "1"  # the workers inherit it: threads of theirs would fight for the cores
    spawning = multiprocessing.get_context("spawn")
    with blocked():
        # Python's keeper of semaphores starts here too.
        pool = ProcessPoolExecutor(min(count, len(jobs)), spawning, initializer=_end_with_parent)
    try:
        with blocked():
            futures = {pool.submit(do, job, folder): job for job in jobs}
        yield ((futures[future], future.result()) for future in as_completed(futures))
    except BrokenProcessPool:
        raise UsageError(
            "a worker process died, perhaps for lack of memory; run the command again with fewer --jobs to go on"
        ) from None
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        for process in multiprocessing.active_children():
            process.kill()  # workers heed no other signal


def do(job: Job, folder: Path) -> Done:
    """What a job found, as it is kept, and the seconds it took."""
    began = time.perf_counter()
    found = job.run(folder)
    seconds = time.perf_counter() - began
    if isinstance(found, bytes):
        return Done(found, seconds)
    text = json.dumps({"seconds": round(seconds, 1), **found}, allow_nan=False)
    return Done(f"{text}\n".encode(), seconds)


def _end_with_parent() -> None:
    """A worker whose parent is gone, however it went, has nobody to work for."""
    parent = multiprocessing.parent_process()

    def watch() -> None:
        if parent is not None:
            parent.join()
            os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
