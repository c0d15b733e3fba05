"""Files that are either there in full or not at all: write beside, then rename."""

from __future__ import annotations

import json
import math
import os
import shutil
import warnings
from collections.abc import Callable, Generator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Final, cast

import numpy as np
from filelock import FileLock, Timeout

from pnt_gym.errors import PntGymError, one_sentence
from pnt_gym.reading import ReadError, json_of, yaml_of

from .cli import UsageError

LOCK: Final = ".lock"
"""File in a folder by which a command keeps others out."""
MOST_RESULTS: Final = 2**28
"""Bytes of a file of results."""


@contextmanager
def held(folder: Path) -> Generator[None, None, None]:
    """No other command writes in a folder while the block runs; the lock ends with its process, however that ends.

    Raises:
        UsageError: another command is at it.
    """
    lock = FileLock(folder / LOCK, blocking=False)
    try:
        lock.acquire()
    except Timeout:
        said = f"another command is at work in {str(folder)!r}; let it end, or choose another folder"
        raise UsageError(said) from None
    except (FileNotFoundError, NotADirectoryError):
        raise
    except OSError as error:
        warnings.warn(f"nothing keeps other commands out of {str(folder)!r}: {error.strerror}", stacklevel=3)
    try:
        yield
    finally:
        if lock.is_locked:
            with suppress(OSError):  # Windows removes no open file
                (folder / LOCK).unlink()
            lock.release()


def unfinished(path: Path) -> Path:
    """Where a process writes what shall be `path` when it is whole."""
    return path.with_name(f".{path.name}.{os.getpid()}.tmp")


def sweep(folder: Path) -> None:
    """Remove from a folder what processes that were killed have not finished, where /proc tells who lives."""
    for old in folder.glob(".*.tmp") if Path("/proc/self").exists() else ():
        owner = old.stem.rpartition(".")[2]
        if owner.isdecimal() and not Path("/proc", owner).exists():
            shutil.rmtree(old, ignore_errors=True)
            with suppress(OSError):  # a folder, which is gone
                old.unlink()


def replace_file(path: Path, write: Callable[[Path], object]) -> None:
    """Let `write` fill a file of the same name in a folder beside it, then rename that over `path`.

    Some writers go by a file's ending, which is therefore kept.
    """
    sweep(path.parent)
    parts = unfinished(path)
    try:
        parts.mkdir(exist_ok=True)
        write(parts / path.name)
        os.replace(parts / path.name, path)
    finally:
        shutil.rmtree(parts, ignore_errors=True)


def write_text(path: Path, text: str) -> None:
    """Write a text file at once.

    Raises:
        UsageError: the place cannot be written.
    """
    write_bytes(path, text.encode())


def write_bytes(path: Path, data: bytes) -> None:
    """Write a file at once.

    Raises:
        UsageError: the place cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        replace_file(path, lambda temporary: temporary.write_bytes(data))
    except OSError as error:
        raise UsageError(f"cannot write {str(path)!r}: {error.strerror}") from None


def write_json(path: Path, data: Any) -> None:
    """Write data as JSON at once."""
    write_text(path, json_text(data))


def json_text(data: Any, *, indent: int | None = 1) -> str:
    """Data as JSON; a NaN in the data is an error, not a file that other tools cannot read."""
    return json.dumps(data, indent=indent, allow_nan=False) + "\n"


def jsonable(values: Any) -> Any:
    """A number, an array or a list as JSON has it, which knows neither NaN nor infinity: None stands for them."""
    listed: Any = cast("Any", values).tolist() if isinstance(values, np.ndarray | np.generic) else values
    if isinstance(listed, list):
        return [jsonable(one) for one in cast("list[Any]", listed)]
    return None if isinstance(listed, float) and not math.isfinite(listed) else listed


def read_json(path: Path, most: int = MOST_RESULTS) -> Any:
    """Data of a JSON file, which may have so many bytes.

    Raises:
        UsageError: the file is missing, too large, or not JSON.
    """
    try:
        return json_of(path, most)
    except ReadError as error:
        raise UsageError(f"cannot read {str(path)!r}: {error}") from None


def read_yaml(path: Path, what: str) -> Any:
    """Data of a YAML file of the user's; `what` they are to describe.

    Raises:
        UsageError: the file is missing, too large, or not YAML.
    """
    try:
        return yaml_of(path)
    except ReadError as error:
        raise UsageError(f"cannot read {what} {str(path)!r}: {error}") from None


@contextmanager
def of_its_form(path: Path) -> Generator[None, None, None]:
    """What reads data of a file in the block takes for granted that they have a certain form.

    Raises:
        UsageError: they have not.
    """
    try:
        yield
    except PntGymError:
        raise
    except (LookupError, TypeError, ValueError, AttributeError) as error:
        said = f"{type(error).__name__}: {one_sentence(error, 80)}"
        raise UsageError(f"{str(path)!r} was not written by this version: it is of another form ({said})") from error
