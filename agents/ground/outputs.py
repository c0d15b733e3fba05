"""Writing files that a user asked for: to the user's path, through links, to a stream or to a device.

A file appears complete or not at all. Files in run folders and similar folders are written by `agents.ground.files`,
which follows no links, because such a folder may come from a stranger.
"""

from __future__ import annotations

import os
import stat
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

from pnt_gym.errors import one_sentence

from .cli import UsageError, check_libraries
from .files import json_text, replace_file
from .streams import destination, stream_of

VIDEOS: Final = (".mp4", ".gif")
PICTURES: Final = (".png", ".jpg", ".webp")
"""Endings of files to which a picture can be written."""


def deliver(path: Path, write: Callable[[Path], object]) -> None:
    """Let `write` fill a file, and move the file or its content to a user's path.

    Raises:
        UsageError: the path cannot be written.
    """
    try:
        place = destination(path)
        # No file can be renamed to a stream or a device.
        if stream_of(place) is not None or (place.exists() and not place.is_file()):
            # Let `write` fill a temporary file, and write its content to a stream or a device.
            with TemporaryDirectory() as folder:
                file = Path(folder) / place.name
                write(file)
                content = file.read_bytes()
            stream = stream_of(place)
            for printed in (sys.stdout, sys.stderr):
                printed.flush()
            with open(place, "wb") if stream is None else os.fdopen(os.dup(stream), "wb") as target:
                target.write(content)
        else:
            place.parent.mkdir(parents=True, exist_ok=True)
            replace_file(place, write)
    except OSError as error:
        raise _error(path, str(error.strerror)) from None


def deliver_text(path: Path, text: str) -> None:
    """Write text to a user's path.

    Raises:
        UsageError: the path cannot be written.
    """
    deliver(path, lambda place: place.write_bytes(text.encode()))


def deliver_json(path: Path, data: Any) -> None:
    """Write data as JSON to a user's path; a NaN in the data raises an error.

    Raises:
        UsageError: the path cannot be written.
    """
    deliver_text(path, json_text(data))


def check_ending(option: str, path: Path | None, endings: Sequence[str]) -> None:
    """Make sure that the file of an option, if given, has an ending that can be written.

    Raises:
        UsageError: the file has another ending.
    """
    if path is not None and path.suffix.lower() not in endings:
        raise UsageError(f"--{option} is {str(path)!r}; it must end in {' or '.join(endings)}")


def check_drawing(*, picture: Path | None = None, film: Path | None = None) -> None:
    """Make sure, before any work, that what a picture by matplotlib or a film needs is there.

    Args:
        picture: file of the picture; None for no picture.
        film: file of the film; None for no film.

    Raises:
        ModuleNotFoundError: a library is not installed.
        UsageError: this machine cannot render a film.
    """
    if picture is not None:
        check_libraries("matplotlib")
    if film is not None:
        check_libraries("imageio", "imageio_ffmpeg")
        from pnt_gym.cells.base.canvas import rendering_problem  # noqa: PLC0415 - imports the engine

        if problem := rendering_problem():
            raise UsageError(problem)


def check_writable(*paths: Path | None) -> None:
    """Make sure, before hours of work, that all `paths` that are not None can be written; nothing stays behind.

    Raises:
        UsageError: a path names a folder or a disk, or its folder cannot be made or written.
    """
    for path in paths:
        if path is not None:
            _check(path)


def _check(path: Path) -> None:
    try:
        place = destination(path)
        if stream_of(place) is not None:
            return
        kinds = {"a folder": stat.S_ISDIR, "a disk": stat.S_ISBLK, "a socket": stat.S_ISSOCK}
        mode = os.stat(place).st_mode if place.exists() else 0
        for kind, is_kind in kinds.items():
            if is_kind(mode):
                raise _error(path, f"it is {kind}")
        missing = [folder for folder in place.parents if not folder.exists()]
        place.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise _error(path, str(error.strerror)) from None
    is_open = os.access(place if place.exists() and not place.is_file() else place.parent, os.W_OK)
    for folder in missing:
        with suppress(OSError):  # another command may have written there meanwhile
            folder.rmdir()
    if not is_open:
        raise _error(path, "its folder is read-only")


def _error(path: Path, reason: str) -> UsageError:
    return UsageError(f"cannot write {one_sentence(repr(str(path)), 200)}: {reason}")
