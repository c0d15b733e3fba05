"""Tables of chances in memory, counted in simulated flights: a second instead of the minutes of the full physics."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf
from typing import Any, Final, final

import numpy as np

from pnt_gym.cells.line.chances import Chances
from pnt_gym.cells.line.config import LineConfig

from ..judging.losses import Counted
from .counting import counting_line, tabulate
from .thrown import NUM_ENVS, random_throws

PROVISIONAL: Final = 256
"""Flights behind a first answer, at once."""
SETTLED: Final = 1000
"""Flights behind an answer that stands, as many as the throws of `line plan`."""


@final
class Flights:
    """Random flights of a line, which grow in number: the first flights are the same however many follow."""

    def __init__(self, config: LineConfig, seed: int, threads: int, release: str | None) -> None:
        self._batches = random_throws(
            counting_line(config, "flight"), inf, seed, NUM_ENVS, threads, release, quiet=True
        )
        self._thrown: list[dict[str, Any]] = []

    def first(self, count: int) -> dict[str, Any]:
        """Columns of the first `count` flights, and of those in the same batch as the last one.

        Raises:
            UsageError: no robot throws.
        """
        batches, total = list[dict[str, Any]](), 0
        while total < count:
            if len(batches) == len(self._thrown):
                self._thrown.append(next(self._batches))
            batches.append(self._thrown[len(batches)])
            total += len(batches[-1]["kind"])
        return {name: np.concatenate([batch[name] for batch in batches]) for name in batches[0]}


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
    thrown: Flights | None = field(default=None, repr=False, compare=False)
    """Flights behind the table, to which more can be added; None where the table is settled."""


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
            at least as many flights, it is returned; if it has fewer, its flights are the first ones. A table of
            other cells is one towards which fewer than `SETTLED` flights are shrunk.

    Raises:
        ConfigError: no robot can throw an object into its bins.
    """
    digest, origin = config.digest(), (seed, release)
    is_same = near is not None and (near.digest, near.origin) == (digest, origin)
    if near is not None and is_same and near.flights >= flights:
        return near
    begun = near.thrown if near is not None and is_same else None
    more = begun or Flights(config, seed, threads, release)
    thrown, names = more.first(flights), config.cell.items
    is_alike = near is not None and near.chances.landed.shape[:2] == (len(names), len(np.unique(thrown["percent"])))
    usual = near.chances if near is not None and is_alike and flights < SETTLED else None
    chances, counted = tabulate(config, thrown, usual)
    return FlightTable(digest, flights, origin, chances, counted, more if flights < SETTLED else None)
