"""Separate controllers for the rows of a batch: cells that differ, each with its own learner."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np

from pnt_gym.arrays import take

from .protocol import Actions, Controller, Observation, Outcome


@final
class Apart(Controller):
    """N controllers of one class; controller i sees only row i.

    Args:
        controllers: one controller for each row.
    """

    def __init__(self, controllers: Sequence[Controller]) -> None:
        self._each = list(controllers)
        self.name = self._each[0].name

    def reset(self, seed: int) -> None:
        """Reset every controller, each with its own seed."""
        for row, controller in enumerate(self._each):
            controller.reset(seed + row)

    def act(self, observation: Observation) -> Actions:
        """Action of each row's controller (N, A)."""
        rows = [slice(row, row + 1) for row in range(len(observation.kind))]
        return np.concatenate([one.act(take(observation, row)) for one, row in zip(self._each, rows, strict=False)])

    def learn(self, outcome: Outcome) -> None:
        """Pass each row's outcome to the row's controller."""
        for row in range(len(outcome.cycle_time)):
            self._each[row].learn(take(outcome, slice(row, row + 1)))
