"""The marked blocks of a README that hold tables made from results/*.json."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from agents.cli import UsageError
from agents.files import read_json, write_text
from agents.report.measures import environment_table, physics_table, planner_table
from agents.report.tables import noted_benchmark_table

BLOCKS: Mapping[str, tuple[str, Callable[[Any], str]]] = {
    "benchmark": ("benchmark.json", noted_benchmark_table),
    "physics": ("physics.json", physics_table),
    "planner": ("perf_planner.json", planner_table),
    "environments": ("perf_envs.json", environment_table),
}
"""Blocks of a README by name: the file of results and what makes the table of it."""


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
        file, make = BLOCKS[name]
        table = make(read_json(results / file))
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
