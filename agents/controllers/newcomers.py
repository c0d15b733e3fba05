"""Kinds of items that a policy has not learned: how each is off, from the few throws that there have been of it."""

from __future__ import annotations

from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.conveyor.observation import TABLE

from .filters import Filters, landing
from .trackers import lateness

PRIOR: Final = (0.008, 0.008, 0.003)
"""How far off a kind may be, standard deviations: in when it lets go [s], and in where it comes down along and across
the throw for any other reason, how deep its middle hangs, how much air it meets [m]."""
LIKE_OTHERS: Final = 0.35
"""Of these, for a kind that is much as those that are known."""
SHARE: Final = 0.2
"""Of the kinds that are."""


@final
class Newcomers:
    """What is off with every kind in every row; a kind that is known is never off.

    Args:
        known: which kinds the policy has learned (K,).
    """

    def __init__(self, known: Bools) -> None:
        self._known = known
        self._begin(0)

    def new(self, kind: Ints) -> Bools:
        """Which things (N,) are of a kind that was never learned."""
        return ~self._known[kind]

    def learn(self, kind: Ints, throws: Floats, z: Floats, rows: Bools) -> None:
        """Throws (N, D) of kinds (N,), of which some rows count, came down by z (N, 2) [m] other than foreseen."""
        self._fit(len(kind))
        here = np.flatnonzero(rows & self.new(kind))
        self._filters.learn((here, kind[here]), _effects(throws[here]), z[here])

    def effect(self, kind: Ints, throws: Floats) -> Floats:
        """What is expected of throws (N, D) of kinds (N,): (N, 2) [m]."""
        self._fit(len(kind))
        return landing(_effects(throws), self._filters.estimate((np.arange(len(kind)), kind)))

    def _fit(self, count: int) -> None:
        """Begin anew with another number of rows."""
        if len(self._filters.state) != count:
            self._begin(count)

    def _begin(self, count: int) -> None:
        other = np.square(PRIOR)
        priors = np.stack([np.diag(LIKE_OTHERS**2 * other), np.diag(other)])
        self._filters = Filters((count, len(self._known)), priors, (SHARE, 1.0 - SHARE))


def _effects(throws: Floats) -> Floats:
    """What a release 1 s later, and 1 m further along and across, do to landings (N, 2, 3)."""
    found = np.zeros((len(throws), 2, 3))
    found[:, 0, 0], found[:, 0, 1], found[:, 1, 2] = lateness(TABLE.decode(throws)), 1.0, 1.0
    return found
