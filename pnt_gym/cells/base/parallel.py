"""Threads over parts of the rows: one part is written or judged while another part is in the engine or in machine code.

A row's result does not depend on the other rows, so the parts do not change a bit of the results.
"""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Sequence
from contextvars import copy_context
from functools import cache, partial
from itertools import chain, pairwise
from queue import SimpleQueue
from threading import Thread
from typing import Any, Final, TypeAlias, TypeVar

from pnt_gym.arrays import Ints, take

LEAST_ROWS: Final = 16
"""Fewest rows of a part: smaller parts lose more by the fixed cost of a throw, which each part pays, than they gain."""
LEAST_LINES: Final = 8
"""Fewest lines of a part; a call takes as long as some lines."""
LINES_OF_CALL: Final = 40
"""Lines that take as long as a call beside them."""

ResultT = TypeVar("ResultT")
Job: TypeAlias = tuple[Callable[[int], None], deque[int], SimpleQueue[None]]
"""Work, the parts that no thread has taken yet, and a report of each part that a helping thread has finished."""


def split_rows(count: int, threads: int) -> list[slice]:
    """Rows of each part: as many parts as threads, of nearly the same size, but none smaller than `LEAST_ROWS`."""
    parts = max(min(threads, count // LEAST_ROWS), 1)
    return [slice(begin, end) for begin, end in pairwise(count * k // parts for k in range(parts + 1))]


def write_in_parts(function: Callable[..., None], arguments: tuple[Any, ...], count: int, threads: int) -> None:
    """Call a function on parts of the rows of its arguments, in several threads.

    Args:
        function: writes results into rows of its arguments, independently of the other rows.
        arguments: its arguments, whose arrays have N rows each, also those in records and tuples.
        count: number of rows N.
        threads: number of threads at most.
    """
    call_in_threads([partial(function, *take(arguments, rows)) for rows in split_rows(count, threads)])


def work_in_parts(
    work: Callable[[Ints], None], lines: Ints, threads: int, calls: Sequence[Callable[[], None]] = ()
) -> None:
    """Call a function on parts of some lines, in several threads.

    Args:
        work: works on a part of the lines (K,), independently of the other parts.
        lines: indices of the lines.
        threads: number of threads at most.
        calls: functions that work on something else at the same time, each as long as `LINES_OF_CALL` lines take.
    """
    # A part for each thread; the first thread, which has the calls, has fewer lines.
    size = len(lines) + len(calls) * LINES_OF_CALL
    count = max(min(threads, size // LEAST_LINES), 1) - 1
    first = round(size / (count + 1)) - len(calls) * LINES_OF_CALL if count > 0 else len(lines)
    first = min(max(first, 0), len(lines))
    ends = [first + (len(lines) - first) * k // max(count, 1) for k in range(count + 1)]
    parts = [lines[begin:end] for begin, end in pairwise([0, *ends])]
    own, *others = [[partial(work, part)] if len(part) > 0 else [] for part in parts]
    # This thread makes the calls, whose Python would keep this thread from the ends of its own parts.
    call_in_threads([*calls[:1], *chain(*others), *calls[1:], *own], threads)


def call_in_threads(calls: Sequence[Callable[[], ResultT]], threads: int | None = None) -> list[ResultT]:
    """Results of functions that run at the same time, in this thread and in threads that help.

    A thread that wakes late leaves its function to the others. No function runs on when this function ends, also with
    an error; in a single thread the functions after an error do not begin. Numpy's settings of floating-point errors
    are those of the caller in all threads.

    Args:
        calls: the functions, in the order in which they begin.
        threads: number of threads at most; None for a thread for each function.

    Raises:
        BaseException: of the first function, in the order of `calls`, that raises one.
    """
    if 1 in (len(calls), threads):
        return [call() for call in calls]
    contexts, results, errors = [copy_context() for _ in calls], dict[int, ResultT](), dict[int, BaseException]()

    def work(part: int) -> None:
        try:
            results[part] = contexts[part].run(calls[part])
        except BaseException as error:  # raised below, in the caller's thread
            errors[part] = error

    parts, reports, awaited = deque(range(len(calls))), SimpleQueue[None](), len(calls)
    for number in range(min(len(calls), threads or len(calls)) - 1):
        _helper(number).put((work, parts, reports))
    try:
        while (part := _take_part(parts)) is not None:
            awaited -= 1
            work(part)
    finally:
        while _take_part(parts) is not None:
            awaited -= 1
        for _ in range(awaited):
            reports.get()
    if errors:
        raise errors[min(errors)]
    return [results[part] for part in range(len(calls))]


@cache
def _helper(number: int) -> SimpleQueue[Job]:
    """Queue of the jobs of one helping thread of this process; the thread begins when it is needed first."""
    jobs: SimpleQueue[Job] = SimpleQueue()
    Thread(target=_help, args=(jobs,), name=f"pnt_gym part {number}", daemon=True).start()
    return jobs


# Threads do not survive a fork, which Windows does not have.
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_helper.cache_clear)


def _help(jobs: SimpleQueue[Job]) -> None:
    """Take parts of one job after the other, without end."""
    while True:
        work, parts, reports = jobs.get()
        while (part := _take_part(parts)) is not None:
            work(part)
            reports.put(None)
        # A waiting thread keeps no cell alive.
        del work, parts, reports, part


def _take_part(parts: deque[int]) -> int | None:
    try:
        return parts.popleft()
    except IndexError:
        return None
