"""A hand-written rule with a memory of its shift: where the cup comes down, and what held and landed of each look.

The rule foretells the gauge by a linear regression on the picture, and weighs the errors that the cup may have by all
readings (Bayes on a grid). It gives an object up whose look was seldom sorted, and takes off a release what objects of
its look missed before.
"""

from __future__ import annotations

from pathlib import Path
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Floats, Ints
from pnt_gym.cells.grasp.core import GraspCore

from ..grasping.features import best_places
from ..grasping.foretelling import Foretold, Straight
from ..grasping.gauge import SAFETY
from ..grasping.memory import USUAL
from ..ground.places import GRASPING, at
from .grasps import GIVE_UP, RESIDUAL, GaugePace, pace_action, phases, shipped_release
from .protocol import Actions, Controller, Observation, State, to_action
from .regression import OnPolicyRegression
from .state import load_state
from .watching import Watcher

FILE: Final = GRASPING.parent / "PnTGrasp-v0-grasp_shift" / "remembering.npz"
"""Weights of the regression that ship, of tries at drawn kinds."""


@final
class Remembering(Controller):
    """Grasps where the gauge is foretold to hold, over the errors that the cup may have, and corrects by landings.

    Args:
        core: the cells.
        release: corrects releases before anything is known; None for the residual that ships.
        file: weights of the regression; by default those that ship.
        least: estimated chance to be sorted below which an object rides on.
        again: probability to hold from which a further try is made.
        safety: factor of the measured load, of paces by the gauge.

    Raises:
        UsageError: the level has no shifts, or there is no such file.
    """

    name = "remembering"

    def __init__(
        self,
        core: GraspCore,
        release: OnPolicyRegression | None = None,
        file: str | Path = FILE,
        least: float = 0.25,
        again: float = 0.5,
        safety: float = SAFETY,
    ) -> None:
        self._release = shipped_release(core, self.name) if release is None else release
        self._core, self._foretold = core, Foretold(Straight())
        self._watcher = Watcher(self.name, core, self._foretold, self._release)
        load_state(self, at(file))
        self._pace, self._least, self._again = GaugePace(core, safety), least, again

    def reset(self, seed: int) -> None:
        """Forget all shifts."""
        self._watcher.begin(0)

    def state(self) -> State:
        """State of the regression."""
        return self._foretold.state()

    def restore(self, state: State) -> None:
        """Load the state of the regression."""
        self._foretold.restore(state)

    def act(self, observation: Observation) -> Actions:
        """Actions (N, 6): of the grasp where the cup is free, of the throw where the object hangs."""
        self._watcher.notice(observation)
        config, recalled = self._core.config, self._watcher.recall()
        action = np.zeros((len(observation.kind), 6), dtype=np.float32)
        held, tried = phases(observation, config.grasp.tries)
        free = np.flatnonzero(~held)
        if free.size > 0:
            place, chance = self._places(free)
            action[free, :2] = place / config.grasp.reach
            worth = (USUAL + recalled.held) * (USUAL + recalled.hit)
            rides = (worth[free] < self._least) | ((tried[free] > 0) & (chance < self._again))
            action[free[rides & ((tried[free] > 0) | config.grasp.skip)], 2] = GIVE_UP
        action[:, 3] = pace_action(self._pace.shares(observation), config)
        offset = self._watcher.reference(observation, action) - self._watcher.cup_part(observation)
        offset -= np.stack([recalled.along, recalled.across], axis=-1)
        correction = self._core.correction
        assert correction is not None  # of the mode `release_point`
        action[:, RESIDUAL] = to_action(offset, correction)
        return action

    def _places(self, rows: Ints) -> tuple[Floats, Floats]:
        """Places of the cups of some rows (K, 2) [m], and the probabilities that they hold (K,)."""
        holds = self._watcher.holds(self._watcher.maps(rows), self._watcher.memory.weights(rows))
        return best_places(holds), holds.reshape(len(rows), -1).max(axis=1)
