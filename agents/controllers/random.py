"""Uniform random corrections: what no controller may be worse than."""

from __future__ import annotations

from typing import final

import numpy as np

from agents.controllers.protocol import Actions, Observation, Outcome


@final
class Random:
    """Uniform in the whole action range."""

    name = "random"

    def __init__(self, actions: int, seed: int = 0) -> None:
        self._actions = actions
        self.reset(seed)

    def reset(self, seed: int) -> None:
        """Reseed."""
        self._random = np.random.default_rng(seed)

    def act(self, observation: Observation) -> Actions:
        """Uniform (N, A) in [-1, 1]."""
        return self._random.uniform(-1.0, 1.0, (len(observation.kind), self._actions)).astype(np.float32)

    def learn(self, outcome: Outcome) -> None:
        """Learns nothing."""
