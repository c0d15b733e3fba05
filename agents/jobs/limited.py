"""Calls in a process of their own, which ends when a call takes longer than allowed."""

from __future__ import annotations

from collections.abc import Callable, Generator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import TypeVar, final

from pnt_gym.errors import PntGymError

from ..ground.signals import block_signals
from .work import end_processes, start_processes

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
            self._pool = start_processes(1)
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
            end_processes(self._pool)
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
