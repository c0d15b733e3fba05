"""Threads for compiled code: they work on parts of the lines at the same time."""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait
from functools import cache
from typing import Final

import numpy as np

from pnt_gym.arrays import Ints
from pnt_gym.cells.base.cell import MOST_THREADS

LEAST_LINES: Final = 8
"""Lines of a part at least; the start of a thread takes as long as some lines."""


@cache
def _pool() -> ThreadPoolExecutor:
    """The threads of this process; they begin when they are needed first."""
    return ThreadPoolExecutor(MOST_THREADS, thread_name_prefix="pnt_gym line")


# Threads do not survive a fork.
os.register_at_fork(after_in_child=_pool.cache_clear)


def work_in_parts(work: Callable[[Ints], None], lines: Ints, threads: int) -> None:
    """Call a function on parts of some lines, each part in a thread of its own.

    Args:
        work: works on a part of the lines (K,), independently of the other parts.
        lines: indices of the lines.
        threads: number of parts at most.
    """
    count = min(threads, len(lines) // LEAST_LINES)
    if count < 2:
        work(lines)
        return
    first, *later = np.array_split(lines, count)
    running = [_pool().submit(work, part) for part in later]
    try:
        work(first)
    finally:
        wait(running)
    for part in running:
        part.result()
