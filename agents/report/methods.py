"""The figure of the study of methods: sorted per minute over limits, openings, distances and masses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

from ..ground.drawings import COLOURS, Axes, Figure, dress, svg, tile_panels
from ..results.study import shipped_study

Data = Mapping[str, Any]
ACROSS: Final = {
    "percent": "limits [%]",
    "opening": "opening of the bin [m]",
    "distance": "distance of the bin, y [m]",
    "mass": "mass of cans [kg]",
}
"""What panels are drawn over, and what the axis is called."""
METHOD: Final = "planner"
IN_A_ROW: Final = 2
"""Panels side by side."""


def methods_figures(data: Data) -> dict[str, str]:
    """SVG texts by file name."""
    return {"methods.svg": svg(methods_figure(data))}


def methods_figure(data: Data) -> Figure:
    """Sorted per minute by each method: over the limits in each level, and over each sweep."""
    panels: dict[str, list[Data]] = {}
    for row in (row for row in data["rows"] if METHOD in row):
        panels.setdefault(f"level {row['level']}" if "level" in row else row["part"], []).append(row)
    figure, axes = tile_panels(len(panels), IN_A_ROW, (3.2, 2.7), sharey=True)
    for panel, (title, rows) in zip(axes, panels.items(), strict=True):
        name = next(name for name in ACROSS if name in rows[0])
        _lines(panel, rows, name)
        dress(panel, ACROSS[name], "sorted per minute" if panel in axes[::IN_A_ROW] else "", title)
    axes[0].set_ylim(bottom=0.0)
    figure.legend(*axes[0].get_legend_handles_labels(), fontsize=8, loc="outside lower center", ncols=3)
    return figure


def _lines(axes: Axes, rows: Sequence[Data], name: str) -> None:
    """A line for each method, with gaps where it cannot be used."""
    methods = shipped_study("methods").names[METHOD]
    for (method, label), colour in zip(methods.items(), COLOURS, strict=False):
        points = [(row[name], row.get("sorted_per_min", float("nan"))) for row in rows if row[METHOD] == method]
        axes.plot(*zip(*points, strict=True), marker="o", markersize=4, color=colour, label=label)
