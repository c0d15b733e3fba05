"""Contents of files of results: each file is parsed once a run, however many tables and answers need it."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Any

from ..ground.files import read_json


def read_results(path: Path) -> Any:
    """Data of a file of results, shared by all callers, which must not change the data.

    Raises:
        UsageError: the file is missing, too large, or not JSON.
    """
    try:
        status = path.stat()
    except OSError:
        return read_json(path)  # says what is wrong with the place
    return _parse(path, status.st_mtime_ns, status.st_size)


@lru_cache(maxsize=64)
def _parse(path: Path, _modified: int, _size: int) -> Any:
    """Data of a file; a file that was written anew has another time or size."""
    return read_json(path)
