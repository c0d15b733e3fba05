"""The benchmark at a glance, and beside what other papers publish of cells like its own."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from ..ground.drawings import COLOURS, WIDTH, Figure, dress, subplots
from ..ground.metrics import wilson
from ..ground.tables import Grid, millimetres, percent
from . import tables
from .tables import first_level, who

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


def _rows(data: Data) -> tuple[str, list[Data]]:
    """The first level of the plan, and the last row of each controller of the short table on this level."""
    level, rows = first_level(data)
    last = {row["label"]: row for row in rows}
    return level, [last[label] for label in SHOWN if label in last]


def table(data: Data) -> Grid:
    """Five controllers on the first level of the plan."""
    level, shown = _rows(data)
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


def failures(data: Data) -> Grid:
    """What stood between an object and its bin, of the same five controllers on the first level of the plan."""
    level, rows = _rows(data)
    return tables.failures({**data, "table": rows}, level)


def figure(data: Data) -> Figure:
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


PUBLISHED: Final[Mapping[str, tuple[tuple[str, float], ...]]] = {
    "cubes": (("SAC", 0.956), ("TD3", 0.939), ("PPO", 0.448)),
    "boxes": (("TossingBot, known objects", 0.847), ("TossingBot, new objects", 0.823)),
}
"""Shares of throws that succeed, by level. Cubes: 10,000 throws of each tuned policy, simulated, in results/*_opt.csv
of the code of Louette et al. 2024 (arXiv 2406.13453). Boxes: real throws of what was grasped, Zeng et al. 2019 (arXiv
1903.11239)."""
SOURCES: Final = {"cubes": "Louette et al. 2024", "boxes": "Zeng et al. 2019"}


def peers(data: Data) -> Grid:
    """Success of ours and of theirs, level by level."""
    rows: list[list[str]] = []
    for level in data["plan"]["levels"]:
        count = data["plan"]["picks_on"].get(level, data["plan"]["picks"])
        for row in (row for row in data["table"] if row["level"] == level):
            success = wilson(round(row["success_rate"] * count), count)
            interval = f"{100 * success.value:.2f} % ({100 * success.low:.2f}..{100 * success.high:.2f})"
            rows.append([level, *who(row), f"{count:,}", interval, f"{row['sorted_per_min']:.1f}"])
        rows += [[level, name, "-", "-", percent(share), "-"] for name, share in PUBLISHED.get(level, ())]
    levels = [f"`{level}`: {SOURCES[level]}" for level in data["plan"]["levels"] if level in SOURCES]
    note = (
        f"Rows without throws are published ({'; '.join(levels)}); their cells differ from these as the levels say. "
        f"Intervals are Wilson's at 95 %. Environment `{data['plan']['env']}`, full physics, held-out throws; "
        "controllers that learn do so on the level itself."
    )
    header = ("level", "controller", "throws to learn", "throws", "success", "sorted/min")
    return Grid("Cells of other papers", header, rows, note)
