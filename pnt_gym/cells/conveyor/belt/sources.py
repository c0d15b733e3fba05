"""Sources of picks, and independent draws; `belt_picks` has the objects on the moving belt."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Generator
from contextlib import contextmanager
from typing import Final, NamedTuple, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, replace_rows, stand_ins, take
from pnt_gym.cells.base.cell import Generators
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.cup.hold import Grips
from pnt_gym.cells.conveyor.movers.straight import ThrowMotion
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.errors import ConfigError
from pnt_gym.planning.motion.limits import LimitRows
from pnt_gym.planning.motion.rows import Segments

MOST_DRAWS: Final = 120
"""Number of objects without a feasible throw after which the cell is impossible."""
STANDING_HEIGHT: Final = 0.05
"""Height of the next object above the belt's surface, for picks without a moving belt [m]."""


@final
class NextPick(NamedTuple):
    """The next picks of N hands, and their returns to these picks."""

    wait: Floats
    """Standstill above the pick until the object arrives (N,) [s]."""
    context: Context
    back: Segments
    """Motion from the end of the throw to the pick."""


class PickSource(ABC):
    """Abstract: gives picks to rows of a cell; every row draws only from its own generator."""

    def __init__(self, planner: PickPlanner, generators: Generators) -> None:
        self._planner = planner
        self._generators = generators
        self.passed: Ints = np.zeros(len(generators), dtype=np.int64)
        """Number of objects that left unpicked since the previous throw, or since the episode began (N,)."""
        self._held: Bools = np.zeros(len(generators), dtype=np.bool_)
        """Rows that `hold_back` holds back (N,)."""

    @abstractmethod
    def first(self, rows: Ints) -> Context:
        """First picks of an episode for the cell's rows."""

    @abstractmethod
    def following(self, motion: ThrowMotion, limits: LimitRows, standing: Floats) -> NextPick:
        """The picks that follow the throws of all rows.

        Args:
            motion: motions of the throws.
            limits: limits of the hand.
            standing: position of the next object in shares of the pick window (N, 2), for picks without a moving belt.
        """

    def waiting(self, row: int) -> tuple[Objects, Floats] | None:
        """The objects around one row's present pick, and their centres (K, 3) [m]; None without a moving belt."""
        return None

    def find_collisions(self, context: Context, motion: ThrowMotion, grips: Grips) -> Bools:
        """Which objects on the belt (N, K) the carried objects sweep through, also when dropped."""
        return np.zeros((len(context.pick), 0), dtype=np.bool_)

    def knock(self, objects: Bools) -> None:
        """Mark objects on the belt (N, K) as knocked: they are not picked any more; K is 0 without a moving belt."""
        assert objects.shape[1] == 0

    @contextmanager
    def hold_back(self, rows: Bools) -> Generator[None]:
        """Context at whose end the objects around the picks of some rows (N,) are as at its beginning."""
        passed, self._held = self.passed.copy(), rows
        try:
            yield
        finally:
            self.passed, self._held = np.where(rows, passed, self.passed), np.zeros_like(rows)

    def ride(self, rows: Ints, time: float) -> None:
        """Move the belts of some rows on for a time [s], in which their hands ride with them."""
        assert time >= 0.0  # without a belt nothing else moves

    def _impossible(self) -> ConfigError:
        config = self._planner.config
        percents = ", ".join(f"{p:g}" for p in config.limits.percent)
        return ConfigError(
            f"cell {config.name!r}: no object has a feasible throw; check that the bins are in reach at {percents} % "
            f"of the robot's limits, with belt.height {config.belt.height:g} m and bins.rim {config.bins.rim:g} m, and "
            f"that the follow-through of {config.motion.follow_through.window} s leaves room inside the workspace"
        )


class IndependentPicks(PickSource):
    """Picks that are drawn anew and do not depend on the previous throw: the contextual-bandit form."""

    def first(self, rows: Ints) -> Context:
        """One independent pick per row; objects are drawn until their throw is feasible."""
        return self._next(rows)

    def _next(self, rows: Ints) -> Context:
        """The coming picks of some rows, one per row."""
        context, good = self._attempt(rows)
        for _ in range(MOST_DRAWS):
            pending = (~good).nonzero()[0]
            if pending.size == 0:
                return context
            attempt, fits = self._attempt(rows[pending])
            context = replace_rows(context, pending, attempt)
            good[pending] = fits
        raise self._impossible()

    def following(self, motion: ThrowMotion, limits: LimitRows, standing: Floats) -> NextPick:
        """New picks that do not depend on the previous throws; a row that is held back has another row's pick."""
        belt, (low, high) = self._planner.config.belt, self._planner.config.lift_x
        x = low + (high - low) * standing[:, 0]
        y = belt.lane_y[0] + (belt.lane_y[1] - belt.lane_y[0]) * standing[:, 1]
        position = np.stack([x, y, np.full_like(x, belt.height + STANDING_HEIGHT)], axis=-1)
        back = self._planner.mover.back(motion, position, limits)
        # First picks of all rows, drawn in those that are not held back; one of these stands in for the others.
        rows = np.flatnonzero(~self._held)
        context = take(self._next(rows), stand_ins(rows, len(self._held)))
        return NextPick(np.zeros_like(x), context, back)

    def _attempt(self, rows: Ints) -> tuple[Context, Bools]:
        return self._planner.plan(*self._planner.draw_picks(self._generators, rows))
