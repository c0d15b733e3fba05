"""Jobs that are done once: by processes side by side, each kept until something changes that it depends on."""

from __future__ import annotations

import hashlib
import json
import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, TypeAlias, final

from .cli import UsageError
from .files import check_writable, held, read_json, write_json
from .places import CODE, code_pattern
from .tables import throws_bar
from .versions import versions

Found: TypeAlias = dict[str, Any]
"""What a job found, JSON values by name."""
DRAWS_ONLY: Final = ("view.py", "canvas.py")
"""Code that shows a robot in its surroundings and changes no result."""


@final
@dataclass(frozen=True)
class Job:
    """A piece of work that one process does and one file keeps.

    Attributes:
        name: for people and for the file; "/" makes a folder.
        key: changes when anything changes that the result depends on (see `key`).
        run: does the work; it is sent to a process, gets the folder of all that is kept, and returns JSON values.
        cost: how much work it is compared with the other jobs.
    """

    name: str
    key: str
    run: Callable[[Path], Mapping[str, Any]]
    cost: int = 1

    @property
    def file(self) -> str:
        """Name of the file that keeps what it found, in the folder of all that is kept."""
        return f"{self.name}-{self.key}.json"


def code_digest(code: Iterable[str], without: Sequence[str] = (), root: Path = CODE) -> str:
    """Digest of the files that match any pattern of `code`, less those that match one of `without` or only draw."""
    digest = hashlib.sha256()
    for path in sorted({path for pattern in code for path in root.glob(code_pattern(pattern))}):
        if not any(path.match(pattern) for pattern in (*DRAWS_ONLY, *without)):
            digest.update(path.relative_to(root).as_posix().encode() + path.read_bytes())
    return digest.hexdigest()


def key(**inputs: Any) -> str:
    """Digest of the versions of packages and of whatever else a result depends on, JSON values by name."""
    text = json.dumps({**inputs, "versions": versions()}, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def do_missing(
    jobs: Sequence[Job], folder: Path, processes: int, *, fresh: bool = False, unit: str = "parts"
) -> list[Found]:
    """What every job found, in their order; those without a kept result are done first, `processes` at a time.

    A result is kept as soon as it is there, so what was interrupted goes on where it was.

    Args:
        jobs: what to do.
        folder: of all that is kept.
        processes: side by side.
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
            with workers(min(processes, len(missing))) as pool, throws_bar() as bar:
                task = bar.add_task(unit, total=total, completed=total - left)
                longest_first = sorted(missing, key=lambda job: -job.cost)
                with _interrupts_wait():
                    futures = {pool.submit(_timed, job, folder): job for job in longest_first}
                for future in as_completed(futures):
                    job, found = futures[future], future.result()
                    write_json(folder / job.file, found, indent=None)
                    bar.advance(task, job.cost)
                    bar.console.print(f"done: {job.name} ({found['seconds']:.0f} s)", markup=False)
        return [read_json(folder / job.file) for job in jobs]


@contextmanager
def workers(processes: int) -> Generator[Executor, None, None]:
    """What jobs are handed to: processes of one thread each; whatever ends the block ends them.

    Raises:
        UsageError: a process died, for instance for lack of memory.
    """
    os.environ["OMP_NUM_THREADS"] = "1"  # the workers inherit it: threads of theirs would fight for the cores
    pool = ProcessPoolExecutor(processes, multiprocessing.get_context("spawn"), initializer=_end_with_parent)
    try:
        yield pool
    except BrokenProcessPool:
        raise UsageError(
            "a worker process died, perhaps for lack of memory; run the command again with fewer --jobs to go on"
        ) from None
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        for process in multiprocessing.active_children():
            process.terminate()


def _timed(job: Job, folder: Path) -> Found:
    """What a job found and the seconds it took."""
    began = time.perf_counter()
    found = job.run(folder)
    return {"seconds": round(time.perf_counter() - began, 1), **found}


def _end_with_parent() -> None:
    """A worker whose parent is gone, however it went, has nobody to work for."""
    parent = multiprocessing.parent_process()

    def watch() -> None:
        if parent is not None:
            parent.join()
            os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


@contextmanager
def _interrupts_wait() -> Generator[None, None, None]:
    """Ctrl-C reaches all processes: those started in the block never heed it, this one does when the block is over."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
