"""The throw of Hassan et al. 2022 in a free direction: the optimum, the same per pick, and what bounds cost."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Final

from agents.reproduce.findings import Findings, Part, Row
from agents.reproduce.hassan_free_cells import CELLS, RULES, Cell, bounds, cell_rows, free_cycle
from agents.reproduce.hassan_free_figure import free_figure
from agents.reproduce.hassan_per_pick import loss_rows, per_pick_cycle, timing_rows
from agents.reproduce.hassan_simulated import simulated, simulated_rows
from pnt_gym.planning import InfeasibleThrow
from pnt_gym.planning.cycle import Cycle
from pnt_gym.planning.fastest import NoMotionFound
from pnt_gym.planning.free_rules import HandRules

OPTIMUM: Final = "table1/limits-respected/free-direction-throw"
PER_PICK: Final = "table1/limits-respected/free-direction-per-pick"
HEADROOM: Final = {
    "hand-cap-0": replace(RULES, hand_cap=0.0),
    "hand-cap-0.05": replace(RULES, hand_cap=0.05),
    "window-10ms": replace(RULES, window=0.010),
    "window-30ms": replace(RULES, window=0.030),
}
"""The same throw with a lower roof for the hand, or with a hand that moves on unchanged after the release."""


def free_findings() -> Findings:
    """The optimum in every cell, how close the planning per pick comes to it, and two throws drawn."""
    optimum, refused = optima(RULES)
    rows = _rows(OPTIMUM, optimum, refused, RULES, f"fastest motion found in a free direction; {bounds(RULES)}")
    quick, failed = per_pick()
    rows += _rows(PER_PICK, quick, failed, RULES, f"as {OPTIMUM}, but planned in well under a millisecond per pick")
    rows += [*loss_rows(PER_PICK, quick, optimum), *timing_rows(PER_PICK)]
    return Findings(tuple(rows), figures={"hassan_free_direction.svg": free_figure(free_cycle)})


def headroom_findings(variant: str) -> Findings:
    """The optimum in every cell with one more bound."""
    rules = HEADROOM[variant]
    planned, refused = optima(rules)
    return Findings(tuple(_rows(f"headroom/{variant}", planned, refused, rules, f"as {OPTIMUM}, but {bounds(rules)}")))


def optima(rules: HandRules) -> tuple[dict[Cell, Cycle], dict[Cell, str]]:
    """The fastest cycles of every cell, and why there are none in the others."""
    planned: dict[Cell, Cycle] = {}
    refused: dict[Cell, str] = {}
    for cell in CELLS:
        try:
            planned[cell] = free_cycle(*cell, rules)
        except NoMotionFound as error:
            refused[cell] = f"{bounds(rules)}: {error}"
    return planned, refused


def per_pick() -> tuple[dict[Cell, Cycle], dict[Cell, str]]:
    """The cycles planned per pick of every cell, and why there are none in the others."""
    planned: dict[Cell, Cycle] = {}
    refused: dict[Cell, str] = {}
    for cell in CELLS:
        try:
            planned[cell] = per_pick_cycle(*cell).require()
        except InfeasibleThrow as error:
            refused[cell] = str(error)
    return planned, refused


def _rows(
    folder: str, planned: Mapping[Cell, Cycle], refused: Mapping[Cell, str], rules: HandRules, note: str
) -> list[Row]:
    """One row per cell, then the sums of the simulation."""
    measured = simulated({f"{folder}/{zone}/{percent}": (cycle, zone) for (zone, percent), cycle in planned.items()})
    rows = cell_rows(folder, planned, refused, measured, rules, note)
    return rows + (simulated_rows(folder, measured.values()) if measured else [])


PARTS = (
    Part("free-direction", free_findings),
    *(Part(f"headroom-{variant}", partial(headroom_findings, variant)) for variant in HEADROOM),
)
