"""What `benchmarks/study_line.py` measured as tables: who decides, what it brings in, and what throwing makes of it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from .. import metrics
from ..drawings import COLOURS, Figure, dress, svg, tiled
from ..tables import Grid
from .page import Chapter

Data = Mapping[str, Any]
CLASS_BLIND: Final = ("spt", "value_rate", "atc", "pair")
"""Rules that do not look at what others can take."""
PLANNERS: Final = ("beam", "price_beam", "joint_beam")
FIRST: Final = "fifo"


def line_chapter(name: str, data: Data) -> Chapter:
    """All tables and the figure of the study."""
    grids = [line_table(data), gains_table(data), thrown_table(data)]
    if data["release"]:
        grids.append(release_table(data))
    if data.get("learned"):
        grids.insert(2, learned_table(data))
    return Chapter(name, tuple(grids), {"line.svg": svg(line_figure(data))})


def value(found: Data) -> Any:
    """Value a minute of each shift."""
    return np.array(found["value_per_min"])


def best(table: Data, names: tuple[str, ...]) -> str:
    """Who of some brings in most on average, on the shifts that all have worked."""
    there = [name for name in names if name in table]
    shared = min(len(value(table[name])) for name in there)
    return max(there, key=lambda name: value(table[name])[:shared].mean())


def everybody(data: Data) -> list[str]:
    """All controllers of all levels, in the order in which they come."""
    return list(dict.fromkeys(name for table in data["line"].values() for name in table))


def line_table(data: Data) -> Grid:
    """Value a minute by controller and level."""
    levels = list(data["line"])
    rows: list[list[str]] = []
    for name in everybody(data):
        found = [data["line"][level].get(name) for level in levels]
        rows.append([f"`{name}`", *("-" if one is None else _mean(value(one)) for one in found)])
    note = (
        f"{data['shifts']} shifts of 120 s each, seed {data['seed']}, the same for all and none that anything was "
        "tuned or trained on, planners but on `single` and `value` the first 25; throws by table; 95 % intervals over "
        "shifts. " + _versions(data)
    )
    return Grid("Value a minute", ["who decides", *(f"`{level}`" for level in levels)], rows, note)


def gains_table(data: Data) -> Grid:
    """What the best of each sort is worth over first in, first out, and over the best class-blind rule."""
    rows: list[list[str]] = []
    for level, table in data["line"].items():
        blind, planner, learned = best(table, CLASS_BLIND), best(table, PLANNERS), learners(table)
        top = best(table, tuple(table))
        won = best(table, learned) if learned else None
        rows.append(
            [
                f"`{level}`",
                f"`{blind}` {_gain(table[blind], table[FIRST])}",
                f"`{top}` {_gain(table[top], table[FIRST])}",
                _gain(table[top], table[blind]),
                "-" if won is None else f"`{won}` {_gain(table[won], table[planner])}",
            ]
        )
    header = ["level", "best class-blind rule over `fifo`", "best of all over `fifo`", "and over that rule"]
    note = "Gains of means, shift by shift, with 95 % intervals; who is best is told by the same shifts."
    return Grid("What the order is worth", [*header, "best learned over best planner"], rows, note)


def learners(table: Data) -> tuple[str, ...]:
    """Those that were learned or tuned by black-box search."""
    known = {"random", FIRST, *CLASS_BLIND, "price", *PLANNERS}
    return tuple(name for name in table if name not in known)


def learned_table(data: Data) -> Grid:
    """What several seeds of those who learn from reward bring in; the worst of them against rules and planners."""
    rows: list[list[str]] = []
    for level, table in data["line"].items():
        others = (best(table, CLASS_BLIND), "price", "beam", best(table, PLANNERS))
        for name, seeds in data["learned"].get(level, {}).items():
            ends = sorted(seeds.values(), key=lambda found: value(found).mean())
            low, high = value(ends[0]).mean(), value(ends[-1]).mean()
            mean = np.mean([value(found).mean() for found in ends])
            against = [f"`{one}` {_gain(ends[0], table[one])}" if one in table else "-" for one in others]
            rows.append([f"`{level}`", f"`{name}`", str(len(ends)), f"{mean:.1f} ({low:.1f}..{high:.1f})", *against])
    header = ["level", "who learned", "seeds", "value/min, mean (worst..best seed)"]
    others = ("the best class-blind rule", "`price`", "`beam`", "the best planner")
    against = [f"worst seed over {one}" for one in others]
    return Grid("Learned from reward, in several seeds", [*header, *against], rows, "Paired by shift, 95 % intervals.")


def thrown_table(data: Data) -> Grid:
    """The same controllers when everything is really thrown."""
    rows = [
        [
            f"`{level}`",
            f"`{name}`",
            _mean(value(found)),
            _mean(value(data["line"][level][name])[: data["thrown_shifts"]]),
            f"{100 * found['pick_rate']:.1f} %",
            f"{100 * found['success']:.1f} %",
        ]
        for level, table in data["full"].items()
        for name, found in table.items()
    ]
    header = (
        "level",
        "who decides",
        "value/min, really thrown",
        "by table",
        "picks that held",
        "of these in their bin",
    )
    note = f"The same {data['thrown_shifts']} shifts, in full physics and by table."
    return Grid("Tables against throws", header, rows, note)


def release_table(data: Data) -> Grid:
    """A learned release and a learned order, together and alone."""
    first = data["release"]["analytic, fifo"]
    rows = [
        [said, _mean(value(found)), _gain(found, first), f"{100 * found['success']:.1f} %"]
        for said, found in data["release"].items()
    ]
    header = ("release, order", "value/min", "over the first row", "of what was held in its bin")
    note = (
        f"Level `value` with openings 6 cm wider than what they take, {data['thrown_shifts']} shifts in full physics. "
        "The learned release is the policy that ships, trained on other items and bins."
    )
    return Grid("Release and order", header, rows, note)


def line_figure(data: Data) -> Figure:
    """Gain over first in, first out by controller, level by level."""
    figure, panels = tiled(len(data["line"]), 3, (3.4, 3.2), sharey=True)
    names = [name for name in everybody(data) if name not in ("random", FIRST)]
    for axes, (level, table) in zip(panels, data["line"].items(), strict=True):
        for at, name in enumerate(names):
            if name not in table:
                continue
            shared = min(len(value(table[name])), len(value(table[FIRST])))
            found = metrics.mean_interval(value(table[name])[:shared] / value(table[FIRST])[:shared].mean() - 1.0)
            low, high = 100 * (found.value - found.low), 100 * (found.high - found.value)
            axes.errorbar(100 * found.value, at, xerr=[[low], [high]], marker="o", color=COLOURS[at % len(COLOURS)])
        axes.axvline(0.0, color="black", linewidth=0.8)
        dress(axes, "over fifo [%]", "", level)
    panels[0].set_yticks(range(len(names)), labels=names)
    panels[0].invert_yaxis()
    return figure


def _mean(values: Any) -> str:
    found = metrics.mean_interval(values)
    return f"{found.value:.1f} ({found.low:.1f}..{found.high:.1f})"


def _gain(one: Data, other: Data) -> str:
    """How much more one brings in than another on the shifts that both have worked."""
    shared = min(len(value(one)), len(value(other)))
    mean = value(other)[:shared].mean()
    found = metrics.paired_mean(value(one)[:shared] / mean, value(other)[:shared] / mean)
    return f"{100 * found.value:+.1f} % ({100 * found.low:+.1f}..{100 * found.high:+.1f})"


def _versions(data: Data) -> str:
    return "Versions: " + ", ".join(f"{name} {version}" for name, version in data["versions"].items()) + "."
