"""Paths that name an open stream of this process instead of a file."""

from __future__ import annotations

import errno
import os
from contextlib import suppress
from pathlib import Path
from typing import Final

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
