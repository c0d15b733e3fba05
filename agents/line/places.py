"""Search for better places of a line's bins and robots, by estimates, and its verdict in the full physics."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.errors import PntGymError

from ..ground import metrics
from ..ground.cli import UsageError, check_libraries
from ..ground.metrics import Interval
from ..ground.tables import percent
from .estimate import estimate
from .flown import SETTLED
from .layouts import Grounds, Layout, Rectangle, What
from .plans import Conditions, simulate

FLIGHTS: Final = (128, 256, 512)
"""Flights behind an estimate: of simple changes, of CMA-ES, and of simple changes of what it found."""
LEADERS: Final = 4
"""Layouts that are estimated again with more flights, because the best of many rough estimates is too good."""
NEARER: Final = (0.1, 0.2, 0.3)
"""Ways by which all bins come nearer to the belt, for the search to begin with [m]."""
BEGIN: Final = 0.35
"""Share of the tries for simple changes, before CMA-ES."""
FIRST: Final = 0.7
"""Share of the tries until which CMA-ES moves bins alone, where robots are placed too: bins are worth more."""
END: Final = 0.85
"""Share of the tries after which CMA-ES ends, for simple changes of what it found."""
SIGMA: Final = (0.05, 0.20)
"""Standard deviations with which the search begins, of bins and of robots [m]."""
FINALISTS: Final = 3
"""Layouts that are judged in the full physics."""
SETTLING: Final = 2 * FINALISTS
"""Layouts that are estimated with settled tables, of which the finalists are the best."""
SHIFTS: Final = 8
"""Shifts behind an estimate of the search, at most."""


@final
@dataclass(frozen=True)
class Progress:
    """State of a search."""

    stage: str
    """What is going on."""
    tried: int
    """Layouts tried so far."""
    tries: int
    today: float
    """Recovery of the first possible layout, today's if that is one, by the search's estimate."""
    best: float
    """Recovery of the best layout so far, by the search's estimate."""


@final
@dataclass(frozen=True)
class Improvement:
    """The better places of a line that a search found, judged in the full physics."""

    config: LineConfig
    """The line with the places found; the line itself where nothing better was found."""
    differences: dict[str, Any]
    """What the places change in the line's level, in the form of a level's file."""
    today: float
    """Recovery of today's layout in the full physics."""
    found: float
    """Recovery of the layout found, in the same shifts."""
    gain: Interval
    """Difference, paired by shift, with its 95 % interval."""
    shifts: int
    """Shifts behind the gain."""
    tried: int
    """Layouts tried."""

    @property
    def sentence(self) -> str:
        """The verdict."""
        points = [f"{100.0 * end:+.1f}" for end in (self.gain.value, self.gain.low, self.gain.high)]
        where = "in the full physics" if self.config.finest == "full" else "by simulated flights"
        figures = (
            f"in {self.shifts} shifts {where} the places found sort {percent(self.found)} and today's "
            f"{percent(self.today)}, {points[0]} points ({points[1]}..{points[2]})"
        )
        return figures if self.gain.excludes_zero else f"no difference: {figures}"

    @property
    def entries(self) -> dict[str, Any]:
        """The verdict by the names of the JSON contract."""
        names = ("differences", "today", "found", "shifts", "tried", "sentence")
        gain = {"gain": self.gain.value, "gain_low": self.gain.low, "gain_high": self.gain.high}
        return {name: getattr(self, name) for name in names} | gain


@final
class Search:
    """Tries layouts by estimates on the same objects, and remembers what they sort.

    Args:
        grounds: where bins and robots may stand.
        conditions: how layouts are judged.
        tries: most estimates.
        tell: called with the progress after each estimate.
        should_stop: whether the search shall end now.
    """

    def __init__(
        self,
        grounds: Grounds,
        conditions: Conditions,
        tries: int,
        tell: Callable[[Progress], object],
        should_stop: Callable[[], bool],
    ) -> None:
        self.grounds, self.tries, self.tried, self.stage = grounds, tries, 0, "today's layout"
        self._conditions = replace(conditions, shifts=min(conditions.shifts, SHIFTS))
        self._tell, self._should_stop = tell, should_stop
        self.flights = FLIGHTS[0]
        """Flights behind an estimate now."""
        self.known: dict[tuple[float, ...], tuple[float, Layout]] = {}
        """Recovery by as many flights of each possible layout, and the layout, by its vector."""

    def is_over(self, share: float = 1.0) -> bool:
        """Whether a share of the tries is used up, or the search shall end."""
        return self.tried >= share * self.tries or self._should_stop()

    def refine(self, flights: int) -> None:
        """Estimate today's and the best layouts again with more flights, and forget the rough estimates."""
        if self.is_over():
            return
        before, leaders = self.known, [self.grounds.today, *self.best(LEADERS)]
        self.flights, self.known = flights, {}
        self.try_all(f"again with {flights} flights", leaders, 1.0)
        if self.is_over():  # perhaps before the best ones came
            self.known = before | self.known

    def best(self, count: int) -> list[Layout]:
        """The best layouts so far."""
        ranked = sorted(self.known.values(), key=lambda entry: -entry[0])
        return [layout for _, layout in ranked[:count]]

    def cost(self, layout: Layout) -> float:
        """Cost of a layout: its recovery below 0, or above 0 how far the layout is from a possible one."""
        violation = self.grounds.violation(layout)
        if violation > 0.0:
            return violation
        key, now = tuple(self.grounds.vector(layout)), self.known
        if key not in now:
            recovery = self.recovery(layout, self.flights)
            self.tried += 1
            if recovery is None:
                return float(np.abs(self.grounds.vector(layout) - self.grounds.vector(self.grounds.today)).sum())
            now[key] = recovery, layout
            self.tell()
        return -now[key][0]

    def tell(self) -> None:
        """Tell the progress of the search."""
        scores = [recovery for recovery, _ in self.known.values()]
        self._tell(Progress(self.stage, self.tried, self.tries, scores[0], max(scores)))

    def recovery(self, layout: Layout, flights: int) -> float | None:
        """Estimated recovery of a layout; None where the layout is no possible line.

        Raises:
            PntGymError: today's layout cannot be judged.
        """
        try:
            return float(estimate(self.grounds.line(layout), self._conditions, flights).planned.row["recovery"])
        except PntGymError:
            if layout is self.grounds.today:
                raise
            return None

    def run(self, seed: int) -> list[Layout]:
        """The best layouts by settled estimates, of simple changes of today's layout and of what CMA-ES finds.

        Raises:
            UsageError: no layout to begin with is possible.
        """
        grounds = self.grounds
        self.try_all("bins nearer to the belt", [grounds.today, *map(grounds.nearer, NEARER)], BEGIN)
        if not self.known:
            raise UsageError(
                f"level {grounds.config.name!r}: neither today's places nor places nearer to the belt keep clear of "
                "belt, bins and what is kept free"
            )
        self.exchange(BEGIN)
        self.refine(FLIGHTS[1])
        is_bin = grounds.free < grounds.today.bins.size
        if is_bin.any() and not is_bin.all():
            self.evolve(seed, FIRST, is_bin)
        self.evolve(seed, END, np.ones_like(is_bin))
        self.refine(FLIGHTS[2])
        self.exchange(1.0)
        self.stage = "settled estimates"
        self.tell()
        settled = {tuple(grounds.vector(layout)): layout for layout in self.best(SETTLING)}
        scores = {key: self.recovery(layout, SETTLED) or 0.0 for key, layout in settled.items()}
        return [settled[key] for key in sorted(scores, key=lambda key: -scores[key])][:FINALISTS]

    def exchange(self, share: float) -> None:
        """Exchange bins and let bins cross the belt, as long as that is better, and until a share of the tries."""
        before: Layout | None = None
        while before is not (best := self.best(1)[0]) and not self.is_over(share):
            self.try_all("bins exchanged", [*self.grounds.crossings(best), *self.grounds.swaps(best)], share)
            before = best

    def try_all(self, stage: str, layouts: Iterable[Layout], share: float) -> None:
        """Try some layouts, until a share of the tries is used up; today's layout is always tried."""
        self.stage = stage
        for layout in layouts:
            if self.known and self.is_over(share):
                return
            self.cost(layout)

    def evolve(self, seed: int, share: float, moves: Bools) -> None:
        """Search around the best layout by CMA-ES over the numbers that move, until a share of the tries is used up."""
        import cma  # noqa: PLC0415 - an extra that only searches need

        self.stage = "search"
        is_bin, centre = self.grounds.free < self.grounds.today.bins.size, self.grounds.vector(self.best(1)[0])
        options = {"seed": seed + 1, "verbose": -9, "CMA_stds": np.where(is_bin, *SIGMA)[moves], "maxiter": self.tries}
        strategy: Any = cma.CMAEvolutionStrategy(centre[moves], 1.0, options)
        while not (self.is_over(share) or strategy.stop()):
            vectors, costs = strategy.ask(), list[float]()
            while len(costs) < len(vectors) and not self.is_over(share):
                vector = centre.copy()
                vector[moves] = vectors[len(costs)]
                costs.append(self.cost(self.grounds.layout(vector)))
            if len(costs) == len(vectors):
                strategy.tell(vectors, costs)


def improve(
    config: LineConfig,
    conditions: Conditions,
    what: What = "bins",
    keep_out: Sequence[Rectangle] = (),
    tries: int = 100,
    tell: Callable[[Progress], object] = lambda progress: None,
    should_stop: Callable[[], bool] = lambda: False,
) -> Improvement:
    """Find better places of a line's bins and robots by estimates, and judge the best ones in the full physics.

    The best of the finalists is chosen in `check` shifts in the full physics, at least 2, and compared with today's
    layout in twice as many other shifts, paired. A search that is stopped is judged too.

    Args:
        config: the line.
        conditions: how layouts are judged.
        what: what is placed; everything else stays.
        keep_out: rectangles in which no bin may stand, from the line's origin.
        tries: estimates of the search.
        tell: called with the progress after each estimate, and before each of the layouts works in the full physics.
        should_stop: whether the search shall end now; asked between estimates.

    Raises:
        ModuleNotFoundError: `cma` is not installed.
        UsageError: there is nothing to place, or no possible layout was found.
    """
    check_libraries("cma")
    grounds = Grounds(config, what, keep_out)
    if len(grounds.free) == 0:
        raise UsageError(f"there is nothing to place: level {config.name!r} has one robot, and its bins stay")
    search = Search(grounds, conditions, tries, tell, should_stop)
    layouts = [layout for layout in search.run(conditions.seed) if grounds.differences(layout)]
    return _best(search, layouts, replace(conditions, quiet=True))


def _best(search: Search, layouts: Sequence[Layout], conditions: Conditions) -> Improvement:
    """The best of the finalists of a search, compared with today's layout in the full physics."""
    grounds, count = search.grounds, max(conditions.check, 2)

    def work(layout: Layout, place: int, shifts: int) -> Floats:
        search.stage = "shifts in the full physics"
        search.tell()
        plan = estimate(grounds.line(layout), conditions, SETTLED).planned
        return simulate(plan, replace(conditions, seed=conditions.seed + place), shifts)

    scores = [metrics.mean(work(layout, 1, count)) for layout in layouts]
    layout = layouts[int(np.argmax(scores))] if scores else grounds.today
    today = work(grounds.today, 2, 2 * count)
    found = work(layout, 2, 2 * count) if scores else today
    return Improvement(
        config=grounds.line(layout),
        differences=grounds.differences(layout),
        today=metrics.mean(today),
        found=metrics.mean(found),
        gain=metrics.difference(found, today),
        shifts=2 * count,
        tried=search.tried,
    )
