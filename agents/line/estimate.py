"""Quick estimates of a line in memory, for a page and for searches: the figures of `line plan --fidelity flight`."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

from pnt_gym.cells.line.config import LineConfig

from .counting import with_chances
from .flown import FlightTable, fly
from .plans import Conditions, Planned, Sweep, assess, make_plans


@final
@dataclass(frozen=True)
class Estimate:
    """Estimate of a line, and the table by which the line was judged."""

    planned: Planned
    table: FlightTable


def estimate(
    config: LineConfig,
    conditions: Conditions,
    flights: int,
    near: FlightTable | None = None,
    release: str | None = None,
) -> Estimate:
    """Judge a line by flights, without a file.

    Equal arguments give equal bits. With `SETTLED` flights the figures are those of `pnt-gym line plan --fidelity
    flight --robots R --minutes M`, where R and M are those of the line. Nothing flies if `near` has as many flights of
    the same cells: other streams, values, skills, places of robots, controllers and standstills leave a table valid.

    Args:
        config: the line.
        conditions: how lines are judged; `throws`, `tables` and `check` do not count here.
        flights: number of flights behind the table.
        near: table of the design before; fewer than `SETTLED` flights are shrunk towards it. None for no such table.
        release: controller that corrects the throws; None for the analytic one.

    Raises:
        PntGymError: the line describes no plan, no robot can throw into its bins, or no object came.
    """
    sweep = Sweep(robots=(len(config.robots),), minutes=config.duration / 60.0)
    numbers, line = next(make_plans(LineConfig.load(config, throws="table", chances=None), sweep))
    conditions = replace(conditions, throws=flights, fidelity="flight", quiet=True)
    table = fly(line, flights, conditions.seed, conditions.threads, release, near)
    given = with_chances(line, table.digest, table.chances)
    return Estimate(assess({**numbers, "chances_by": "random"}, given, table.counted, conditions), table)
