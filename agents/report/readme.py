"""The marked blocks of a README that hold tables made from results/*.json."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from functools import cache, partial
from pathlib import Path
from typing import Any, Final

from ..ground.cli import UsageError
from ..ground.files import of_its_form, read_json
from ..ground.outputs import deliver_text
from ..ground.tables import Grid, markdown_text
from .headline import headline_table
from .line import gains_table, learned_table, worked_table
from .reproduction import table as reproduced_table
from .speeds import environment_table, planner_table
from .study import study_grid
from .study_plan import STUDIES, read_study
from .tables import benchmark_table, shift_table

BLOCKS: Mapping[str, tuple[str, Callable[[Any], Grid]]] = {
    "headline": ("benchmark.json", headline_table),
    "benchmark": ("benchmark.json", benchmark_table),
    "planner": ("perf_planner.json", planner_table),
    "environments": ("perf_envs.json", environment_table),
    "line": ("benchmark_line.json", worked_table),
    "line-gains": ("benchmark_line.json", gains_table),
    "line-learned": ("benchmark_line.json", learned_table),
    "adapting": ("benchmark_adapt.json", shift_table),
}
"""Blocks of a README by name: the file of results, and what makes the table of it; plans of studies name further ones,
and those of papers are "paper/table"."""


_BLOCK: Final = re.compile(r"(<!-- table:(\S+) -->\n).*?(<!-- /table -->)", re.DOTALL)
"""A marked block, with its markers and name."""


def with_blocks(text: str, results: Path) -> str:
    """A README with its marked blocks replaced by what the results give.

    Raises:
        UsageError: a marked block has no such table, or its results are missing.
    """

    def block(found: re.Match[str]) -> str:
        grid = _table(found[2], results)
        note = f"\n\n{markdown_text(grid.note)}" if grid.note else ""
        return f"{found[1]}{grid.markdown()}{note}\n{found[3]}"

    return _BLOCK.sub(block, text)


def update_readme(readme: Path, results: Path) -> None:
    """Write the marked blocks of a README anew."""
    text = readme.read_text(encoding="utf-8")
    changed = with_blocks(text, results)
    if changed != text:
        deliver_text(readme, changed)


def _table(name: str, results: Path) -> Grid:
    tables = {**BLOCKS, **study_blocks()}
    if name in tables:
        file, make_table = tables[name]
        with of_its_form(results / file):
            return make_table(read_json(results / file))
    found = reproduced_table(results, name) if "/" in name else None
    if found is None:
        raise UsageError(f"no table {name!r} for a README; known are {', '.join(tables)}, and PAPER/TABLE")
    return found


@cache
def study_blocks() -> Mapping[str, tuple[str, Callable[[Any], Grid]]]:
    """The same of the studies that ship."""
    plans = [read_study(path) for path in sorted(STUDIES.glob("*.yaml"))]
    return {
        table.block: (f"{plan.study}.json", partial(study_grid, plan, table))
        for plan in plans
        for table in plan.tables
        if table.block
    }
