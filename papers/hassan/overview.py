"""Tables of Hassan et al. 2022 over several parts: Table I, and the throw in a free direction."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final, TypeAlias

import numpy as np

from agents.ground.drawings import COLOURS, WIDTH, Figure, dress, subplots, svg
from agents.ground.tables import Grid
from agents.reproduce.finding import Overview
from agents.reproduce.grids import NONE, JsonRow, Rows, number, value

from .cases import CELLS, CHOSEN, CLOSE, CLOSE_FOLD, DWELLS, METHODS, PERCENTAGES, PROTOCOLS, SHOWN, TITLES

Cells: TypeAlias = Sequence[JsonRow | None]
"""The rows of a folder, one for each column of Table I (None: not computed)."""
Cell: TypeAlias = Callable[[JsonRow | None], str]
After: TypeAlias = Callable[[Cells], list[str]]
COLUMNS: Final = [f"{zone} {percent} %" for zone, percent in CELLS]
STRAIGHT: Final = {
    f"table1/{protocol}/{method}": f"{TITLES[method]}, {PROTOCOLS[protocol].label}"
    for method in METHODS
    for protocol in SHOWN
}
"""Names of the paper's methods, by the folder of their rows."""
FREE: Final = {
    "table1/limits-respected/free-direction-throw": "free direction, optimum, J scaled",
    "table1/limits-respected/free-direction-per-pick": "free direction, planned per pick, J scaled",
    "table1/constant-jerk/free-direction-throw": "free direction, optimum, J constant",
}
HEADROOM: Final = {
    "headroom/hand-cap-0": "hand not above the release ceiling",
    "headroom/hand-cap-0.05": "hand at most 0.05 m above it",
    "headroom/window-10ms": "window of 10 ms after the release",
    "headroom/window-30ms": "window of 30 ms",
}
ALL: Final = STRAIGHT | FREE
PROPOSED: Final = {folder: name for folder, name in STRAIGHT.items() if folder.endswith("/min-time-throw")} | FREE
"""The minimum-time throw along a straight line and in a free direction."""
_SCALED, _CONSTANT = "limits-respected", "constant-jerk"
GAINS: Final = (
    *((folder, protocol) for folder in list(FREE)[:2] for protocol in (_SCALED, _CONSTANT)),
    (list(FREE)[2], _CONSTANT),
)
"""Folder of a throw in a free direction, and protocol of the straight throw that it is compared with."""
_BARS: Final = ("black", *(COLOURS[k] for k in (3, 1, 5, 0, 9, 2, 8, 4)))


def overview(rows: Rows) -> Overview:
    """Table I, tables about it and a drawing, as far as their rows were computed."""
    grids = {
        "table1": table1(rows),
        "gains": gains(rows),
        "simulated": simulation(rows),
        "headroom": headroom(rows),
        "dwells": dwells(rows),
    }
    drawn = {"hassan_picks_per_min.svg": svg(picks_figure(rows))} if grids["table1"].rows else {}
    return Overview({name: grid for name, grid in grids.items() if grid.rows}, {"table1": note(rows)}, drawn)


def _cells(rows: Rows, folder: str) -> list[JsonRow | None]:
    return [rows.get(f"{folder}/{zone}/{percent}") for zone, percent in CELLS]


def _grid_lines(rows: Rows, folders: Mapping[str, str], cell: Cell, after: After = lambda _: []) -> list[list[str]]:
    """One text line for each folder that has rows: name, cells, and the sums that ``after`` computes."""
    cells_by_name = {name: _cells(rows, folder) for folder, name in folders.items()}
    return [[name, *map(cell, cells), *after(cells)] for name, cells in cells_by_name.items() if any(cells)]


def table1(rows: Rows) -> Grid:
    """Table of picks per minute: published, by each reading, and in a free direction."""
    lines: list[list[str]] = []
    for folder, name in ALL.items():
        if folder.startswith("table1/paper-clock"):
            published = {folder: f"{TITLES[folder.rsplit('/', 1)[1]]}, published"}
            lines += _grid_lines(rows, published, _format_published, lambda _: [NONE])
        lines += _grid_lines(rows, {folder: name}, _format_picks, _peak_cell)
    return Grid("Table I, published and reproduced", ["picks/min", *COLUMNS, "peak acceleration"], lines)


def _format_published(row: JsonRow | None) -> str:
    return number(row, "published", 0)


def _format_picks(row: JsonRow | None) -> str:
    return "infeasible" if row is not None and row["verdict"] == "infeasible" else number(row, "reproduced", 1)


def _peak_cell(cells: Cells) -> list[str]:
    peaks = [row["peak_acceleration_ratio"] for row in cells if row and "peak_acceleration_ratio" in row]
    return [f"{max(peaks):.2f} A" if peaks else NONE]


def gains(rows: Rows) -> Grid:
    """Table of the free direction's gain over the straight throw within the limits, by either reading of the jerk."""
    lines: list[list[str]] = []
    for folder, protocol in GAINS:
        shares = _gain(rows, folder, protocol)
        if any(share is not None for share in shares):
            name = f"{FREE[folder]}, over {TITLES['min-time-throw']}, {PROTOCOLS[protocol].label}"
            lines.append([name, *(NONE if share is None else f"{100 * share:+.1f} %" for share in shares)])
    return Grid("Gain of the free direction over the straight throw within the limits", ["picks/min", *COLUMNS], lines)


def _gain(rows: Rows, folder: str, protocol: str) -> list[float | None]:
    """Relative gain of the free direction in picks per minute, None where either throw is missing."""
    pairs = zip(_cells(rows, folder), _cells(rows, f"table1/{protocol}/min-time-throw"), strict=True)
    return [
        None if free is None or straight is None or free["reproduced"] is None
        else free["reproduced"] / straight["reproduced"] - 1.0
        for free, straight in pairs
    ]  # fmt: skip


def note(rows: Rows) -> str:
    """Sentences below Table I: each reading's difference, how it was chosen, and the gain of the free direction."""
    heights = [row["hand_above_ceiling_m"] for row in rows.values() if "hand_above_ceiling_m" in row]
    sentences = (
        "The paper leaves open whether the largest jerk J is scaled with the percentage, as in its numeric example, or "
        "stays at 3000 m/s3, and how far moves overlap: the table cannot tell.",
        _difference_sentence(rows, "paper-clock", "Paper clock (J scaled, whole ramps overlap)"),
        value(rows, "table1/paper-clock/peak-acceleration", _PEAK),
        _difference_sentence(
            rows, "constant-jerk-overlap", "The paper's path with J constant and jerk phases that overlap"
        ),
        value(rows, "table1/constant-jerk-overlap/peak-jerk", _PEAK_JERK),
        _difference_sentence(
            rows, "constant-jerk-stops", "The same path with a stop at every corner, nothing exceeded"
        ),
        _difference_sentence(rows, "constant-jerk", "J constant, nothing exceeded, on a free way back that is ours"),
        _difference_sentence(rows, "limits-respected", "J scaled, nothing exceeded, on a free way back"),
        f"A cell counts as reproduced within {100 * CLOSE:.0f} %, a bound of ours, the minimum-time throw inside at "
        f"40 %, which jumps for small causes, within {100 * CLOSE_FOLD:.0f} %.",
        *(_gain_sentence(rows, *pair) for pair in (*GAINS[:2], GAINS[-1])),
        "Every release lies below the same ceiling.",
        f"In the free direction the hand rises up to {max(heights):.2f} m above it." if heights else NONE,
    )
    return " ".join(sentence for sentence in sentences if sentence != NONE)


_PEAK_JERK: Final = "It keeps speed and acceleration; its jerk reaches {:.2f} J where two phases meet."
_PEAK: Final = f"Its {CHOSEN}. Where the hand turns round it reaches {{:.2f}} A, unlike Fig. 12 of the paper."


def _difference_sentence(rows: Rows, protocol: str, name: str) -> str:
    mean, worst = (rows.get(f"table1/{protocol}/{statistic}-difference") for statistic in ("mean", "worst"))
    if mean is None or worst is None:
        return NONE
    return f"{name}: {mean['reproduced']:.1f} % off on average, {worst['reproduced']:.1f} % at worst."


def _gain_sentence(rows: Rows, folder: str, protocol: str) -> str:
    percents = [100.0 * share for share in _gain(rows, folder, protocol) if share is not None]
    if not percents:
        return NONE
    against = f"the straight throw with {PROTOCOLS[protocol].label}"
    return f"F{FREE[folder][1:]}: {min(percents):+.0f} to {max(percents):+.0f} % over {against}."


def simulation(rows: Rows) -> Grid:
    """Table of the simulation with the closed-chain robot, for the cells of Table I."""
    executed = {name: row for name, row in rows.items() if "simulated" in row}
    return Grid(
        "Table I in the simulator: worst landing error without mismatch, and how many are sorted with it",
        ["landing, sorted", *COLUMNS, "touched again", "touched with mismatch", "peak torque"],
        _grid_lines(
            executed,
            ALL,
            _format_landing,
            lambda cells: [_format_touches(cells, "0"), _format_touches(cells, "1"), _format_torque(cells)],
        ),
    )


def _format_landing(row: JsonRow | None) -> str:
    if row is None:
        return NONE
    ideal, realistic = row["simulated"]["0"], row["simulated"]["1"]
    return f"{1000 * ideal['landing_error_max']:.1f} mm, {realistic['sorted']}/{realistic['trials']}"


def _simulation_figures(cells: Cells, mismatch: str, entry: str) -> list[Any]:
    """One figure of each cell that was simulated, at a strength of the mismatch."""
    return [row["simulated"][mismatch][entry] for row in cells if row and "simulated" in row]


def _format_touches(cells: Cells, mismatch: str) -> str:
    recontacts, trials = (sum(_simulation_figures(cells, mismatch, name)) for name in ("recontacts", "trials"))
    return f"{recontacts}/{trials}"


def _format_torque(cells: Cells) -> str:
    return (
        f"{max(torque for mismatch in '01' for torque in _simulation_figures(cells, mismatch, 'peak_torque')):.0f} N m"
    )


def headroom(rows: Rows) -> Grid:
    """Table of the free direction and of the best straight throw, with the cost of further bounds."""
    published = {"table1/paper-clock/min-time-throw": "published, minimum-time throw"}
    lines = _grid_lines(rows, published, _format_published, lambda _: [NONE, NONE])
    lines += _grid_lines(rows, PROPOSED | HEADROOM, _format_picks, _outcome_cells)
    header = ["picks/min", *COLUMNS, "touched again", "sorted with mismatch"]
    return Grid("Release in a free direction, and what bounds cost", header, lines)


def _outcome_cells(cells: Cells) -> list[str]:
    """Objects touched again without mismatch, and share sorted with mismatch, over all cells of a text line."""
    trials = sum(_simulation_figures(cells, "1", "trials"))
    share = f"{100 * sum(_simulation_figures(cells, '1', 'sorted')) / trials:.0f} %" if trials else NONE
    return [_format_touches(cells, "0") if trials else NONE, share]


def dwells(rows: Rows) -> Grid:
    """Table of picks per minute with a gripper that waits at every pick."""
    waits = " or ".join(f"{wait} s" for wait in DWELLS)
    headline = f"With a gripper that waits {waits} at every pick"
    return Grid(headline, ["picks/min", *COLUMNS], _grid_lines(rows, ALL, _format_dwell))


def _format_dwell(row: JsonRow | None) -> str:
    return NONE if row is None else " / ".join(number(row, f"picks_per_min_dwell_{wait}", 1) for wait in DWELLS)


def picks_figure(rows: Rows) -> Figure:
    """Drawing of the proposed throw's picks per minute in every cell: published, reproduced, in a free direction."""
    shown = {name: (folder, "reproduced") for folder, name in PROPOSED.items()}
    bars = {"published": ("table1/paper-clock/min-time-throw", "published"), **shown}
    colours = dict(zip(bars, _BARS, strict=True))
    bars = {name: bar for name, bar in bars.items() if any(_cells(rows, bar[0]))}
    figure, panels = subplots(2, 1, (WIDTH, 8.0), sharey=True)
    width = 0.86 / len(bars)
    for axes, (zone, percents) in zip(panels, PERCENTAGES.items(), strict=True):
        places = np.arange(len(percents))
        for k, (label, (folder, entry)) in enumerate(bars.items()):
            heights = [rows.get(f"{folder}/{zone}/{percent}", {}).get(entry) or np.nan for percent in percents]
            offset = (k - (len(bars) - 1) / 2) * width
            drawn = axes.bar(places + offset, heights, 0.92 * width, color=colours[label], label=label)
            axes.bar_label(
                drawn, ["" if np.isnan(height) else f"{height:.0f}" for height in heights], fontsize=7, padding=1
            )
        dress(axes, "share of the robot's limits", "picks per minute", f"target {zone} the workspace", axisbelow=True)
        axes.set_xticks(places, [f"{percent} %" for percent in percents])
    figure.legend(*panels[0].get_legend_handles_labels(), fontsize=8, ncols=1, loc="outside lower center")
    return figure
