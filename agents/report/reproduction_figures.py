"""Figures of a reproduction that need nothing but its rows."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from agents.report.figures import COLOURS, subplots, svg
from agents.report.grids import Rows
from agents.report.hassan import COLUMNS
from agents.report.leveziel_figures import leveziel_figures

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BARS: Final = (
    ("published", "table1/paper-clock/min-time-throw", "published"),
    ("paper clock (limits exceeded)", "table1/paper-clock/min-time-throw", "reproduced"),
    ("straight throw, within the limits", "table1/limits-respected/min-time-throw", "reproduced"),
    ("free direction, planned per pick", "table1/limits-respected/free-direction-per-pick", "reproduced"),
    ("free direction, optimum", "table1/limits-respected/free-direction-throw", "reproduced"),
)
"""Label, folder and entry of each group of bars."""


def reproduction_figures(paper: str, rows: Rows) -> dict[str, str]:
    """SVG texts by file name."""
    if paper == "leveziel":
        return leveziel_figures(rows)
    if paper != "hassan" or not any(f"{BARS[0][1]}/{zone}/{percent}" in rows for zone, percent in COLUMNS):
        return {}
    return {"hassan_picks_per_min.svg": svg(picks_figure(rows))}


def picks_figure(rows: Rows) -> Figure:
    """Picks per minute of the proposed throw in every cell: published, reproduced, and with a free direction."""
    figure, panels = subplots(1, 2, (11.0, 4.2), sharey=True)
    groups = [bar for bar in BARS if any(f"{bar[1]}/{zone}/{percent}" in rows for zone, percent in COLUMNS)]
    width = 0.8 / len(groups)
    for axes, zone in zip(panels, ("inside", "outside"), strict=True):
        percents = [percent for where, percent in COLUMNS if where == zone]
        for k, (label, folder, entry) in enumerate(groups):
            cells: list[Mapping[str, Any]] = [rows.get(f"{folder}/{zone}/{percent}", {}) for percent in percents]
            values = np.array([cell.get(entry) or np.nan for cell in cells], dtype=float)
            places = np.arange(len(percents)) + (k - (len(groups) - 1) / 2) * width
            bars = axes.bar(places, values, 0.92 * width, color=_COLOURS[label], label=label)
            names = ["" if np.isnan(value) else f"{value:.0f}" for value in values]
            axes.bar_label(bars, names, fontsize=7, padding=1)
        axes.set_xticks(np.arange(len(percents)), [f"{percent} %" for percent in percents])
        axes.set_xlabel("share of the robot's limits")
        axes.set_title(f"target {zone} the workspace", fontsize=10)
        axes.grid(axis="y", alpha=0.3)
        axes.set_axisbelow(True)
    panels[0].set_ylabel("picks per minute")
    figure.legend(*panels[0].get_legend_handles_labels(), fontsize=8, ncols=3, loc="outside lower center")
    return figure


_COLOURS: Final = dict(
    zip((bar[0] for bar in BARS), ("black", COLOURS[3], COLOURS[0], COLOURS[8], COLOURS[2]), strict=True)
)
