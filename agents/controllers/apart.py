"""One controller for every row: cells that differ, each learning for itself."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np

from pnt_gym.arrays import take

from .protocol import Actions, Controller, Observation, Outcome


@final
class Apart(Controller):
    """N controllers of one kind, the i-th of which sees nothing but row i.

    Args:
        controllers: one for each row.
    """

    def __init__(self, controllers: Sequence[Controller]) -> None:
        self._each = list(controllers)
        self.name = self._each[0].name

    def reset(self, seed: int) -> None:
        """All of them."""
        for row, controller in enumerate(self._each):
            controller.reset(seed + row)

    def act(self, observation: Observation) -> Actions:
        """Each its own action (N, A)."""
        rows = [slice(row, row + 1) for row in range(len(observation.kind))]
        return np.concatenate([one.act(take(observation, row)) for one, row in zip(self._each, rows, strict=False)])

    def learn(self, outcome: Outcome) -> None:
        """Each from its own throw."""
        for row in range(len(outcome.cycle_time)):
            self._each[row].learn(take(outcome, slice(row, row + 1)))
