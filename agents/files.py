"""Files that are either there in full or not at all: write beside, then rename."""

from __future__ import annotations

import json
import math
import os
import shutil
from collections.abc import Callable, Generator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any, Final, cast

import numpy as np
import yaml

from pnt_gym.errors import PntGymError, one_sentence

from .cli import UsageError

try:
    import fcntl
except ImportError:  # Windows, where nothing is locked
    fcntl = None


VIDEOS: Final = (".mp4", ".gif")
PICTURES: Final = (".png", ".jpg", ".webp")
"""Endings of files that can be drawn."""


@contextmanager
def held(folder: Path) -> Generator[None, None, None]:
    """No other command writes in a folder while the block runs; the lock ends with its process, however that ends.

    Raises:
        UsageError: another command is at it.
    """
    with ExitStack() as ends:
        if fcntl is not None:
            lock = os.open(folder, os.O_RDONLY)
            ends.callback(os.close, lock)
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                said = f"another command is at work in {str(folder)!r}; let it end, or choose another folder"
                raise UsageError(said) from None
            except OSError:
                pass  # a file system that knows no locks
        yield


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


def write_json(path: Path, data: Any, *, indent: int | None = 1) -> None:
    """Write data as JSON at once; a NaN in it is an error, not a file other tools cannot read."""
    write_text(path, json.dumps(data, indent=indent, allow_nan=False) + "\n")


def jsonable(values: Any) -> Any:
    """A number, an array or a list as JSON has it, which knows neither NaN nor infinity: None stands for them."""
    listed: Any = cast("Any", values).tolist() if isinstance(values, np.ndarray | np.generic) else values
    if isinstance(listed, list):
        return [jsonable(one) for one in cast("list[Any]", listed)]
    return None if isinstance(listed, float) and not math.isfinite(listed) else listed


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
        UsageError: one names a folder, or its folder cannot be made or written.
    """
    for path in paths:
        if path is None:
            continue
        if path.exists() and not path.is_file():  # a device would be gone after the renaming
            raise UsageError(f"cannot write {str(path)!r}: it is {'a folder' if path.is_dir() else 'no file'}")
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise UsageError(f"cannot write {str(path)!r}: {error.strerror}") from None
        if not os.access(path.parent, os.W_OK):
            raise UsageError(f"cannot write {str(path)!r}: its folder is read-only")


def read_json(path: Path) -> Any:
    """Data of a JSON file.

    Raises:
        UsageError: the file is missing or not JSON.
    """
    return _read(path, repr(str(path)), json.loads, "JSON")


def read_yaml(path: Path, what: str) -> Any:
    """Data of a YAML file of the user's; `what` they are to describe.

    Raises:
        UsageError: the file is missing or not YAML.
    """
    return _read(path, f"{what} {str(path)!r}", yaml.safe_load, "YAML")


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


def _read(path: Path, name: str, parse: Callable[[str], Any], form: str) -> Any:
    try:
        return parse(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise UsageError(f"cannot read {name}: {error.strerror}") from None
    except Exception as error:
        # PyYAML lets through whatever a tag or a date upsets.
        raise UsageError(f"cannot read {name}: it is not valid {form}: {one_sentence(error, 100)}") from None
