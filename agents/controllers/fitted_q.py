"""The controller that learns from rewards alone where to grasp and how fast to throw."""

from __future__ import annotations

from pathlib import Path
from typing import Final, final

import numpy as np

from pnt_gym.cells.grasp.config import GraspConfig

from ..ground.cli import UsageError, check_libraries
from ..ground.places import GRASPING, at
from .grasp_values import GraspValues
from .grasps import GIVE_UP, RESIDUAL, phases, throw_observation
from .protocol import Actions, Learner, Observation, Outcome, State
from .regression import OnPolicyRegression
from .state import load_state

FILE: Final = GRASPING / "fitted_q.npz"
"""Values that ship."""


@final
class FittedQ(Learner):
    """Grasps and throws by two networks of values, which learn from rewards alone.

    The release is corrected by the residual of the other controllers that grasp, which learned from landings; practice
    leaves the residual as it is.

    Args:
        config: the cell.
        residual: corrects releases.
        file: values that `--save` has written; by default those that ship.

    Raises:
        UsageError: the level has one stage, or there is no such file.
    """

    name = "fitted_q"
    practice = 0
    """The values that ship are trained."""

    def __init__(self, config: GraspConfig, residual: OnPolicyRegression, file: str | Path = FILE) -> None:
        if config.grasp.stages == 1:
            raise UsageError("controller 'fitted_q' grasps first and throws next; this level has `stages: 1`")
        self._config, self._residual = config, residual
        self._values = GraspValues(config)
        load_state(self, at(file))

    def reset(self, seed: int) -> None:
        """Reseed the random numbers; what was learned stays."""
        self._values.reseed(seed)

    def begin_practice(self, throws: int) -> None:
        """Forget the values, and explore places and paces."""
        check_libraries(*self._values.libraries)
        if self._config.grasp.objects > 1:
            raise UsageError("controller 'fitted_q' practises on single objects; this level has groups of objects")
        self._values.begin_practice(throws)

    def end_practice(self) -> None:
        """Fit the values to all picks, and stop exploring."""
        self._values.end_practice()

    def act(self, observation: Observation) -> Actions:
        """Actions (N, 6): of the grasp where the cup is free, of the throw where the object hangs."""
        rules = self._config.grasp
        action = np.zeros((len(observation.kind), 6), dtype=np.float32)
        held, _ = phases(observation, rules.tries)
        free = np.flatnonzero(~held)
        if free.size > 0:
            place, rides = self._values.places(observation, free)
            action[free, :2] = np.clip(place / rules.reach, -1.0, 1.0)
            action[free[rides], 2] = GIVE_UP
        slow, fast = rules.pace
        action[:, 3] = 2.0 * (self._values.shares(observation) - slow) / (fast - slow) - 1.0
        action[:, RESIDUAL] = self._residual.act(throw_observation(observation, action, self._config))
        return action

    def learn(self, outcome: Outcome) -> None:
        """Learn from picks that are over."""
        self._values.learn(outcome)

    def state(self) -> State:
        """State of the values."""
        return self._values.state()

    def restore(self, state: State) -> None:
        """Load the state of the values."""
        self._values.restore(state)
