"""Learning curves of the gripper robot's tosses, from the rows of its reproduction."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from agents.report.figures import COLOURS, subplots, svg
from agents.report.grids import Row, Rows

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FOLDER: Final = "leveziel/toss/"
LEVELS: Final = ("nominal", "late", "belt")
"""On which controllers learn."""
LINES: Final = {"analytic": "the planner alone", "oracle": "oracle"}
"""Controllers that do not learn."""


def leveziel_figures(rows: Rows) -> dict[str, str]:
    """SVG texts by file name; none where nothing was learned."""
    tosses = [row for name, row in rows.items() if name.startswith(FOLDER)]
    shown = {level: [row for row in tosses if row["level"] == level] for level in LEVELS}
    shown = {level: mine for level, mine in shown.items() if any(row["practice"] > 0 for row in mine)}
    return {"leveziel_toss.svg": svg(learning_figure(shown))} if shown else {}


def learning_figure(levels: dict[str, list[Row]]) -> Figure:
    """Success and landing error over throws of practice, one column per level, all seeds with their spread."""
    figure, axes = subplots(2, len(levels), (4.2 * len(levels), 6.4), sharex=True, sharey="row")
    learners = sorted({row["controller"] for rows in levels.values() for row in rows if row["practice"] > 0})
    colours = dict(zip((*LINES, *learners), ("black", "gray", *COLOURS), strict=False))
    for column, (level, rows) in enumerate(levels.items()):
        upper, lower = axes[column], axes[column + len(levels)]
        for name, colour in colours.items():
            mine = sorted((row for row in rows if row["controller"] == name), key=lambda row: row["practice"])
            if mine:
                _curve(upper, mine, "success_by_seed", 1.0, colour)
                _curve(lower, mine, "landing_error_by_seed_m", 1e3, colour)
        upper.set_title(f"level {level}", fontsize=10)
        lower.set_xlabel("throws of practice")
        lower.set_xscale("log")
        lower.set_yscale("log")
    ticks = sorted({row["practice"] for rows in levels.values() for row in rows if row["practice"] > 0})
    for panel in axes:
        panel.grid(alpha=0.3)
        panel.set_xticks(ticks, [f"{tick:,}" for tick in ticks])
        panel.minorticks_off()
    axes[0].set_ylabel("held-out throws that succeed [%]")
    axes[len(levels)].set_ylabel("landing error, mean [mm]")
    axes[len(levels)].set_yticks([2, 5, 10, 20, 50], ["2", "5", "10", "20", "50"])
    figure.legend(*axes[0].get_legend_handles_labels(), fontsize=8, ncols=5, loc="outside lower center")
    return figure


def _curve(panel: Axes, rows: list[Row], entry: str, unit: float, colour: str) -> None:
    """Mean and range over the seeds; a line across for a controller that does not learn."""
    values = [unit * np.array(row[entry], dtype=float) for row in rows]
    name = str(rows[0]["controller"])
    if name in LINES:
        panel.axhline(float(values[0].mean()), color=colour, linestyle="--", linewidth=1.2, label=LINES[name])
        return
    throws = [row["practice"] for row in rows]
    panel.plot(throws, [v.mean() for v in values], "o-", color=colour, label=name.replace("_", " "))
    panel.fill_between(throws, [v.min() for v in values], [v.max() for v in values], color=colour, alpha=0.15, lw=0)
