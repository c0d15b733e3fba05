"""Tables of chances in memory, counted in simulated flights: a second instead of the minutes of the full physics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final, final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.line.chances import Chances
from pnt_gym.cells.line.config import LineConfig, footprint

from ..judging.losses import Counted, CountedThrows
from .thrown import NUM_ENVS, random_throws

PROVISIONAL: Final = 256
"""Flights behind a first answer, at once."""
SETTLED: Final = 1000
"""Flights behind an answer that stands, as many as the throws of `line plan`."""
COVER: Final = 0.15
"""Share of the belt's lanes that objects cover while flights are counted, between those of `speed` and of `single`."""
FASTEST: Final = 20.0
"""Largest rate of arrivals [1/s]."""
DURATION: Final = 40.0
"""Length of the shifts in which flights are counted [s]."""


@final
@dataclass(frozen=True)
class FlightTable:
    """Table of the chances of a line's throws, and what became of the flights behind the table."""

    digest: str
    """Name of the cells in which the objects flew."""
    flights: int
    """Number of flights asked for."""
    origin: tuple[int, str | None]
    """Seed of the objects, and what corrected the throws."""
    chances: Chances
    counted: Counted

    def given_to(self, config: LineConfig) -> LineConfig:
        """The line with this table."""
        return with_chances(config, self.digest, self.chances)


def fly(
    config: LineConfig,
    flights: int,
    seed: int,
    threads: int,
    release: str | None = None,
    near: FlightTable | None = None,
) -> FlightTable:
    """Count flights for the table of a line; the table depends on the line's cells and not on its stream.

    Args:
        config: the line.
        flights: number of flights, at least.
        seed: seed of the objects.
        threads: threads of the simulation.
        release: what corrects the throws; None for nothing.
        near: table of a similar line; None for no such line. If that table has the same cells, seed and release and
            at least as many flights, it is returned. Otherwise fewer than `SETTLED` flights are shrunk towards it.

    Raises:
        ConfigError: no robot can throw an object into its bins.
    """
    digest, origin = config.digest(), (seed, release)
    if near is not None and (near.digest, near.origin) == (digest, origin) and near.flights >= flights:
        return near
    batches = list(random_throws(counting_line(config), flights, seed, NUM_ENVS, threads, release, quiet=True))
    thrown = {name: np.concatenate([part[name] for part in batches]) for name in batches[0]}
    names = config.cell.items
    is_alike = near is not None and near.chances.landed.shape[:2] == (len(names), len(np.unique(thrown["percent"])))
    usual = near.chances if near is not None and is_alike and flights < SETTLED else None
    columns = {name: thrown[name] for name in ("kind", "percent", "distance", "hits")}
    chances = Chances.from_held(sealing(config, thrown), **columns, near=usual)
    counted = Counted.from_throws(len(names), CountedThrows(**{name: thrown[name] for name in CountedThrows._fields}))
    return FlightTable(digest, flights, origin, chances, counted)


def sealing(config: LineConfig, thrown: Mapping[str, Any]) -> Floats:
    """Mean chance that a cup seals on each item (K,), by the places of the cups in some throws."""
    cell, items = config.cell, len(config.cell.items)
    usual = np.array([item.pick_chance for item in cell.item_list()])
    fails = np.minimum(cell.mismatch * (1.0 - usual), 1.0)  # of an item that nobody threw
    sums, counts = (np.bincount(thrown["kind"], weights, items) for weights in (thrown["fails"], None))
    fails = np.divide(sums, counts, out=fails, where=counts > 0)
    return 1.0 - fails if cell.pick.fails else np.ones(items)


def counting_line(config: LineConfig) -> LineConfig:
    """The line in which flights are counted: one robot of each kind, all items equally often, cups that always seal.

    Lines of the same cells are counted in the same line, so their tables are the same too.
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
    values = {"cell": cell, "robots": robots, "arrivals": {"rate": rate}, "duration": DURATION, "throws": "flight"}
    line = LineConfig.load({"name": config.name, **values})
    return with_chances(line, line.digest(), Chances.certain(line.cell))


def with_chances(config: LineConfig, digest: str, chances: Chances) -> LineConfig:
    """The line with a table of chances in the level itself."""
    return LineConfig.load(config, chances={"digest": digest, **chances.entries})
