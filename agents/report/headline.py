"""The benchmark at a glance, and beside what other papers publish of cells like its own."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final, NamedTuple

from ..ground.drawings import WIDTH, Figure, dress, say_start, subplots
from ..ground.looks import colours, said
from ..ground.metrics import wilson
from ..ground.tables import Grid, millimetres, percent
from . import tables
from .tables import first_level, who

Data = Mapping[str, Any]
FITTED: Final = "fitted_planner"
"""The planner that fits the cell to a log of its throws."""
LOGGED: Final = 40
"""Throws of a usual log, after which the short table shows the fitted planner, and a learner beside it."""


class Shown(NamedTuple):
    """A row of the short table.

    Attributes:
        label: the controller.
        throws: number of throws that it has learned from; None for the most.
        name: its name for people.
    """

    label: str
    throws: int | None
    name: str


SHOWN: Final = (
    Shown("analytic", None, "analytic planner"),
    Shown(FITTED, LOGGED, "the same planner, fitted to a log of its throws"),
    Shown("ridge", LOGGED, "ridge regression"),
    Shown("virtual_goal", None, "virtual goal (iterative learning)"),
    Shown("ridge", None, "ridge regression"),
    Shown("sac", None, "SAC (reinforcement learning)"),
    Shown("oracle", None, "oracle: simulates each throw first"),
)
"""Rows of the short table; one that the results do not have is left out."""
LEARNERS: Final = ("virtual_goal", "ridge", "mlp", "sac", FITTED)
"""Controllers whose curves are drawn."""
FROM: Final = 40.0
"""Where the pace of the figure begins: from zero, all learners would be one line."""
LINES: Final = {
    "analytic": "the planner, without learning",
    "floor": "a large network after very many throws",
    "oracle": "simulates each throw first",
}
"""What is said of lines."""
LEVELS: Final = tuple(LINES)
"""Controllers that are drawn as levels: where learning begins, a large network after very many throws, an oracle that
aims."""


def rows_shown(data: Data) -> tuple[str, list[tuple[Shown, Data]]]:
    """The first level of the plan, and its rows of the short table."""
    level, rows = first_level(data)
    of_throws = {(row["label"], row["throws"]): row for row in rows}
    last = {row["label"]: row for row in rows}
    found = (
        (shown, last.get(shown.label) if shown.throws is None else of_throws.get((shown.label, shown.throws)))
        for shown in SHOWN
    )
    return level, [(shown, row) for shown, row in found if row is not None]


def table(data: Data) -> Grid:
    """A few controllers on the first level of the plan."""
    level, shown = rows_shown(data)
    rows = [
        [
            name,
            f"{row['throws']:,}" if row["throws"] else "-",
            millimetres(row["landing_error_mean_m"]),
            percent(row["success_rate"]),
            f"{row['sorted_per_min']:.1f}",
        ]
        for (_, _, name), row in shown
    ]
    note = (
        f"{data['plan']['picks']} held-out throws per seed on `{data['plan']['env']}`, level `{level}`, "
        f"{len(data['plan']['seeds'])} seeds of the learning. Success and pace count picks that fail, objects that the "
        "cup loses and bins that fill, for every controller alike."
    )
    return Grid("", ("controller", "throws to learn", "landing error", "success", "sorted/min"), rows, note)


def failures(data: Data) -> Grid:
    """What stood between an object and its bin, in the same rows on the first level of the plan."""
    level, shown = rows_shown(data)
    return tables.failures({**data, "table": [row for _, row in shown]}, level)


def figure(data: Data) -> Figure:
    """Sorted picks per minute over the throws learned from, on the first level of the plan."""
    level, rows = first_level(data)
    figure, (axes,) = subplots(1, 1, (WIDTH, 3.8))
    colour = colours((*LEARNERS, *LEVELS))
    for label in LEARNERS:
        points = sorted((row["throws"], row["sorted_per_min"]) for row in rows if row["label"] == label)
        axes.plot(*zip(*points, strict=True), "o-", color=colour[label], label=said(label)) if points else None
    for label, style in zip(LEVELS, ("-", ":", "--"), strict=True):
        for row in (row for row in rows if row["label"] == label):
            text = f"{label}: {LINES[label]}"
            axes.axhline(row["sorted_per_min"], color=colour[label], linestyle=style, linewidth=1.2, label=text)
    dress(axes, "throws learned from", "sorted picks per minute", f"level {level}")
    figure.legend(fontsize=8, loc="outside lower center", ncols=2)
    axes.set_ylim(bottom=FROM)
    say_start(axes)
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
