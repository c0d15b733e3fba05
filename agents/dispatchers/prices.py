"""Upper bound of what any order of picks can bring in a shift, by prices of its objects.

Whoever knew every object of a shift in advance would still have to give each object to one robot at one time. Without
the rule that an object is lifted once, each robot would go its own best way, which a pass over its moments finds. A
price on each object restores the rule as far as prices can. For all prices, what the robots' best ways bring beside the
prices, plus the sum of the prices, is at least what any order of picks brings (weak duality). The lowest such bound is
that of the linear programme over (robot, object, time) in which a robot does one thing at a time and an object is
lifted once. With chances in place of draws it is the bound of weakly coupled decision processes (Adelman and Mersereau
2008), which holds for the expected value of whoever does not know the draws.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Floats, take
from pnt_gym.cells.line.links import link_moments
from pnt_gym.cells.line.moments import Moment, Passage, list_moments, list_passages
from pnt_gym.cells.line.rows import Rider, Tables
from pnt_gym.rows import Rows1

from .price_kernel import Network, Prices, Visit, Ways, count_uses, find_ways

STEPS: Final = (0.04, 0.01)
"""Lengths of a step, from the first search for prices to the last one, whose bound counts [s]."""
TRIALS: Final = (250, 60)
"""Prices that are tried at each length of a step."""
AIMS: Final = (0.05, 0.005)
"""By what share of the bound the first prices aim below the bound, at each length of a step."""
PATIENCE: Final = 8
"""Trials without a lower bound after which prices change less."""
LESS: Final = 0.7
"""Factor on the change of prices then."""
MEMORY: Final = 0.3
"""Share of the last direction that the next one keeps."""


@final
@dataclass(frozen=True)
class Bound:
    """Upper bound of the value of a shift.

    Attributes:
        value: no order of picks brings more.
        prices: the prices that show it.
        network: the moments of the shift.
        step: length of their step [s].
    """

    value: float
    prices: Prices
    network: Network
    step: float


def make_network(tables: Tables, riders: Rows1[Rider], step: float, *, is_drawn: bool) -> Network:
    """Moments of a shift and what may follow them.

    Args:
        tables: tables of the line.
        riders: the objects of the shift (M,).
        step: length of a step [s].
        is_drawn: whether cups seal and throws land as the objects' draws say, and not with the chances of the table.
    """
    passages = list_passages(tables, riders, step, is_drawn)
    moments = list_moments(tables, riders, passages, step)
    links = link_moments(tables, riders, passages, moments, step)
    return Network(passages, moments, _list_visits(passages, moments), links)


def _list_visits(passages: Rows1[Passage], moments: Rows1[Moment]) -> Rows1[Visit]:
    """The visits of all moments."""
    row, own = np.arange(len(moments)), passages[np.repeat(np.arange(len(passages)), passages["count"])]
    place = row - own["first_row"]
    visits = Visit.zeros(len(moments), row=row, step=own["first_step"] + place)
    for name in ("robot", "index", "seal", "failures"):
        visits[name] = own[name]
    visits["worth"], visits["can_throw"] = moments["worth"], moments["can_throw"]
    visits["is_first"], visits["is_last"] = place == 0, place + 1 == own["count"]
    return take(visits, np.argsort(-visits["step"], kind="stable"))


def best_ways(network: Network, prices: Prices, robots: int) -> Ways:
    """The best ways of all robots at some prices."""
    ways = _empty_ways(network, robots)
    find_ways(network, prices, ways)
    return ways


def _empty_ways(network: Network, robots: int) -> Ways:
    count, shape = len(network.moments), (robots, int(network.visits["step"].max()) + 2)
    ends = np.empty((2, count)), np.empty((2, count), dtype=np.int64)
    robots_ways = np.empty(shape), np.empty(shape, dtype=np.int64)
    return Ways(np.empty(count), np.empty(count, dtype=np.bool_), *ends, *robots_ways)


@final
class PriceSearch:
    """Search for the prices with the lowest bound, by steps along subgradients.

    Args:
        network: the moments of a shift.
        objects: number of objects M.
        robots: number of robots R.
    """

    def __init__(self, network: Network, objects: int, robots: int) -> None:
        self._network, self._ways = network, _empty_ways(network, robots)
        self._mass, self._uses = np.empty(len(network.moments)), np.empty((2, objects))
        self._failures = np.zeros(objects)
        self._failures[network.passages["index"]] = network.passages["failures"]

    def run(self, begin: Prices, aim: float, trials: int) -> tuple[float, Prices]:
        """The lowest bound of some trials and its prices.

        Args:
            begin: the first prices.
            aim: by what share of the bound the first change of prices aims below the bound.
            trials: number of trials.
        """
        lowest, best, since = np.inf, begin, 0
        prices, direction = begin, np.zeros_like(self._uses)
        for _ in range(trials):
            value, slopes = self._try(prices)
            since = 0 if value < lowest else since + 1
            if value < lowest:
                lowest, best = value, prices
            elif since == PATIENCE:
                aim, since, prices = aim * LESS, 0, best
            direction = slopes + MEMORY * direction
            length = float(np.square(direction).sum())
            if length == 0.0:
                break
            change = aim * lowest / length * direction
            prices = Prices(np.maximum(prices.taken + change[0], 0.0), np.maximum(prices.failed + change[1], 0.0))
        return lowest, best

    def _try(self, prices: Prices) -> tuple[float, Floats]:
        """The bound at some prices, and its slopes by them (2, M), where prices can move so."""
        find_ways(self._network, prices, self._ways)
        count_uses(self._network, self._ways, self._mass, *self._uses)
        taken, failed = self._uses
        slopes = np.stack([taken - 1.0, self._failures * taken - failed])
        slopes[(np.stack(prices) <= 0.0) & (slopes < 0.0)] = 0.0
        return float(self._ways.later[:, 0].sum() + prices.taken.sum()), slopes


def find_bound(tables: Tables, riders: Rows1[Rider], *, is_drawn: bool) -> Bound:
    """Upper bound of the value that any order of picks brings in a shift.

    Args:
        tables: tables of the line.
        riders: the objects of the shift (M,).
        is_drawn: whether seals and landings count as the objects' draws say; otherwise the bound is one of the expected
            value of whoever does not know the draws.
    """
    robots, objects = len(tables.stations), len(riders)
    prices = Prices(*np.zeros((2, objects)))
    coarse, fine = (make_network(tables, riders, step, is_drawn=is_drawn) for step in STEPS)
    _, prices = PriceSearch(coarse, objects, robots).run(prices, AIMS[0], TRIALS[0])
    value, prices = PriceSearch(fine, objects, robots).run(prices, AIMS[1], TRIALS[1])
    return Bound(value, prices, fine, STEPS[1])
