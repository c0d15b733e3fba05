"""The benchmark at a glance: five controllers, and sorted picks per minute over the throws that learning takes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from ..ground.drawings import COLOURS, WIDTH, Figure, dress, subplots
from ..ground.tables import Grid, millimetres, percent
from .tables import failure_table, first_level

Data = Mapping[str, Any]
SHOWN: Final[Mapping[str, str]] = {
    "analytic": "analytic planner",
    "virtual_goal": "virtual goal (iterative learning)",
    "ridge": "ridge regression",
    "sac": "SAC (reinforcement learning)",
    "oracle": "oracle: simulates each throw first",
}
"""Controllers of the short table, each after the most throws that it has learned from."""
LEARNERS: Final = ("virtual_goal", "ridge", "mlp", "sac")
"""Controllers whose curves are drawn."""
LEVELS: Final = ("analytic", "floor", "oracle")
"""Controllers that are drawn as levels: where learning begins, what the observation allows, an oracle that aims."""


def headline_rows(data: Data) -> tuple[str, list[Data]]:
    """The first level of the plan, and the last row of each controller of the short table on this level."""
    level, rows = first_level(data)
    last = {row["label"]: row for row in rows}
    return level, [last[label] for label in SHOWN if label in last]


def headline_table(data: Data) -> Grid:
    """Five controllers on the first level of the plan."""
    level, shown = headline_rows(data)
    rows = [
        [
            SHOWN[row["label"]],
            f"{row['throws']:,}" if row["throws"] else "-",
            millimetres(row["landing_error_mean_m"]),
            percent(row["success_rate"]),
            f"{row['sorted_per_min']:.1f}",
        ]
        for row in shown
    ]
    note = (
        f"{data['plan']['picks']} held-out throws per seed on `{data['plan']['env']}`, level `{level}`, "
        f"{len(data['plan']['seeds'])} seeds of the learning. Success and pace count picks that fail, objects that the "
        "cup loses and bins that fill, for every controller alike."
    )
    return Grid("", ("controller", "throws to learn", "landing error", "success", "sorted/min"), rows, note)


def headline_failures(data: Data) -> Grid:
    """What stood between an object and its bin, of the same five controllers on the first level of the plan."""
    level, rows = headline_rows(data)
    return failure_table({**data, "table": rows}, level)


def headline_figure(data: Data) -> Figure:
    """Sorted picks per minute over the throws learned from, on the first level of the plan."""
    level, rows = first_level(data)
    figure, (axes,) = subplots(1, 1, (WIDTH, 3.8))
    for label, colour in zip(LEARNERS, COLOURS, strict=False):
        points = sorted((row["throws"], row["sorted_per_min"]) for row in rows if row["label"] == label)
        axes.plot(*zip(*points, strict=True), marker="o", color=colour, label=label) if points else None
    for label, style in zip(LEVELS, ("-", ":", "--"), strict=True):
        for row in (row for row in rows if row["label"] == label):
            axes.axhline(row["sorted_per_min"], color="black", linestyle=style, linewidth=1.0, label=label)
    dress(axes, "throws learned from", "sorted picks per minute", f"level {level}", legend="center right")
    axes.set_xscale("log")
    return figure
