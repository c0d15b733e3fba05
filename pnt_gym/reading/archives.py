"""Zip archives and NumPy's archives of arrays, of which names and sizes are checked before anything is unpacked."""

from __future__ import annotations

import lzma
import re
import zlib
from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path
from tokenize import TokenError
from typing import IO, Any, BinaryIO, Final
from zipfile import BadZipFile, ZipFile, ZipInfo

import numpy as np
from numpy.typing import NDArray

from pnt_gym.errors import PntGymError, one_sentence
from pnt_gym.reading.files import ReadError, check_size, opened

MOST_NUMBERS: Final = 2**26
"""Bytes of the arrays in a file; a network of three layers of 2,000 has half as many."""
MOST_PARTS: Final = 10_000
"""Files in an archive."""


_BROKEN: Final = (
    BadZipFile,  # no directory, or a part whose sum does not fit
    zlib.error,  # a part that is damaged
    lzma.LZMAError,  # the same, compressed otherwise
    EOFError,  # a part that ends too early
    NotImplementedError,  # a kind of compression that Python lacks
    RuntimeError,  # an encrypted part
    OSError,  # a disk that fails, or a directory that points before the file
    ValueError,  # an array whose header is no header
    TokenError,  # an array whose header ends too early
)
"""Errors of the standard library and of NumPy at an archive that nobody can read."""


def arrays_of(path: str | Path, expected: re.Pattern[str], most: int = MOST_NUMBERS) -> dict[str, NDArray[Any]]:
    """The arrays of a NumPy archive (.npz), by name; none of them holds objects.

    Args:
        path: of the archive.
        expected: matches the whole name of every array that may stand in it.
        most: bytes of all arrays, and of the file.

    Raises:
        ReadError: there is no such archive, it holds something else, or it is too large.
    """
    with archive(path, expected, most, ".npy") as (parts, infos):
        return {info.filename.removesuffix(".npy"): _array(parts, info) for info in infos}


@contextmanager
def archive(
    path: str | Path | BinaryIO, expected: re.Pattern[str], most: int, suffix: str = ""
) -> Generator[tuple[ZipFile, list[ZipInfo]], None, None]:
    """A zip archive and what stands in it, of which names and sizes are checked.

    Args:
        path: of the archive, or an open one.
        expected: matches the whole name of every part, without the suffix.
        most: bytes of all parts together when they are unpacked.
        suffix: of every part's name.

    Raises:
        ReadError: there is no such archive, it is torn, it holds something else, or it is too large.
    """
    try:
        if not isinstance(path, str | Path):
            yield _directory(path, expected, most, suffix)
            return
        with opened(path, most) as file:
            yield _directory(file, expected, most, suffix)
    except PntGymError:
        raise
    except _BROKEN as error:
        raise ReadError(f"it is no archive that can be read: {one_sentence(error, 100)}") from None


def _directory(file: BinaryIO, expected: re.Pattern[str], most: int, suffix: str) -> tuple[ZipFile, list[ZipInfo]]:
    parts = ZipFile(file)
    infos = parts.infolist()
    if len(infos) > MOST_PARTS:
        raise ReadError(f"it holds {len(infos):,} parts; at most {MOST_PARTS:,} are read")
    names = [info.filename for info in infos]
    seen: set[str] = set()
    for name in names:
        if not (name.endswith(suffix) and expected.fullmatch(name.removesuffix(suffix))):
            raise ReadError(f"it holds {one_sentence(repr(name), 60)}, which does not belong there")
        if name in seen:
            raise ReadError(f"it holds {name!r} twice")
        seen.add(name)
    check_size("what it holds", sum(info.file_size for info in infos), most)
    return parts, infos


def _array(parts: ZipFile, info: ZipInfo) -> NDArray[Any]:
    """An array of an archive whose header promises as many bytes as there are."""
    with parts.open(info) as file:
        version = np.lib.format.read_magic(file)
        readers: dict[tuple[int, int], Callable[[IO[bytes]], tuple[tuple[int, ...], bool, np.dtype[Any]]]] = {
            (1, 0): np.lib.format.read_array_header_1_0,
            (2, 0): np.lib.format.read_array_header_2_0,
        }
        if version not in readers:
            raise ReadError(f"it holds {info.filename!r} in version {version} of NumPy's format")
        shape, _, kind = readers[version](file)
        size = kind.itemsize
        for length in shape:
            size *= length
        if kind.hasobject or min(shape, default=0) < 0 or size != info.file_size - file.tell():
            raise ReadError(f"it holds {info.filename!r}, whose header and content do not fit together")
    with parts.open(info) as file:
        return np.lib.format.read_array(file, allow_pickle=False)
