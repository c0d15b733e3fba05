"""Separate controllers for the rows of a batch: cells that differ, each with its own learner."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np

from pnt_gym.arrays import take

from .protocol import Actions, Controller, Observation, Outcome


@final
class SeparateControllers(Controller):
    """N controllers of one class; controller i sees only row i.

    Args:
        controllers: one controller for each row.
    """

    def __init__(self, controllers: Sequence[Controller]) -> None:
        self._controllers = list(controllers)
        self.name = self._controllers[0].name

    def reset(self, seed: int) -> None:
        """Reset every controller, each with its own seed."""
        for row, controller in enumerate(self._controllers):
            controller.reset(seed + row)

    def act(self, observation: Observation) -> Actions:
        """Action of each row's controller (N, A)."""
        rows = [slice(row, row + 1) for row in range(len(observation.kind))]
        return np.concatenate(
            [controller.act(take(observation, row)) for controller, row in zip(self._controllers, rows, strict=False)]
        )

    def learn(self, outcome: Outcome) -> None:
        """Pass each row's outcome to the row's controller."""
        for row in range(len(outcome.cycle_time)):
            self._controllers[row].learn(take(outcome, slice(row, row + 1)))
