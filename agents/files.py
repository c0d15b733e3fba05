"""Files that are either there in full or not at all: write beside, then rename."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import yaml

from .cli import UsageError


def replace_file(path: Path, write: Callable[[Path], object]) -> None:
    """Let `write` fill a temporary file beside `path`, then rename it over `path`."""
    temporary = path.with_name(f".{path.name}.{os.getpid()}.tmp")
    try:
        write(temporary)
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write a text file at once.

    Raises:
        UsageError: the place cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        replace_file(path, lambda temporary: temporary.write_text(text, encoding="utf-8"))
    except OSError as error:
        raise UsageError(f"cannot write {str(path)!r}: {error.strerror}") from None


def write_json(path: Path, data: Any, *, indent: int | None = 1) -> None:
    """Write data as JSON at once; a NaN in it is an error, not a file other tools cannot read."""
    write_text(path, json.dumps(data, indent=indent, allow_nan=False) + "\n")


def check_writable(*paths: Path | None) -> None:
    """Find out before hours of work whether those of `paths` that were asked for can be written after them.

    Raises:
        UsageError: one names a folder, or its folder cannot be made or written.
    """
    for path in paths:
        if path is None:
            continue
        if path.is_dir():
            raise UsageError(f"cannot write {str(path)!r}: it is a folder")
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


def _read(path: Path, name: str, parse: Callable[[str], Any], form: str) -> Any:
    try:
        return parse(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise UsageError(f"cannot read {name}: {error.strerror}") from None
    except (ValueError, yaml.YAMLError) as error:
        raise UsageError(f"cannot read {name}: it is not valid {form}: {str(error).splitlines()[0]}") from None
