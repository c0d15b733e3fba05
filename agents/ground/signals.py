"""Signals that end a command, all alike: SIGINT of Ctrl-C, SIGTERM of a scheduler, SIGHUP of a closed terminal."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Generator
from contextlib import contextmanager
from types import FrameType
from typing import Any, Final, NoReturn, TypeAlias

Handler: TypeAlias = Callable[[int, FrameType | None], Any] | int | None

REASONS: Final = {
    getattr(signal, name): reason
    for name, reason in (("SIGINT", "interrupted"), ("SIGTERM", "terminated"), ("SIGHUP", "hung up"))
    if hasattr(signal, name)  # Windows has no SIGHUP
}
"""What a command says at its end, by the signal that ended it."""


class Interrupt(KeyboardInterrupt):
    """A signal of `REASONS` that ends a command as Ctrl-C does."""

    def __init__(self, number: int = signal.SIGINT) -> None:
        super().__init__()
        self.number = number


def interrupt(number: int, _: FrameType | None) -> NoReturn:
    """Raise the interrupt of a signal; the handler of every signal of `REASONS`."""
    raise Interrupt(number)


@contextmanager
def handled(handler: Handler) -> Generator[None, None, None]:
    """A handler of all signals of `REASONS` in a block; other threads than the first have no handlers.

    A signal that this process was told to ignore, as `nohup` does with SIGHUP, stays ignored. SIGINT does not, because
    shells have every background job ignore SIGINT.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before: dict[int, Handler] = {}
    for number in REASONS:
        known = signal.getsignal(number)
        if known is not signal.SIG_IGN or number == signal.SIGINT:
            before[number] = known
            signal.signal(number, handler)
    try:
        yield
    finally:
        for number, known in before.items():
            signal.signal(number, known)


@contextmanager
def blocked() -> Generator[None, None, None]:
    """No signal of `REASONS` in a block: a process that starts there never gets any, this one gets them afterwards."""
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, set(REASONS))
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
