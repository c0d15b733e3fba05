"""A controller that cheats: it simulates each throw with its hidden values before throwing it.

It bounds what a learner can reach where errors follow the action one to one, or nearly so; only what is drawn anew in
every throw is unknown to it. Where they run the other way (the level `contact`), its iteration fails as theirs do.
"""

from __future__ import annotations

from typing import final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.action import Correction
from pnt_gym.cells.base.core import Core

from .protocol import Actions, Controller, Observation


@final
class Oracle(Controller):
    """Fixed-point iteration on the simulated outcome: action <- action - error / scale.

    Args:
        core: simulates the coming throws.
        correction: what an action means.
        iterations: simulations after the first.
    """

    name = "oracle"

    def __init__(self, core: Core, correction: Correction, iterations: int = 3) -> None:
        self._core = core
        self._correction = correction
        self._iterations = iterations

    def act(self, observation: Observation) -> Actions:
        """The best of the actions tried for each throw, (N, E)."""
        scale = self._correction.scale
        action = np.zeros((len(observation.kind), self._correction.count))
        error = self._error(action)
        best, smallest = action, self._size(error)
        for _ in range(self._iterations):
            # An unmeasured throw says nothing about where to go.
            action = np.clip(action - np.nan_to_num(error, nan=0.0) / scale, -1.0, 1.0)
            error = self._error(action)
            size = self._size(error)
            best = np.where(size < smallest, action, best)
            smallest = np.minimum(size, smallest)
        return best.astype(np.float32)

    def _error(self, action: Floats) -> Floats:
        seen = self._core.preview(action.astype(np.float32), jitter=False)
        return np.stack([getattr(seen, name) for name in self._correction.errors], axis=-1)

    def _size(self, error: Floats) -> Floats:
        """Length of the error in tolerances (N, 1); infinite where it was not measured."""
        length = np.hypot.reduce(error / self._correction.tolerance, axis=1, keepdims=True)
        return np.nan_to_num(length, nan=np.inf)
