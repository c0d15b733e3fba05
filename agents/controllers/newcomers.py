"""Kinds of items that a policy has not learned: how each is off, from the few throws that there have been of it."""

from __future__ import annotations

from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints

from .trackers import NOISE, SURPRISE

PRIOR: Final = (0.025, 0.005)
"""How far off a kind may be along and across the throw, standard deviations [m]: what is not known of an object, when
it lets go, how deep its middle hangs, how much air it meets, acts along its throw."""


@final
class Newcomers:
    """The mean landing of every kind in every row, each against its prior; a kind that is known is never off.

    Args:
        known: which kinds the policy has learned (K,).
    """

    def __init__(self, known: Bools) -> None:
        self._known = known
        self._off, self._weight = np.zeros((0, len(known), 2)), np.zeros((0, len(known), 2))

    def new(self, kind: Ints) -> Bools:
        """Which things (N,) are of a kind that was never learned."""
        return ~self._known[kind]

    def learn(self, kind: Ints, z: Floats, rows: Bools) -> None:
        """Things of kinds (N,), of which some rows count, came down by z (N, 2) [m] other than foreseen."""
        self._fit(len(kind))
        here = np.flatnonzero(rows & self.new(kind))
        at = here, kind[here]
        noise = np.square(NOISE)
        gain = 1.0 / (1.0 + self._weight[at] + noise / np.square(PRIOR))
        most = SURPRISE * np.sqrt(noise * (1.0 + gain) + np.square(PRIOR) * (self._weight[at] == 0.0))
        self._off[at] += gain * np.clip(z[here] - self._off[at], -most, most)
        self._weight[at] += 1.0

    def effect(self, kind: Ints) -> Floats:
        """What is expected of things of kinds (N,): (N, 2) [m]."""
        self._fit(len(kind))
        return self._off[np.arange(len(kind)), kind]

    def _fit(self, count: int) -> None:
        """Begin anew with another number of rows."""
        if len(self._off) != count:
            shape = (count, len(self._known), 2)
            self._off, self._weight = np.zeros(shape), np.zeros(shape)
