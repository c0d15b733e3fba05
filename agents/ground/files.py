"""Files that appear complete or not at all: they are written beside their place, then renamed."""

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
from numpy.typing import NDArray

from pnt_gym.errors import PntGymError, one_sentence
from pnt_gym.reading import ReadError, json_of, yaml_of

from .cli import UsageError

LOCK: Final = ".lock"
"""Name of the file by which a command locks a folder."""
MOST_RESULTS: Final = 2**27
"""Largest size of a file of results [bytes]."""


@contextmanager
def lock_folder(folder: Path) -> Generator[None, None, None]:
    """Lock a folder against other commands during the block; the lock ends with the process, however the process ends.

    Raises:
        UsageError: another command has locked the folder.
    """
    lock = FileLock(folder / LOCK, blocking=False)
    try:
        lock.acquire()
    except Timeout:
        message = f"another command is at work in {str(folder)!r}; let it end, or choose another folder"
        raise UsageError(message) from None
    except (FileNotFoundError, NotADirectoryError):
        raise
    except OSError as error:
        warnings.warn(f"nothing keeps other commands out of {str(folder)!r}: {error.strerror}", stacklevel=3)
    try:
        yield
    finally:
        if lock.is_locked:
            with suppress(OSError):  # Windows does not remove an open file
                (folder / LOCK).unlink()
            lock.release()


def temporary_path(path: Path) -> Path:
    """Temporary path at which this process writes a file that is then renamed to `path`."""
    return path.with_name(f".{path.name}.{os.getpid()}.tmp")


def sweep(folder: Path) -> None:
    """Remove the temporary files of dead processes from a folder, on systems whose /proc lists the processes."""
    for old in folder.glob(".*.tmp") if Path("/proc/self").exists() else ():
        owner = old.stem.rpartition(".")[2]
        if owner.isdecimal() and not Path("/proc", owner).exists():
            shutil.rmtree(old, ignore_errors=True)
            with suppress(OSError):  # a folder is already removed
                old.unlink()


def replace_file(path: Path, write: Callable[[Path], object]) -> None:
    """Let `write` fill a file in a temporary folder beside `path`, then rename the file to `path`.

    The temporary file has the same name, because some writers choose the format by its ending.
    """
    sweep(path.parent)
    parts = temporary_path(path)
    try:
        parts.mkdir(exist_ok=True)
        write(parts / path.name)
        os.replace(parts / path.name, path)
    finally:
        shutil.rmtree(parts, ignore_errors=True)


def stamp(path: Path) -> tuple[int, ...]:
    """What another content of a file changes: its place, times of change and size; nothing where there is no file."""
    with suppress(OSError):
        state = path.stat()
        return state.st_dev, state.st_ino, state.st_ctime_ns, state.st_mtime_ns, state.st_size
    return ()


def write_text(path: Path, text: str) -> None:
    """Write a text file atomically.

    Raises:
        UsageError: the file cannot be written.
    """
    write_bytes(path, text.encode())


def write_bytes(path: Path, data: bytes) -> None:
    """Write a file atomically.

    Raises:
        UsageError: the file cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        replace_file(path, lambda temporary: temporary.write_bytes(data))
    except OSError as error:
        raise UsageError(f"cannot write {str(path)!r}: {error.strerror}") from None


def write_json(path: Path, data: Any) -> None:
    """Write data as a JSON file atomically."""
    write_text(path, json_text(data))


def json_text(data: Any) -> str:
    """Data as JSON text, with a line for each key of an object, and in a list of objects for each of these.

    A NaN in the data raises an error, because other tools could not read the file.
    """
    if not isinstance(data, dict):
        return _json_value(data) + "\n"
    lines = (f"{json.dumps(str(key))}: {_json_value(value)}" for key, value in cast("dict[Any, Any]", data).items())
    return "{\n " + ",\n ".join(lines) + "\n}\n"


def _json_value(value: Any) -> str:
    entries = cast("list[Any]", value) if isinstance(value, list | tuple) and value else [None]
    if not all(isinstance(entry, dict) for entry in entries):
        return _short_json(value)
    return "[\n  " + ",\n  ".join(map(_short_json, entries)) + "\n ]"


def _short_json(value: Any) -> str:
    return json.dumps(value, allow_nan=False, separators=(",", ":"))


def jsonable(values: Any, decimals: int | None = None) -> Any:
    """A number, an array or a list as JSON values, rounded to `decimals` if given.

    None replaces NaN and infinity, which JSON does not have. A zero has no sign, so equal values have equal texts.
    """
    if isinstance(values, np.ndarray) and values.ndim and decimals is None and values.dtype.kind in "bif":
        # All at once, because results have millions.
        numbers = cast("NDArray[Any]", values)
        if numbers.dtype.kind != "f":
            return numbers.tolist()
        entries = (numbers + 0.0).astype(object)
        entries[~np.isfinite(numbers)] = None
        return entries.tolist()
    listed: Any = cast("Any", values).tolist() if isinstance(values, np.ndarray | np.generic) else values
    if isinstance(listed, list):
        return [jsonable(value, decimals) for value in cast("list[Any]", listed)]
    if not isinstance(listed, float):
        return listed
    if not math.isfinite(listed):
        return None
    return (listed if decimals is None else round(listed, decimals)) + 0.0


def read_json(path: Path, max_bytes: int = MOST_RESULTS) -> Any:
    """Data of a JSON file of at most `max_bytes` bytes.

    Raises:
        UsageError: the file is missing, too large, or not JSON.
    """
    try:
        return json_of(path, max_bytes)
    except ReadError as error:
        raise UsageError(f"cannot read {str(path)!r}: {error}") from None


def read_yaml(path: Path, subject: str) -> Any:
    """Data of a user's YAML file; `subject` names their subject in errors.

    Raises:
        UsageError: the file is missing, too large, or not YAML.
    """
    try:
        return yaml_of(path)
    except ReadError as error:
        raise UsageError(f"cannot read {subject} {str(path)!r}: {error}") from None


@contextmanager
def check_form(path: Path) -> Generator[None, None, None]:
    """Turn errors in the block, which reads data of a file in an expected form, into a `UsageError`.

    Raises:
        UsageError: the file cannot be read, or the data have another form.
    """
    try:
        yield
    except ReadError as error:
        raise UsageError(f"cannot read {str(path)!r}: {error}") from None
    except PntGymError:
        raise
    except (LookupError, TypeError, ValueError, AttributeError, ArithmeticError) as error:
        reason = f"{type(error).__name__}: {one_sentence(error, 80)}"
        raise UsageError(f"{str(path)!r} was not written by this version: it is of another form ({reason})") from error
