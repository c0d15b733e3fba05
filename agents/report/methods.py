"""What `benchmarks/study_methods.py` measured as tables: methods side by side, why they differ, where throwing pays."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from ..ground.drawings import COLOURS, Axes, Figure, dress, subplots, svg
from ..ground.tables import Grid
from .page import Chapter

Data = Mapping[str, Any]
NAMES: Final = {
    "pick_and_place": "pick-and-place",
    "ellipse": "ellipse",
    "horizontal": "level throw",
    "straight": "straight throw",
    "free_direction": "free direction",
}
SWEEPS: Final = ("opening", "distance", "grip")
PERCENT: Final = "40"
"""Of the limits, at which the methods are told apart."""


def methods_chapter(name: str, data: Data) -> Chapter:
    """All tables and the figure of the study."""
    grids = methods_table(data), reasons_table(data), pays_table(data)
    return Chapter(name, grids, {"methods.svg": svg(methods_figure(data))})


def methods_figure(data: Data) -> Figure:
    """Sorted per minute by each method: over the limits in each level, over opening and distance of one bin."""
    across = {
        "opening": "opening of the bin [m]",
        "distance": "distance of the bin, y [m]",
        "grip": "mass of cans [kg]",
    }
    tables = data["methods"]
    figure, panels = subplots(1, len(tables), (4.2 * len(tables), 3.6), sharey=True)
    for axes, (title, table) in zip(panels, tables.items(), strict=True):
        _lines(axes, table)
        said = title if title in SWEEPS else f"level {title}"
        dress(axes, across.get(title, "limits [%]"), "sorted per minute" if axes is panels[0] else "", said)
    panels[0].set_ylim(bottom=0.0)
    panels[0].legend(fontsize=8, loc="upper left")
    return figure


def _lines(axes: Axes, table: Data) -> None:
    """A line for each method, with gaps where it cannot be used."""
    for (name, said), colour in zip(NAMES.items(), COLOURS, strict=False):
        pace = [found[name].get("sorted_per_min", float("nan")) for found in table.values()]
        axes.plot([float(value) for value in table], pace, marker="o", markersize=4, color=colour, label=said)


def methods_table(data: Data) -> Grid:
    """Objects sorted per minute by each method, level by level and percentage by percentage."""
    rows = [
        [f"`{level}`, {percent} %", *(_pace(found[name]) for name in NAMES)]
        for level, table in data["methods"].items()
        if level not in SWEEPS
        for percent, found in table.items()
    ]
    note = (
        f"Sorted per minute, in brackets the success rate; {data['throws']} throws per cell, seed {data['seed']}, "
        "analytic planner, `PnTConveyor-v0`, the same objects on the same belts. A dash: no object has a feasible "
        "throw there. The free direction has the window of 30 ms of the level `fast`, the others that of their level."
    )
    return Grid("How an object gets to its bin: sorted per minute", ["level, limits", *NAMES.values()], rows, note)


def reasons_table(data: Data) -> Grid:
    """What the methods need and lose at one percentage."""
    shares = ("unpicked", "dropped", "missed", "rim", "recovery")
    header = [
        "level",
        "method",
        "cycle",
        "of it waiting",
        "flown / planned",
        "not picked",
        "lost",
        *shares[2:],
        "energy",
    ]
    rows = [
        [
            level,
            said,
            f"{found['cycle_time']:.3f} s",
            f"{found['wait_time']:.3f} s",
            f"{found['flown_over_planned']:.4f}",
            *(f"{100 * found[share]:.1f} %" for share in shares),
            f"{found['energy_per_pick_j']:.0f} J",
        ]
        for level, table in data["methods"].items()
        if level not in SWEEPS
        for name, said in NAMES.items()
        if "impossible" not in (found := table[PERCENT][name])
    ]
    note = (
        f"The same throws at {PERCENT} % of the limits. Flown / planned: how long the hand of the full robot takes to "
        "come to stay within 1 mm of its next pick, over what the plan takes to. Lost: on the way to the release. "
        "Missed: beside the opening, which a learned correction mends. Rim: in the opening, but not in the bin."
    )
    return Grid(f"Why: the methods at {PERCENT} % of the limits", header, rows, note)


def pays_table(data: Data) -> Grid:
    """Where throwing stops paying: one bin whose opening shrinks, that moves away, and objects that grow heavier."""
    said = {
        "opening": "opening {:.0f} mm",
        "distance": "bin {:.2f} m beyond the robot's middle",
        "grip": "cans of {:.0f} g, held with 20 N",
    }
    scale = {"opening": 1000.0, "distance": 1.0, "grip": 1000.0}
    rows = [
        [said[sweep].format(scale[sweep] * float(value)), *(_pace(found[name]) for name in NAMES)]
        for sweep in SWEEPS
        for value, found in data["methods"].get(sweep, {}).items()
    ]
    note = (
        f"Sorted per minute, in brackets the success rate: {max(data['throws'] // 2, 1)} throws per cell, "
        f"`PnTRelease-v0`, objects of `nominal`, {PERCENT} % of the limits, without learned corrections. Opening: of "
        "a bin at y 0.35 m. Distance: y of the middle of a bin of 200 mm. Cans: into a bin of 240 mm at y 0.35 m, each "
        "method slowed until the cup could hold 1.5 times what is measured."
    )
    return Grid("Where throwing stops paying", ["bin or object", *NAMES.values()], rows, note)


def _pace(found: Data) -> str:
    if "impossible" in found:
        return "-"
    return f"{found['sorted_per_min']:.1f} ({100 * found['success']:.0f} %)"


def throwable_table(data: Data) -> Grid:
    """What to do with objects that air carries away."""
    header = ["what is done", "sorted/min", "success", "recovery", "put down", "landing error", "energy"]
    rows = [
        [
            name,
            f"{found['sorted_per_min']:.1f}",
            *(f"{100 * found[figure]:.1f} %" for figure in ("success", "recovery", "placed")),
            f"{1000 * found['landing_error']:.0f} mm",
            f"{found['energy']:.1f} J",
        ]
        for name, found in data["throwable"].items()
    ]
    note = (
        f"Level `{data['level']}` on the belt, {data['throws']} throws per row, seed {data['seed']}, full physics, "
        "analytic planner. Rest: what has a drag area by mass above 2.5 m2/kg, as measured."
    )
    return Grid("What is not thrown", header, rows, note)
