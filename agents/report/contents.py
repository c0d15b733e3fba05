"""Contents of files of results: each file is read and checked once a run, however many tables and answers need it."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Any

from pnt_gym.constants import WORLD

from ..ground.files import read_json, stamp
from ..reproduce import record
from ..results import compare, content, study
from ..results.content import ROWS, folder_of


def read(path: Path, *, trust: bool = False) -> Any:
    """Data of a file of results, shared by all callers, which must not change the data.

    The figures of a benchmark are computed from the throws in its file, and verdicts about papers from their values.

    Args:
        path: path of the file.
        trust: import the module of the environment that a benchmark's file names.

    Raises:
        UsageError: the file is missing, too large, or not JSON; or it shows other figures than its throws give.
    """
    return _read(path, trust, (stamp(path), stamp(folder_of(path) / ROWS)))


def older(world: int) -> str:
    """Sentence on results that were measured in a world; empty for the world that is simulated now."""
    return f"Measured in world {world}; `pnt_gym` simulates world {WORLD}, see CHANGELOG." if world < WORLD else ""


@lru_cache(maxsize=64)
def _read(path: Path, trust: bool, _stamps: tuple[tuple[int, ...], ...]) -> Any:
    """Data of a file; a file that was written anew has another stamp."""
    data = read_json(path)
    if content.matches(data):
        return compare.check(content.form(path, data), trust=trust).data
    if record.matches(data):
        record.check(path, data)
    elif study.matches(data):
        study.check(path, data)
    return data
