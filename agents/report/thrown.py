"""What `benchmarks/study_line.py` measured as tables: what throwing makes of an order, and what a release adds."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from pnt_gym.arrays import Floats

from ..ground import metrics
from ..ground.tables import Grid
from .line import gain

Data = Mapping[str, Any]


def thrown_table(data: Data) -> Grid:
    """Controllers by the tables of throws, and on the same shifts when everything is really thrown."""
    rows = [
        [
            f"`{level}`",
            f"`{name}`",
            *(_mean(found[throws]) for throws in ("full", "table")),
            f"{100 * found['full']['pick_rate']:.1f} %",
            f"{100 * found['full']['success']:.1f} %",
        ]
        for level, of_level in data["thrown"].items()
        for name, found in of_level.items()
    ]
    header = (
        "level",
        "who decides",
        "value/min, really thrown",
        "by table",
        "picks that held",
        "of these in their bin",
    )
    note = f"The same {data['shifts']} shifts of seed {data['seed']}, in full physics and by table."
    return Grid("Tables against throws", header, rows, note)


def release_table(data: Data) -> Grid:
    """A learned release and a learned order, together and alone."""
    first = value(data["release"]["analytic, fifo"])
    rows = [
        [said, _mean(found), gain(value(found), first), f"{100 * found['success']:.1f} %"]
        for said, found in data["release"].items()
    ]
    header = ("release, order", "value/min", "over the first row", "of what was held in its bin")
    note = (
        f"Level `value` with openings 6 cm wider than what they take, {data['shifts']} shifts in full physics. "
        "The learned release is the policy that ships, trained on other items and bins."
    )
    return Grid("Release and order", header, rows, note)


def value(found: Data) -> Floats:
    """Value a minute of each shift (S,)."""
    return np.array(found["value_per_min"], dtype=np.float64)


def _mean(figures: Data) -> str:
    found = metrics.mean_interval(value(figures))
    return f"{found.value:.1f} ({found.low:.1f}..{found.high:.1f})"
