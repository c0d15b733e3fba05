"""Signals that end a command, and paths that name an open stream of its process."""

from __future__ import annotations

import errno
import os
import signal
import threading
from collections.abc import Callable, Generator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FrameType
from typing import Any, Final, NoReturn, TypeAlias

STANDARD: Final = {"-": 1, "/dev/stdout": 1, "/dev/stderr": 2}
"""File descriptors of the standard streams by path."""
MOST_LINKS: Final = 40
"""Largest number of links that are followed, as in Linux."""


def destination(path: Path) -> Path:
    """The place to which a path leads: links are followed to a file, a place without a file, or an open stream.

    The links of /dev and /proc name open streams. A stream may be a file, but must not be replaced by another file.

    Raises:
        OSError: the links form a circle.
    """
    if str(path) in STANDARD:
        return path
    for _ in range(MOST_LINKS):
        if not path.is_symlink():
            return path
        path = Path(os.path.realpath(path.parent)) / path.name
        if stream_of(path) is not None:
            return path
        path = path.parent / path.readlink()
    raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), str(path))


def stream_of(place: Path) -> int | None:
    """File descriptor of the open stream that a destination names; None for a file."""
    if str(place) in STANDARD:
        return STANDARD[str(place)]
    is_descriptor = place.parent == Path(f"/proc/{os.getpid()}/fd") and place.name.isdecimal()
    return int(place.name) if is_descriptor else None


def is_printed(path: Path) -> bool:
    """Whether data written to a path go to standard output."""
    with suppress(OSError):  # reported when the path is written
        return stream_of(destination(path)) == 1
    return False


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
