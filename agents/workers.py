"""Pieces of work done by processes side by side, one thread each."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager

from agents.cli import UsageError


def quiet_interrupt() -> None:
    """Prepare a worker process: Ctrl-C ends it without a word, the parent says what happened."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


@contextmanager
def workers(jobs: int, prepare: Callable[[], None] = quiet_interrupt) -> Iterator[Executor]:
    """A pool of `jobs` processes, each prepared by `prepare`; whatever ends the block ends them.

    Raises:
        UsageError: a worker died, for instance for lack of memory.
    """
    os.environ["OMP_NUM_THREADS"] = "1"  # the workers inherit it: threads of theirs would fight for the cores
    pool = ProcessPoolExecutor(jobs, multiprocessing.get_context("spawn"), initializer=prepare)
    try:
        yield pool
    except BrokenProcessPool:
        raise UsageError(
            "a worker process died, perhaps for lack of memory; run the command again with fewer --jobs to go on"
        ) from None
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        for process in multiprocessing.active_children():
            os.kill(process.pid or 0, signal.SIGTERM)
