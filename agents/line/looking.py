"""Looking ahead: what follows from a choice, as far as camera, encoder and planner tell.

Nothing hidden is used. What lies upstream of the camera is not known, chances are those of the table, and other robots
are free when they say.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, Ints, joined, take
from pnt_gym.cells.line.cell import LineCell
from pnt_gym.cells.line.choosing import IDLE
from pnt_gym.cells.line.core import LineCore
from pnt_gym.cells.line.options import AWAY, Sight

from ..controllers.protocol import Controller, Observation

MOST: Final = 24
"""Decisions that one plan is made of, at most."""


@final
@dataclass(frozen=True)
class Plans:
    """B beginnings of what could be done in N lines, from now on."""

    line: Ints
    """Of which line (B,)."""
    first: Ints
    """The choice that it begins with (B,)."""
    free: Floats
    """When each robot is free again; infinity for one that is left out (B, R) [s]."""
    hand: Floats
    """Where hands stand then (B, R, 3) [m]."""
    taken: Bools
    """Which of the objects in sight are gone (B, W)."""
    value: Floats
    """What it is expected to bring in (B,)."""
    spent: Floats
    """Time of robots that it takes (B,) [s]."""


@final
class Beam(Controller):
    """The best plan of several decisions, by beam search; its first decision is taken.

    Args:
        name: in tables.
        core: the lines; of them only what the robots know.
        price: value that a second of a robot's time is worth, in comparing plans of different length [1/s].
        share: of its value that an object loses which a robot downstream can take too, as in the rule `price`.
        joint: plan for all robots of a line, not only for that whose turn it is.
        width: plans that are kept for each line.
        horizon: a plan is complete when its robots are busy until then [s].
        depth: decisions after the first, at most.
        by_rate: compare plans by value / time instead, as the two-step rule does.
    """

    def __init__(
        self,
        name: str,
        core: LineCore,
        *,
        price: float = 1.0,
        share: float = 0.0,
        joint: bool = False,
        width: int = 20,
        horizon: float = 4.0,
        depth: int = MOST,
        by_rate: bool = False,
    ) -> None:
        self.name, self._cell = name, core.cell
        self.price, self.share, self._joint, self._width = price, share, joint, width
        self._horizon, self._depth, self._by_rate = horizon, depth, by_rate

    def act(self, observation: Observation) -> NDArray[np.int64]:  # type: ignore[override]
        """The first decision of the best plan of each line (N,)."""
        cell = self._cell
        sight = cell.chooser.sight(cell.state, cell.stream, np.arange(cell.count))
        plans = self._begun(cell, sight)
        for _ in range(self._depth):
            more = np.flatnonzero(plans.free.min(axis=1) < self._horizon)
            if more.size == 0:
                break
            complete = take(plans, np.setdiff1d(np.arange(len(plans.line)), more))
            plans = self._kept(joined([complete, *self._continued(cell, sight, take(plans, more))]))
        choice = np.zeros(cell.count, dtype=np.int64)
        best = self._best(plans, 1)
        choice[plans.line[best]] = plans.first[best]
        return choice

    def _begun(self, cell: LineCell, sight: Sight) -> Plans:
        """Plans of one decision: the choices that there are."""
        state, choices = cell.state, cell.state.choices
        line, first = np.nonzero(choices.real)
        robot, rows = state.robot[line], np.arange(len(line))
        free = np.maximum(state.expected[line] - state.clock[line, None], 0.0)
        if not self._joint:
            free = np.full_like(free, np.inf)
        cycle = choices.cycle[line, first]
        free[rows, robot] = cycle
        hand = state.hand[line].copy()
        hand[rows, robot] = choices.stop[line, first]
        taken = sight.which[line] == choices.index[line, first][:, None]
        value = choices.value[line, first] * choices.chance[line, first]
        value *= 1.0 - self.share * (choices.heirs[line, first] > 0.0)
        return Plans(line, first.astype(np.int64), free, hand, taken, value, cycle)

    def _continued(self, cell: LineCell, sight: Sight, plans: Plans) -> list[Plans]:
        """Plans with every next decision there is, and those for which there is none, a moment later."""
        robot, rows = plans.free.argmin(axis=1), np.arange(len(plans.line))
        now = plans.free[rows, robot]
        x = sight.x[plans.line] + cell.config.cell.belt.speed * now[:, None]
        seen = Sight(plans.line, sight.which[plans.line], np.where(plans.taken, AWAY, x), sight.seen[plans.line])
        options = cell.chooser.options(cell.stream, seen, robot, plans.hand[rows, robot])
        own = take(plans, options.row)
        k, who = np.arange(len(options.row)), robot[options.row]
        free, hand, taken = own.free.copy(), own.hand.copy(), own.taken.copy()
        free[k, who] += options.cycle
        hand[k, who] = options.stop
        taken[k, options.place] = True
        at = options.row, options.place
        worth = cell.stream.worth[own.line, seen.which[at]] * cell.chooser.chance(seen, options)
        inherited = cell.chooser.heirs(who, seen.seen[at]).any(axis=1)
        value = own.value + worth * (1.0 - self.share * inherited)
        longer = replace(own, free=free, hand=hand, taken=taken, value=value, spent=own.spent + options.cycle)
        return [longer, self._idle(plans, robot, np.setdiff1d(rows, options.row))]

    def _idle(self, plans: Plans, robot: Ints, rows: Ints) -> Plans:
        """Some plans, in which nothing is done for a moment."""
        waiting, k = take(plans, rows), np.arange(len(rows))
        free = waiting.free.copy()
        free[k, robot[rows]] += IDLE
        return replace(waiting, free=free, spent=waiting.spent + IDLE)

    def _kept(self, plans: Plans) -> Plans:
        """The best plans of each line."""
        return take(plans, self._best(plans, self._width))

    def _best(self, plans: Plans, count: int) -> Ints:
        """The best so many plans of each line."""
        order = np.lexsort((-self._worth(plans), plans.line))
        line = plans.line[order]
        place = np.arange(len(order)) - np.searchsorted(line, line)
        return order[place < count]

    def _worth(self, plans: Plans) -> Floats:
        return plans.value / plans.spent if self._by_rate else plans.value - self.price * plans.spent
