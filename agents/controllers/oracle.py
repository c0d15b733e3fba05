"""A controller that cheats: it simulates each throw with its hidden values before throwing it.

It bounds what any learner can reach; only the jitter of the valve is unknown to it.
"""

from __future__ import annotations

from typing import final

import numpy as np

from agents.controllers.protocol import Actions, Core, Observation, Outcome
from agents.controllers.shift import action_scale
from pnt_gym.planning.arrays import Floats


@final
class Oracle:
    """Fixed-point iteration on the simulated landing: action <- action - error / scale."""

    name = "oracle"

    def __init__(self, core: Core, iterations: int = 3) -> None:
        self._core = core
        self._iterations = iterations

    def reset(self, seed: int) -> None:
        """Nothing to forget."""

    def act(self, observation: Observation) -> Actions:
        """The best of the actions tried for each throw, (N, 2)."""
        scale = action_scale(self._core.config)
        action = np.zeros((len(observation.kind), 2))
        error = self._error(action)
        best, smallest = action, _size(error)
        for _ in range(self._iterations):
            # An unmeasured landing says nothing about where to go.
            action = np.clip(action - np.nan_to_num(error, nan=0.0) / scale, -1.0, 1.0)
            error = self._error(action)
            size = _size(error)
            best = np.where(size < smallest, action, best)
            smallest = np.minimum(size, smallest)
        return best.astype(np.float32)

    def learn(self, outcome: Outcome) -> None:
        """Knows everything already."""

    def _error(self, action: Floats) -> Floats:
        seen = self._core.preview(action.astype(np.float32), jitter=False)
        return np.stack([seen.landing_along, seen.landing_across], axis=-1)


def _size(error: Floats) -> Floats:
    """Length of the error (N, 1); infinite where nothing landed."""
    return np.nan_to_num(np.hypot(error[:, :1], error[:, 1:]), nan=np.inf)
