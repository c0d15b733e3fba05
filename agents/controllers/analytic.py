"""The uncorrected analytic planner: the object is a point at the cup, without drag and without delay.

In the conveyor's mode `fixed_throw` an action of zero is one throw for all picks, and the controller has that name.
"""

from __future__ import annotations

from typing import final

import numpy as np

from pnt_gym.cells.conveyor.action import FIXED_THROW

from .protocol import Actions, Controller, Observation


@final
class Analytic(Controller):
    """Zero correction."""

    def __init__(self, actions: int, mode: str | None = None) -> None:
        self.name = mode if mode == FIXED_THROW else "analytic"
        self._actions = actions

    def act(self, observation: Observation) -> Actions:
        """Zeros (N, A)."""
        return np.zeros((len(observation.kind), self._actions), dtype=np.float32)
