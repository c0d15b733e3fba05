"""Threads over parts of the rows: one part is written or judged while another part is in the engine.

A row's result does not depend on the other rows, so the parts do not change a bit of the results.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from itertools import pairwise
from typing import Final, TypeVar

LEAST_ROWS: Final = 16
"""Fewest rows of a part: smaller parts lose more by the fixed cost of a throw, which each part pays, than they gain."""

ResultT = TypeVar("ResultT")


def split_rows(count: int, threads: int) -> list[slice]:
    """Rows of each part: as many parts as threads, of nearly the same size, but none smaller than `LEAST_ROWS`."""
    parts = max(min(threads, count // LEAST_ROWS), 1)
    return [slice(begin, end) for begin, end in pairwise(count * k // parts for k in range(parts + 1))]


def call_in_threads(calls: Sequence[Callable[[], ResultT]]) -> list[ResultT]:
    """Results of functions that run at the same time, the first one in this thread, the others in new threads.

    The threads end before this function does, also with an error. Numpy's settings of floating-point errors are those
    of the caller in all threads.

    Raises:
        Exception: of the first function, in the order of `calls`, that raises one.
    """
    with ThreadPoolExecutor(len(calls), thread_name_prefix="pnt_gym part") as pool:
        running = [pool.submit(copy_context().run, call) for call in calls[1:]]
        first = calls[0]()
    return [first, *(call.result() for call in running)]
