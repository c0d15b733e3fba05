"""The marked blocks of a README that hold tables made from results/*.json."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from agents.cli import UsageError
from agents.files import read_json, write_text
from agents.report.measures import (
    environment_note,
    environment_table,
    physics_note,
    physics_table,
    planner_note,
    planner_table,
)
from agents.report.reproduction import table1_block, table1_note
from agents.report.tables import benchmark_note, benchmark_table

Text = Callable[[Any], str]
BLOCKS: Mapping[str, tuple[str, Text, Text]] = {
    "benchmark": ("benchmark.json", benchmark_table, benchmark_note),
    "physics": ("physics.json", physics_table, physics_note),
    "planner": ("perf_planner.json", planner_table, planner_note),
    "reproduction": ("reproduction.json", table1_block, table1_note),
    "environments": ("perf_envs.json", environment_table, environment_note),
}
"""Blocks of a README by name: the file of results, and what makes the table of it and the note under it."""


def block_pattern(name: str) -> re.Pattern[str]:
    """A marked block, with its markers."""
    return re.compile(rf"(<!-- table:{re.escape(name)} -->\n).*?(<!-- /table -->)", re.DOTALL)


def with_blocks(text: str, results: Path) -> str:
    """A README with its marked blocks replaced by what the results give.

    Raises:
        UsageError: a marked block has no such table, or its results are missing.
    """
    for name in re.findall(r"<!-- table:(\S+) -->", text):
        if name not in BLOCKS:
            raise UsageError(f"no table {name!r} for a README; known are {', '.join(BLOCKS)}")
        file, make_table, make_note = BLOCKS[name]
        data = read_json(results / file)
        table = f"{make_table(data)}\n\n{make_note(data)}"
        text = block_pattern(name).sub(lambda found, table=table: f"{found[1]}{table}\n{found[2]}", text)
    return text


def update_readme(readme: Path, results: Path) -> None:
    """Write the marked blocks of a README anew."""
    text = readme.read_text(encoding="utf-8")
    changed = with_blocks(text, results)
    if changed != text:
        write_text(readme, changed)


def stale_readme(readme: Path, results: Path) -> bool:
    """Whether a README's tables differ from what the results give."""
    text = readme.read_text(encoding="utf-8")
    return with_blocks(text, results) != text
