"""Gantt chart of one work shift: which robot of a line took which object, and when."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from ...ground.drawings import COLOURS, WIDTH, dress, subplots, svg

HIGH: Final = 0.8
"""Height of a bar as a share of the distance between rows."""
PALE: Final = 0.35
"""Opacity of failed cycles."""


def gantt(report: Mapping[str, Any], shift: int = 0, span: tuple[float, float] = (0.0, 60.0)) -> str:
    """Chart with a row for each robot and a bar for each of its cycles, as SVG.

    The colour is the item as which the robot took the object. A pale bar is an object that did not end in a bin of its
    kind. A bar begins when the robot's standstill above the belt ends.

    Args:
        report: report of an evaluation.
        shift: number of the shift.
        span: begin and end of the chart [s].
    """
    robots, items = report["robots"], report["items"]
    throws = [throw for throw in report["throws"] if throw["shift"] == shift]
    decisions = {name: np.array([throw[name] for throw in throws]) for name in throws[0]}
    begin, end = span
    figure, (axes,) = subplots(1, 1, (WIDTH, 0.7 * len(robots) + 1.4))
    for index in range(len(items)):
        for sorted_ in (True, False):
            rows = (decisions["item"] == index) & (decisions["sorted"].astype(bool) == sorted_)
            rows &= (decisions["start"] < end) & (decisions["start"] + decisions["cycle_time"] > begin)
            start = decisions["start"][rows] + decisions["wait_time"][rows]
            axes.barh(
                decisions["by"][rows],
                decisions["cycle_time"][rows] - decisions["wait_time"][rows],
                left=start,
                height=HIGH,
                color=COLOURS[index % len(COLOURS)],
                alpha=1.0 if sorted_ else PALE,
                edgecolor="white",
                linewidth=0.5,
                label=items[index] if sorted_ else None,
            )
    axes.set_yticks(np.arange(len(robots)), labels=list(robots))
    axes.invert_yaxis()
    dress(axes, "time since the begin of the shift [s]", "", xlim=span)
    figure.legend(*axes.get_legend_handles_labels(), fontsize=8, loc="outside lower center", ncols=4)
    return svg(figure)
