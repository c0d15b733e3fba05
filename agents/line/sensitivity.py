"""Which assumed number decides: each number at both ends of its plausible range, and what a line then sorts."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, Final

import numpy as np

from pnt_gym.cells.base.items import Item
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.errors import ConfigError

from ..ground.drawings import COLOURS, Axes, dress
from ..ground.metrics import Interval
from ..ground.tables import Grid
from .changes import Change, Differences, Gain, cell_differences, section_differences
from .plans import Planned

RANGES: Final = "cells"
"""Level of the conveyor whose section `cells` has the ranges in which cells differ."""
MASS: Final = (0.8, 1.2)
"""Range of the mass of an item over that of the level, assumed."""
HOLD: Final = (0.7, 1.3)
"""Range of the cup's holding force on an item over that of the level, assumed."""

GREY: Final = "#b0b0b0"
"""Colour of what makes no difference."""
BAR: Final = 0.38
"""Height of a bar over the distance of two numbers."""


def assumptions(line: LineConfig) -> list[Change]:
    """Lines with one assumed number at an end of its range; ends that a line cannot have are left out."""
    found = list[Change]()
    for name, text, differences in _ends(line):
        try:
            found.append(Change(name, text, LineConfig.load(line, chances=None, **differences)))
        except ConfigError:
            continue
    return found


def widest_first(gains: Sequence[Gain]) -> list[Gain]:
    """What ends of numbers bring, both ends of the number that moves the recovery most first."""
    widths = dict[str, float]()
    for name in {gain.what for gain in gains}:
        values = [0.0, *(gain.points.value for gain in gains if gain.what == name)]
        widths[name] = max(values) - min(values)
    return sorted(gains, key=lambda gain: (-widths[gain.what], gain.what, gain.points.value))


def _ends(line: LineConfig) -> Iterator[tuple[str, str, Differences]]:
    """Name, value in words and differences of both ends of each assumed number."""
    cell, ranges = line.cell, ConveyorConfig.load(RANGES).cells.ranges
    for key in ("valve", "tau"):
        for value in ranges[key]:
            yield f"suction.{key}", f"{1000 * value:g} ms", section_differences(line, "suction", **{key: value})
    for value in ranges["blow_off"]:
        yield "cup.blow_off", f"{value:g} m/s", section_differences(line, "cup", blow_off=value)
    if cell.cup.stiffness is not None:
        for factor in ranges["stiffness"]:
            changed = section_differences(line, "cup", stiffness=factor * cell.cup.stiffness)
            yield "cup.stiffness", f"x {factor:g}", changed
    for name, (low, high) in {
        "mass": MASS,
        "seal_force": HOLD,
        **{k: ranges[k] for k in ("drag", "restitution")},
    }.items():
        for factor in (low, high):
            yield f"{name} of all items", f"x {factor:g}", _scaled(line, name, factor)
    for points in ranges["seal"]:
        chances = [
            item.model_copy(update={"pick_chance": float(np.clip(item.pick_chance + points, 0.01, 1.0))})
            for item in cell.item_list()
        ]
        yield "pick_chance of all items", f"{100 * points:+g} points", _items(line, chances)


def _scaled(line: LineConfig, name: str, factor: float) -> Differences:
    """Differences of a line, one value of whose items is multiplied; a restitution stays at most 1."""
    items = list[Item]()
    for item in line.cell.item_list():
        value = getattr(item, name)
        most = 1.0 if name == "restitution" else np.inf
        items.append(item if value is None else item.model_copy(update={name: float(min(factor * value, most))}))
    return _items(line, items)


def _items(line: LineConfig, items: Sequence[Item]) -> Differences:
    """Differences of a line with other values of its items."""
    return cell_differences(line, extra_items=[item.model_dump(mode="json") for item in items])


def table(title: str, line: Planned, gains: Sequence[Gain]) -> Grid:
    """Table of what ends of assumed numbers bring to a line."""
    header = ["assumed number", "at", "recovery", "points (95 % interval)", "decides"]
    rows = [[gain.what, gain.to, f"{100 * gain.recovery:.1f}", *_points(gain.points)] for gain in gains]
    if line.row["money_per_hour"] is not None:
        header.append("money/h")
        rows = [[*row, f"{gain.money_per_hour:.2f}"] for row, gain in zip(rows, gains, strict=True)]
    return Grid(f"{title}; as the level says: recovery {100 * line.row['recovery']:.1f} %", header, rows)


def _points(points: Interval) -> tuple[str, str]:
    """A difference in points with its interval, and whether the difference is one."""
    value, low, high = (100.0 * end for end in (points.value, points.low, points.high))
    return f"{value:+.1f} ({low:+.1f}..{high:+.1f})", "yes" if points.excludes_zero else "no difference"


def draw(part: Any, gains: Sequence[Gain], money: float | None) -> None:
    """Draw tornado charts into a part of a figure: how far each number moves the recovery, and the money an hour.

    Args:
        part: part of a figure.
        gains: what both ends of the numbers bring, the widest first.
        money: money an hour of the line as the level says; None for a line without costs.
    """
    panels = np.ravel(part.subplots(1, 1 if money is None else 2, sharey=True))
    points = [100.0 * gain.points.value for gain in gains]
    _draw_bars(panels[0], gains, points, "recovery [points]; grey: no difference")
    if money is not None:
        _draw_bars(panels[1], gains, [(gain.money_per_hour or money) - money for gain in gains], "money an hour")
    panels[0].set_title("Which assumed number decides: differences", fontsize=10)


def _draw_bars(axes: Axes, gains: Sequence[Gain], values: Sequence[float], label: str) -> None:
    """Draw a bar for each end of each number, the two ends of a number below each other."""
    names = list(dict.fromkeys(gain.what for gain in gains))
    ends = dict.fromkeys(names, 0)
    for gain, value in zip(gains, values, strict=True):
        place = names.index(gain.what) + BAR * (ends[gain.what] - 0.5)
        ends[gain.what] += 1
        colour = COLOURS[0 if value >= 0.0 else 3] if gain.points.excludes_zero else GREY
        axes.barh(place, value, color=colour, height=BAR)
        side, offset = ("left", 4) if value >= 0.0 else ("right", -4)
        options = {"textcoords": "offset points", "ha": side, "va": "center", "fontsize": 7}
        axes.annotate(gain.to, (value, place), (offset, 0), **options)
    axes.axvline(0.0, color="black", linewidth=0.8)
    axes.set_yticks(np.arange(len(names)), labels=names, fontsize=8)
    axes.set_ylim(len(names) - 0.5, -0.5)
    axes.margins(x=0.2)
    dress(axes, label, "")


def entries(gains: Sequence[Gain]) -> list[dict[str, Any]]:
    """What ends of assumed numbers bring, by the names of the JSON contract."""
    return [
        {
            "number": gain.what,
            "at": gain.to,
            "recovery": gain.recovery,
            "points": gain.points.value,
            "points_low": gain.points.low,
            "points_high": gain.points.high,
            "money_per_hour": gain.money_per_hour,
        }
        for gain in gains
    ]
