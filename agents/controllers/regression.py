"""Learning the correction by regression: throw, measure the error, fit the ideal offset.

A label is the offset of the throw minus its error. Labels come from throws of the current fit (in rounds), with some
exploration around them. Any regressor with `fit` and `predict` works; ridge regression and a small network are used.
"""

from __future__ import annotations

from typing import TypeAlias, final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.action import Correction

from ..ground.cli import UsageError, check_libraries
from .mlp import Mlp
from .protocol import Actions, Learner, Observation, Outcome, State
from .ridge import Ridge
from .shift import ideal_offset, is_instructive, to_action

ROUNDS = (0.25, 0.60, 1.0)
"""Shares of the practice after which the fit is renewed: rounds of 25, 35 and 40 %."""
FEWEST_THROWS = 8
"""Least number of throws of a fit; a fit to fewer would follow their noise."""
REFIT_GROWTH = 1.1
"""Growth of the data by which the fit is renewed outside practice."""
Regressor: TypeAlias = Ridge | Mlp
"""Fits offsets (N, E) to features (N, D) and predicts them; its state is the fit."""


@final
class OnPolicyRegression(Learner):
    """A regressor that gathers its own data.

    Args:
        name: name of the controller.
        correction: meaning of an action.
        features: number of entries of an observation D.
        regressor: the model.
    """

    def __init__(self, name: str, correction: Correction, features: int, regressor: Regressor) -> None:
        self.name = name
        self._correction = correction
        self._width = features
        self._regressor = regressor
        self.reset(0)

    def reset(self, seed: int) -> None:
        """Forget data and fit, and reseed exploration and fitting."""
        self._random = np.random.default_rng(seed)
        self._features: list[Floats] = []
        self._shifts: list[Floats] = []
        self._count = 0
        self._fitted_at = 0
        self._fitted = False
        self._exploring = False
        self._rounds: list[int] = []

    def begin_practice(self, throws: int) -> None:
        """Explore, and renew the fit at the end of each round, if what the fit needs is installed."""
        check_libraries(*self._regressor.libraries)
        self._exploring = True
        self._rounds = [self._count + round(share * throws) for share in ROUNDS[:-1]]

    def end_practice(self) -> None:
        """Fit to all throws and stop exploring."""
        self._exploring = False
        self._fit()

    def act(self, observation: Observation) -> Actions:
        """Predicted offset as an action, in practice with exploration around it: (N, E)."""
        count = len(observation.kind)
        shift = self.predict(observation)
        if self._exploring:
            noise = self._random.standard_normal((count, self._correction.count))
            shift = shift + self._correction.exploration * noise
        return to_action(shift, self._correction)

    def predict(self, observation: Observation) -> Floats:
        """Offsets of the fit (N, E), within the range of an action; zero before the first fit."""
        if not self._fitted:
            return np.zeros((len(observation.kind), self._correction.count))
        scale = self._correction.scale
        return np.clip(self._regressor.predict(observation.features.astype(np.float64)), -scale, scale)

    def learn(self, outcome: Outcome) -> None:
        """Add the throws to the data; renew the fit when a round is over."""
        usable = is_instructive(outcome)
        self._features.append(outcome.observation.features[usable].astype(np.float64))
        self._shifts.append(ideal_offset(outcome, self._correction)[usable])
        self._count += int(usable.sum())
        if self._exploring:
            due = bool(self._rounds) and self._count >= self._rounds[0]
        else:
            due = self._count >= REFIT_GROWTH * max(self._fitted_at, FEWEST_THROWS)
        if due:
            self._rounds = self._rounds[1:]
            self._fit()

    def data(self) -> tuple[Floats, Floats]:
        """Training data: observations (M, D), and ideal offsets (M, E)."""
        if not self._features:
            return np.zeros((0, self._width)), np.zeros((0, self._correction.count))
        return np.concatenate(self._features), np.concatenate(self._shifts)

    def state(self) -> State:
        """State of the fit; empty before the first one."""
        return self._regressor.state() if self._fitted else {}

    def restore(self, state: State) -> None:
        """Load a fit; the data behind it are not part of the state.

        Raises:
            UsageError: the fit is for other observations, or for another number of coordinates.
        """
        self._fitted = bool(state)
        if not state:
            return
        if not all(np.isfinite(array).all() for array in state.values()):
            raise UsageError(f"the saved state of {self.name!r} has numbers that are not finite")
        self._regressor.restore(state)
        try:
            shape = self._regressor.predict(np.zeros((1, self._width))).shape
        except ValueError:  # numpy's word for shapes that do not go together
            shape = None
        if shape != (1, self._correction.count):
            raise UsageError(
                f"the saved state of {self.name!r} does not fit: observations here have {self._width} entries, and "
                f"shifts {self._correction.count} numbers"
            )

    def _fit(self) -> None:
        if self._count < FEWEST_THROWS:
            return
        seed = int(self._random.integers(2**31))
        self._regressor.fit(*self.data(), seed)
        self._fitted, self._fitted_at = True, self._count
