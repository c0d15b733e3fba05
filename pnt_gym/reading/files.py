"""Regular files of a bounded size: bytes, text, lines and JSON."""

from __future__ import annotations

import errno
import io
import json
import os
import stat
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO, Final, cast

from pnt_gym.errors import PntGymError, one_sentence

MOST_TEXT: Final = 2**18
"""Bytes of a level, a plan or the like; PyYAML takes two seconds for so many brackets."""
LONGEST_LINE: Final = 2**16
"""Characters of a line in a file that is read line by line."""

MOST_DIGITS: Final = 300
"""Digits of an integer, so that it can be a float too."""


class ReadError(PntGymError):
    """A file that is not what is to be read; the message tells why, without the file's name and content."""


class AccessError(ReadError):
    """A file that is not there, no regular file, or too large; the content was not looked at."""


@contextmanager
def opened(path: str | Path, most: int) -> Generator[BinaryIO, None, None]:
    """A regular file of a bounded size, open for reading.

    Args:
        path: of the file.
        most: bytes that it may have.

    Raises:
        AccessError: there is no such file, it is a folder, a device or a pipe, or it is larger.
    """
    try:
        # Without O_NONBLOCK the opening of a pipe waits for somebody who writes.
        descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    except OSError as error:
        raise AccessError(error.strerror or str(error)) from None
    except ValueError:  # a NUL in the name
        raise AccessError("no file can have this name") from None
    kind = os.fstat(descriptor).st_mode
    if not stat.S_ISREG(kind):
        os.close(descriptor)
        raise AccessError(os.strerror(errno.EISDIR) if stat.S_ISDIR(kind) else "it is no regular file")
    with os.fdopen(descriptor, "rb") as file:
        check_size("it", os.fstat(descriptor).st_size, most)
        yield cast("BinaryIO", file)


def check_size(what: str, size: int, most: int) -> None:
    """Make sure that something has no more bytes than are read.

    Raises:
        AccessError: it has.
    """
    if size > most:
        raise AccessError(f"{what} has {size:,} bytes; at most {most:,} are read")


def bytes_of(path: str | Path, most: int) -> bytes:
    """The content of a file.

    Args:
        path: of the file.
        most: bytes that it may have.

    Raises:
        AccessError: there is no such file, or it is too large.
    """
    with opened(path, most) as file:
        try:
            data = file.read(most + 1)  # files of /proc have size 0
        except OSError as error:
            raise AccessError(error.strerror or str(error)) from None
    check_size("it", len(data), most)
    return data


def text_of(path: str | Path, most: int = MOST_TEXT, form: str = "text") -> str:
    """The text of a file.

    Args:
        path: of the file.
        most: bytes that it may have.
        form: what the file should hold, for the error.

    Raises:
        ReadError: there is no such file, it is too large, or no text.
    """
    data = bytes_of(path, most)
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError as error:
        raise ReadError(f"it is not valid {form}: byte {error.start + 1} is not UTF-8") from None


def lines_of(path: str | Path, most: int, most_lines: int) -> Iterator[str]:
    """The lines of a text file with their ends, one after the other; memory holds one of the lines.

    Args:
        path: of the file.
        most: bytes that it may have.
        most_lines: lines that it may have.

    Raises:
        ReadError: there is no such file, it is too large, it is no text, or one of its lines is too long.
    """
    with opened(path, most) as file, io.TextIOWrapper(file, encoding="utf-8-sig", newline="") as text:
        try:
            size = 0
            for number in range(1, most_lines + 2):
                line = text.readline(LONGEST_LINE + 1)
                if not line:
                    return
                size += len(line)
                check_size("it", size, most)  # files of /proc have size 0
                if number > most_lines:
                    raise AccessError(f"it has more than {most_lines:,} lines")
                if len(line) > LONGEST_LINE:
                    raise AccessError(f"its line {number:,} has more than {LONGEST_LINE:,} characters")
                yield line
        except UnicodeDecodeError as error:
            raise ReadError(f"it is not valid text: {error.reason}; it must be UTF-8") from None
        except OSError as error:
            raise AccessError(error.strerror or str(error)) from None


def json_of(path: str | Path, most: int = MOST_TEXT) -> Any:
    """The data of a JSON file; arguments and errors are those of `text_of`, and text that is not JSON."""
    return parsed_json(text_of(path, most, "JSON"))


def parsed_json(text: str | bytes) -> Any:
    """The data of JSON text.

    Raises:
        ReadError: it is not JSON, a key stands twice in an object, its brackets are too deep, or an integer is so large
            that it is no float.
    """
    try:
        return json.loads(text, object_pairs_hook=_single_keys, parse_int=_integer)
    except json.JSONDecodeError as error:
        raise ReadError(f"it is not valid JSON: {error.msg}: line {error.lineno} column {error.colno}") from None
    except (RecursionError, ValueError) as error:
        raise ReadError(f"it is not valid JSON: {cause_of(error)}") from None


def _single_keys(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """A JSON object.

    Raises:
        ValueError: a key stands twice in it.
    """
    data = dict(pairs)
    if len(data) < len(pairs):
        keys = [key for key, _ in pairs]
        twice = next(key for key in keys if keys.count(key) > 1)
        raise ValueError(f"key {one_sentence(repr(twice), 60)} is given twice")
    return data


def _integer(digits: str) -> int:
    """An integer of JSON.

    Raises:
        ValueError: it is larger than every float.
    """
    if len(digits) > MOST_DIGITS:
        raise ValueError(f"an integer has {len(digits):,} digits; at most {MOST_DIGITS} are read")
    return int(digits)


def cause_of(error: Exception) -> str:
    """What a parser complains of, in a few words."""
    if isinstance(error, RecursionError):
        return "its brackets are too deep"
    return one_sentence(error, 100)
