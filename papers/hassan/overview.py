"""Tables of Hassan et al. 2022 over several parts: Table I, published and by protocol."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, TypeAlias

import numpy as np

from agents.ground.drawings import COLOURS, WIDTH, Figure, dress, subplots, svg
from agents.ground.tables import Grid
from agents.reproduce.finding import Overview
from agents.reproduce.grids import NONE, JsonRow, Rows, number, value

from .cases import CELLS, CHOSEN, CLOSE, CLOSE_FOLD, PERCENTAGES, PROTOCOLS, SHOWN, TITLES

Cells: TypeAlias = Sequence[JsonRow | None]
"""The rows of a folder, one for each column of Table I (None: not computed)."""
HEADER: Final = ["picks/min", *(f"{zone} {percent} %" for zone, percent in CELLS), "peak acceleration"]
PAPER: Final = SHOWN[0]
"""Protocol that is judged: the paper's path, with a constant jerk."""
PEAK_JERK: Final = "It keeps speed and acceleration; its jerk reaches {:.2f} J where two phases meet."
PEAK: Final = f"Its {CHOSEN}. Where the hand turns round it reaches {{:.2f}} A, unlike Fig. 12 of the paper."


def overview(rows: Rows) -> Overview:
    """Table I, the table of the protocols that judge nothing, and a drawing, as far as their rows were computed."""
    grids = {"table1": judged_grid(rows), "table1-others": other_grid(rows)}
    notes = {"table1": judged_note(rows), "table1-others": other_note(rows)}
    drawn = {"hassan_picks_per_min.svg": svg(picks_figure(rows))} if grids["table1"].rows else {}
    return Overview({name: grid for name, grid in grids.items() if grid.rows}, notes, drawn)


def _cells(rows: Rows, protocol: str, method: str) -> Cells:
    return [rows.get(f"table1/{protocol}/{method}/{zone}/{percent}") for zone, percent in CELLS]


def _line(rows: Rows, protocol: str, method: str) -> list[str]:
    """Text line of a method by a protocol: name, cells, and the greatest acceleration of all cells."""
    cells = _cells(rows, protocol, method)
    peak = max(row["peak_acceleration_ratio"] for row in cells if row)
    name = f"{TITLES[method]}, {PROTOCOLS[protocol].label}"
    return [name, *(number(row, "reproduced", 1) for row in cells), f"{peak:.2f} A"]


def judged_grid(rows: Rows) -> Grid:
    """Table of picks per minute by method: published, and on the paper's path with a constant jerk."""
    lines: list[list[str]] = []
    for method, title in TITLES.items():
        cells = _cells(rows, PAPER, method)
        if any(cells):
            published = [number(row, "published", 0) for row in cells]
            lines += [[f"{title}, published", *published, NONE], _line(rows, PAPER, method)]
    return Grid("Table I, published and reproduced", HEADER, lines)


def other_grid(rows: Rows) -> Grid:
    """Table of picks per minute by method and protocol, for the protocols that judge nothing."""
    shown = [(method, protocol) for method in TITLES for protocol in SHOWN if protocol != PAPER]
    lines = [_line(rows, protocol, method) for method, protocol in shown if any(_cells(rows, protocol, method))]
    return Grid("Table I by other protocols, which judge nothing", HEADER, lines)


def judged_note(rows: Rows) -> str:
    """Sentences below Table I: difference of the paper's path, its peaks, and the bound of a cell."""
    sentences = (
        _difference_sentence(rows, PAPER, "The paper's path with J constant and jerk phases that overlap"),
        value(rows, f"table1/{PAPER}/peak-jerk", PEAK_JERK),
        f"A cell counts as reproduced within {100 * CLOSE:.0f} %, a bound of ours, the minimum-time throw inside at "
        f"40 %, which jumps for small causes, within {100 * CLOSE_FOLD:.0f} %.",
    )
    return " ".join(sentence for sentence in sentences if sentence != NONE)


def other_note(rows: Rows) -> str:
    """Sentences below the table of other protocols: their differences, and how the paper clock was chosen."""
    sentences = (
        _difference_sentence(rows, "paper-clock", "Paper clock, with J scaled and whole ramps that overlap"),
        value(rows, "table1/paper-clock/peak-acceleration", PEAK),
        _difference_sentence(rows, "constant-jerk-stops", "J constant with a stop at every corner, nothing exceeded"),
    )
    return " ".join(sentence for sentence in sentences if sentence != NONE)


def _difference_sentence(rows: Rows, protocol: str, name: str) -> str:
    mean, worst = (rows.get(f"table1/{protocol}/{statistic}-difference") for statistic in ("mean", "worst"))
    if mean is None or worst is None:
        return NONE
    return f"{name}: {mean['reproduced']:.1f} % off on average, {worst['reproduced']:.1f} % at worst."


def picks_figure(rows: Rows) -> Figure:
    """Drawing of the proposed throw's picks per minute in every cell: published, and by each protocol."""
    method = "min-time-throw"
    bars = {"published": (PAPER, "published")}
    bars |= {PROTOCOLS[protocol].label: (protocol, "reproduced") for protocol in SHOWN}
    bars = {name: bar for name, bar in bars.items() if any(_cells(rows, bar[0], method))}
    colours = dict(zip(bars, ("black", *COLOURS), strict=False))
    figure, panels = subplots(2, 1, (WIDTH, 8.0), sharey=True)
    width = 0.86 / len(bars)
    for axes, (zone, percents) in zip(panels, PERCENTAGES.items(), strict=True):
        places = np.arange(len(percents))
        for k, (label, (protocol, entry)) in enumerate(bars.items()):
            folder = f"table1/{protocol}/{method}/{zone}"
            heights = [rows.get(f"{folder}/{percent}", {}).get(entry) or np.nan for percent in percents]
            offset = (k - (len(bars) - 1) / 2) * width
            drawn = axes.bar(places + offset, heights, 0.92 * width, color=colours[label], label=label)
            axes.bar_label(
                drawn, ["" if np.isnan(height) else f"{height:.0f}" for height in heights], fontsize=7, padding=1
            )
        dress(axes, "share of the robot's limits", "picks per minute", f"target {zone} the workspace", axisbelow=True)
        axes.set_xticks(places, [f"{percent} %" for percent in percents])
    figure.legend(*panels[0].get_legend_handles_labels(), fontsize=8, ncols=1, loc="outside lower center")
    return figure
