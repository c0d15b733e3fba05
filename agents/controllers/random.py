"""Uniform random corrections: what every controller should beat."""

from __future__ import annotations

from typing import final

import numpy as np

from .protocol import Actions, Controller, Observation


@final
class Random(Controller):
    """Random actions, uniform in the whole range."""

    name = "random"

    def __init__(self, actions: int) -> None:
        self._actions = actions
        self.reset(0)

    def reset(self, seed: int) -> None:
        """Reseed the generator."""
        self._random = np.random.default_rng(seed)

    def act(self, observation: Observation) -> Actions:
        """Random actions (N, A), uniform in [-1, 1]."""
        return self._random.uniform(-1.0, 1.0, (len(observation.kind), self._actions)).astype(np.float32)
