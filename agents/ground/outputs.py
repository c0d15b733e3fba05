"""What a user asked a command to write: it goes where the user pointed, through links, to a stream or a device.

A file appears complete or not at all. Other files, in run folders and the like, are written by
`agents.ground.files`, which follows no link: a folder may be a stranger's.
"""

from __future__ import annotations

import os
import stat
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

from pnt_gym.errors import one_sentence

from .cli import UsageError
from .files import json_text, replace_file
from .streams import destination, stream_of

VIDEOS: Final = (".mp4", ".gif")
PICTURES: Final = (".png", ".jpg", ".webp")
"""Endings of files that can be drawn."""


def deliver(path: Path, write: Callable[[Path], object]) -> None:
    """Let `write` fill a file, and bring it to where a path of the user's points.

    Raises:
        UsageError: the place cannot be written.
    """
    try:
        place = destination(path)
        if _is_written_straight(place):
            _pour(place, write)
        else:
            place.parent.mkdir(parents=True, exist_ok=True)
            replace_file(place, write)
    except OSError as error:
        raise _refused(path, str(error.strerror)) from None


def deliver_text(path: Path, text: str) -> None:
    """Write text to where a path of the user's points.

    Raises:
        UsageError: the place cannot be written.
    """
    deliver(path, lambda place: place.write_bytes(text.encode()))


def deliver_json(path: Path, data: Any, *, indent: int | None = 1) -> None:
    """Write data as JSON to where a path of the user's points; a NaN in the data is an error.

    Raises:
        UsageError: the place cannot be written.
    """
    deliver_text(path, json_text(data, indent=indent))


def _is_written_straight(place: Path) -> bool:
    """Whether nothing can be renamed to a place: it is a stream or a device."""
    return stream_of(place) is not None or (place.exists() and not place.is_file())


def _pour(place: Path, write: Callable[[Path], object]) -> None:
    """Let `write` fill a file elsewhere, and write its content into a stream or a device."""
    with TemporaryDirectory() as folder:
        file = Path(folder) / place.name
        write(file)
        content = file.read_bytes()
    stream = stream_of(place)
    for printed in (sys.stdout, sys.stderr):
        printed.flush()
    with open(place, "wb") if stream is None else os.fdopen(os.dup(stream), "wb") as target:
        target.write(content)


def check_ending(option: str, path: Path | None, endings: Sequence[str]) -> None:
    """Make sure that the file of an option, if there is one, is of a kind that can be written.

    Raises:
        UsageError: it has another ending.
    """
    if path is not None and path.suffix.lower() not in endings:
        raise UsageError(f"--{option} is {str(path)!r}; it must end in {' or '.join(endings)}")


def check_writable(*paths: Path | None) -> None:
    """Find out before hours of work whether those of `paths` that were asked for can be written after them.

    Raises:
        UsageError: one names a folder or a disk, or its folder cannot be made or written.
    """
    for path in paths:
        if path is not None:
            _check_place(path)


def _check_place(path: Path) -> None:
    try:
        place = destination(path)
        if stream_of(place) is not None:
            return
        if place.exists() and (reason := _refusal(os.stat(place).st_mode)):
            raise _refused(path, f"it is {reason}")
        place.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise _refused(path, str(error.strerror)) from None
    if not os.access(place if place.exists() and not place.is_file() else place.parent, os.W_OK):
        raise _refused(path, "its folder is read-only")


def _refused(path: Path, reason: str) -> UsageError:
    return UsageError(f"cannot write {one_sentence(repr(str(path)), 200)}: {reason}")


def _refusal(mode: int) -> str:
    """What a place of this mode is, if nothing may be written there."""
    kinds = {"a folder": stat.S_ISDIR, "a disk": stat.S_ISBLK, "a socket": stat.S_ISSOCK}
    return next((name for name, test in kinds.items() if test(mode)), "")
