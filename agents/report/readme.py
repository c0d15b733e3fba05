"""The marked blocks of a README that hold tables made from results/*.json."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final

from ..ground.cli import UsageError
from ..ground.files import of_its_form, read_json
from ..ground.outputs import deliver_text
from ..ground.tables import Grid, markdown_text
from .adaptation import camera_table, newcomers_table
from .headline import headline_table
from .line import gains_table, learned_table, worked_table
from .measures import (
    cup_table,
    dispatch_table,
    environment_table,
    fidelity_table,
    grip_table,
    judged_table,
    neighbours_table,
    oracle_table,
    physics_table,
    planner_table,
    training_table,
)
from .methods import methods_table, pays_table, reasons_table, throwable_table
from .reproduction import table as reproduced_table
from .tables import benchmark_table, shift_table
from .thrown import release_table, thrown_table

BLOCKS: Mapping[str, tuple[str, Callable[[Any], Grid]]] = {
    "headline": ("benchmark.json", headline_table),
    "benchmark": ("benchmark.json", benchmark_table),
    "physics": ("physics.json", physics_table),
    "planner": ("perf_planner.json", planner_table),
    "environments": ("perf_envs.json", environment_table),
    "fidelity": ("fidelity.json", fidelity_table),
    "training": ("training.json", training_table),
    "grip": ("grip.json", grip_table),
    "cup": ("cup.json", cup_table),
    "methods": ("methods.json", methods_table),
    "method-reasons": ("methods.json", reasons_table),
    "methods-pay": ("methods.json", pays_table),
    "throwable": ("throwable.json", throwable_table),
    "oracle": ("oracle.json", oracle_table),
    "dispatch": ("dispatch.json", dispatch_table),
    "judged": ("judged.json", judged_table),
    "neighbours": ("neighbours.json", neighbours_table),
    "line": ("benchmark_line.json", worked_table),
    "line-gains": ("benchmark_line.json", gains_table),
    "line-learned": ("benchmark_line.json", learned_table),
    "line-thrown": ("line.json", thrown_table),
    "line-release": ("line.json", release_table),
    "adapting": ("benchmark_adapt.json", shift_table),
    "bin-camera": ("adaptation.json", camera_table),
    "newcomers": ("adaptation.json", newcomers_table),
}
"""Blocks of a README by name: the file of results, and what makes the table of it; others are "paper/table"."""


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
    if name in BLOCKS:
        file, make_table = BLOCKS[name]
        with of_its_form(results / file):
            return make_table(read_json(results / file))
    found = reproduced_table(results, name) if "/" in name else None
    if found is None:
        raise UsageError(f"no table {name!r} for a README; known are {', '.join(BLOCKS)}, and PAPER/TABLE")
    return found
