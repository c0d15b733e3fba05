"""Counting throws for the table of a line: the line in which throws are counted, and the table that comes of throws."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final, Literal

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.line.chances import Chances
from pnt_gym.cells.line.config import LineConfig, footprint

from ..judging.losses import Counted, CountedThrows

COVER: Final = 0.15
"""Share of the belt's lanes that objects cover while throws are counted, between those of `speed` and of `single`."""
FASTEST: Final = 20.0
"""Largest rate of arrivals [1/s]."""
DURATION: Final = 40.0
"""Length of the shifts in which throws are counted [s]."""


def counting_line(config: LineConfig, throws: Literal["full", "flight"]) -> LineConfig:
    """The line in which throws are counted: one robot of each kind, all items equally often, cups that always seal.

    Lines of the same cells are counted in the same line, so their tables are the same too. By flights and in the full
    physics the same objects are thrown, so both tables differ by the physics alone.
    """
    kinds, belt = config.kinds(), config.cell.belt
    step = 2.0 * (belt.pick_x[1] - belt.pick_x[0])
    robots = [
        config.robots[kinds.index(kind)].model_copy(update={"name": f"{place}", "x": step * place, "skills": ()})
        for place, kind in enumerate(sorted({*kinds}))
    ]
    taken = [name for name in config.cell.items if any(one.takes(name, config.cell.bins.fixed) for one in robots)]
    pick = config.cell.pick.model_copy(update={"fails": False})
    cell = config.cell.model_copy(update={"mix": dict.fromkeys(taken, 1.0), "pick": pick})
    rate = min(COVER * float(np.ptp(belt.lane_y)) * belt.speed / footprint(cell), FASTEST)
    values = {"cell": cell, "robots": robots, "arrivals": {"rate": rate}, "duration": DURATION, "throws": throws}
    line = LineConfig.load({"name": config.name, **values})
    return with_chances(line, line.digest(), Chances.certain(line.cell))


def with_chances(config: LineConfig, digest: str, chances: Chances) -> LineConfig:
    """The line with a table of chances in the level itself."""
    return LineConfig.load(config, chances={"digest": digest, **chances.entries})


def tabulate(config: LineConfig, thrown: Mapping[str, Any], near: Chances | None = None) -> tuple[Chances, Counted]:
    """Table of a line's chances, and what became of the throws.

    Args:
        config: the line.
        thrown: columns of N throws.
        near: chances of a similar line, towards which the shares are shrunk; None for none.
    """
    held = thrown["picked"]
    columns = {name: thrown[name][held] for name in ("kind", "percent", "distance", "hits")}
    counted = CountedThrows(**{name: thrown[name] for name in CountedThrows._fields})
    chances = Chances.of(_sealing(config, thrown), **columns, near=near)
    return chances, Counted.of(len(config.cell.items), counted)


def _sealing(config: LineConfig, thrown: Mapping[str, Any]) -> Floats:
    """Mean chance that a cup seals on each item (K,), by the places of the cups in some throws."""
    cell, items = config.cell, len(config.cell.items)
    usual = np.array([item.pick_chance for item in cell.item_list()])
    fails = np.minimum(cell.mismatch * (1.0 - usual), 1.0)  # of an item that nobody threw
    sums, counts = (np.bincount(thrown["kind"], weights, items) for weights in (thrown["fails"], None))
    fails = np.divide(sums, counts, out=fails, where=counts > 0)
    return 1.0 - fails if cell.pick.fails else np.ones(items)
