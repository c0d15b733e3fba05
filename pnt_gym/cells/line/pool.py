"""Threads for compiled code: they work on parts of the lines at the same time."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable
from functools import cache
from queue import SimpleQueue
from threading import Thread
from typing import Final, TypeAlias

import numpy as np

from pnt_gym.arrays import Ints

LEAST_LINES: Final = 8
"""Lines of a part at least; a call takes as long as some lines."""
Job: TypeAlias = tuple[Callable[[Ints], None], deque[Ints], SimpleQueue[Exception | None]]
"""Work, the parts that no thread has taken yet, and a report of each part that a helper has finished."""


def _help(jobs: SimpleQueue[Job]) -> None:
    """Take parts of one job after the other, without end."""
    while True:
        work, parts, reports = jobs.get()
        while (part := _take_part(parts)) is not None:
            report = None
            try:
                work(part)
            except Exception as error:
                report = error
            reports.put(report)
        # A waiting thread keeps no line alive.
        del work, parts, reports, part


def _take_part(parts: deque[Ints]) -> Ints | None:
    try:
        return parts.popleft()
    except IndexError:
        return None


@cache
def _helper(number: int) -> SimpleQueue[Job]:
    """Queue of the jobs of one helping thread of this process; the thread begins when it is needed first."""
    jobs: SimpleQueue[Job] = SimpleQueue()
    Thread(target=_help, args=(jobs,), name=f"pnt_gym line {number}", daemon=True).start()
    return jobs


# Threads do not survive a fork.
os.register_at_fork(after_in_child=_helper.cache_clear)


def work_in_parts(work: Callable[[Ints], None], lines: Ints, threads: int) -> None:
    """Call a function on parts of some lines, in several threads.

    Args:
        work: works on a part of the lines (K,), independently of the other parts.
        lines: indices of the lines.
        threads: number of threads at most.
    """
    count = min(threads, len(lines) // LEAST_LINES)
    if count < 2:
        work(lines)
        return
    # A thread that wakes late leaves its part to the others.
    division = np.array_split(lines, count)
    parts, reports, awaited = deque(division), SimpleQueue[Exception | None](), len(division)
    for number in range(count - 1):
        _helper(number).put((work, parts, reports))
    try:
        while (part := _take_part(parts)) is not None:
            awaited -= 1
            work(part)
    finally:
        while _take_part(parts) is not None:
            awaited -= 1
        errors = [reports.get() for _ in range(awaited)]
    for error in errors:
        if error is not None:
            raise error
