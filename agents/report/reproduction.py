"""The chapters on reproduced papers."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Final

from pnt_gym.errors import one_sentence
from pnt_gym.reading import text_of

from ..ground.cli import UsageError
from ..ground.files import MOST_RESULTS, check_form
from ..ground.tables import Grid
from ..reproduce.record import Record, all_grids, overview_grids, verdicts
from .contents import read_results
from .page import Chapter

USED: Final = ("python", "pnt_gym", "mujoco", "numpy", "scipy", "casadi")
"""Packages that a reproduction depends on."""
FILE: Final = "reproduction.json"


def paper_chapters(record: Record, drawings: Path) -> list[Chapter]:
    """One chapter a paper: its tables, and those of its drawings that lie in the folder."""
    return [_chapter(record, paper, drawings) for paper in record["papers"]]


def table(results: Path, name: str) -> Grid | None:
    """A table of a paper's overview by the name "paper/table"; None if there is no such table.

    Raises:
        UsageError: nothing was reproduced yet, or the record has another form.
    """
    record = read_results(results / FILE)
    paper, _, table_name = name.partition("/")
    with check_form(results / FILE):
        return overview_grids(record, paper).get(table_name) if paper in record["papers"] else None


def _chapter(record: Record, paper: str, drawings: Path) -> Chapter:
    names = record["figures"][paper]
    for name in names:
        if re.fullmatch(r"[\w.-]+\.svg", name) is None:
            raise UsageError(f"drawing {one_sentence(repr(name), 80)} is no name of an .svg file in {str(drawings)!r}")
    files = [drawings / name for name in names]
    drawn = {file.name: _drawing(file) for file in files if file.is_file()}
    grids = tuple(all_grids(record, paper))
    return Chapter(record["titles"][paper], grids, drawn, _note(record, paper), paper)


def _drawing(file: Path) -> str:
    with check_form(file):
        return text_of(file, MOST_RESULTS)


def _note(record: Record, paper: str) -> str:
    """What the figures were made with, and what the verdicts count."""
    counts = ", ".join(f"{count} {verdict}" for verdict, count in verdicts(record, paper).rows)
    seconds = sum(value for name, value in record["seconds"].items() if name.startswith(f"{paper}/"))
    versions = ", ".join(f"{name} {record['versions'][name]}" for name in USED if name in record["versions"])
    return f"`{record['command']}`: {counts}; {seconds:.0f} s of processor time. Versions: {versions}."
