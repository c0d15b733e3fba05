"""Signals that end a command, treated alike: SIGINT of Ctrl-C, SIGTERM of a scheduler, SIGHUP of a terminal."""

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
"""Last word of a command by the signal that ended the command."""


class Interrupt(KeyboardInterrupt):
    """A signal of `REASONS` that ends a command as Ctrl-C does."""

    def __init__(self, number: int = signal.SIGINT) -> None:
        super().__init__()
        self.number = number


def interrupt(number: int, _: FrameType | None) -> NoReturn:
    """Raise the interrupt of a signal; the handler of every signal of `REASONS`."""
    raise Interrupt(number)


@contextmanager
def handle_signals(handler: Handler) -> Generator[None, None, None]:
    """Install a handler of all signals of `REASONS` during the block; does nothing outside the main thread.

    A signal that this process ignores from its start, as SIGHUP under `nohup`, stays ignored. SIGINT is handled even
    then, because shells make every background job ignore SIGINT.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before: dict[int, Handler] = {}
    for number in REASONS:
        previous = signal.getsignal(number)
        if previous is not signal.SIG_IGN or number == signal.SIGINT:
            before[number] = previous
            signal.signal(number, handler)
    try:
        yield
    finally:
        for number, previous in before.items():
            signal.signal(number, previous)


@contextmanager
def block_signals() -> Generator[None, None, None]:
    """Block the signals of `REASONS` in a block: child processes inherit the mask, this process gets them later."""
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, set(REASONS))
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
