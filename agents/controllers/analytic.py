"""The uncorrected analytic planner: the object is a point at the cup, without drag and without delay."""

from __future__ import annotations

from typing import final

import numpy as np

from .protocol import Actions, Controller, Observation


@final
class Analytic(Controller):
    """Zero correction."""

    name = "analytic"

    def __init__(self, actions: int) -> None:
        self._actions = actions

    def act(self, observation: Observation) -> Actions:
        """Zeros (N, A)."""
        return np.zeros((len(observation.kind), self._actions), dtype=np.float32)
