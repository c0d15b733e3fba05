"""Picture of a sequential comparison: how the interval of each difference narrowed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np

from ..ground.drawings import COLOURS, dress, subplots, svg

ZOOM: Final = 4.0
"""Height of the picture, as a multiple of the widest interval at the end or of the differences."""


def intervals(report: Mapping[str, Any]) -> str:
    """Mean difference and interval of every pair over the units, with zero and the margin, as SVG.

    Args:
        report: report of a comparison.
    """
    figure = next(iter(report["figures"].values()))
    picture, (axes,) = subplots(1, 1, (7.5, 4.2))
    reach = 0.0
    for number, pair in enumerate(report["pairs"]):
        trace = np.array(pair["trace"], dtype=np.float64).reshape(-1, 4)
        count, (value, low, high) = trace[:, 0], figure["scale"] * trace[:, 1:].T
        colour = COLOURS[number % len(COLOURS)]
        axes.fill_between(count, low, high, step="post", color=colour, alpha=0.25, linewidth=0.0)
        axes.step(count, value, where="post", color=colour, label=f"{pair['a']} minus {pair['b']}")
        if pair["settled"] is not None:
            axes.axvline(pair["settled"], color=colour, linestyle=":", linewidth=1.0)
        if len(trace):
            reach = max(reach, float(high[-1] - low[-1]), float(np.abs(value).max()))
    axes.axhline(0.0, color="black", linewidth=1.0)
    for margin in () if report["margin"] is None else (-report["margin"], report["margin"]):
        axes.axhline(figure["scale"] * margin, color="black", linestyle="--", linewidth=0.8)
    limits = {"ylim": (-ZOOM * reach / 2.0, ZOOM * reach / 2.0)} if reach else {}
    up = f"difference in {figure['label']} [{figure['unit']}]" if figure["unit"] else f"difference in {figure['label']}"
    title = f"{report['env']}, level {report['level']}: 95 % intervals, valid at all times"
    dress(axes, f"{report['unit']} of each controller", up, title, legend="best", **limits)
    return svg(picture)
