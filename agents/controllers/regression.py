"""Learning the correction by regression: throw, measure the error, fit the ideal offset.

With many throws its error is the noise floor of the cell, which no observation explains.

A label is the offset of the throw minus its error. Labels come from throws of the current fit (in rounds), with some
exploration around them. Any regressor with `fit` and `predict` works; ridge regression and a small network are used.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any, TypeAlias, final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.action import Correction

from ..ground.cli import UsageError, check_libraries
from ..ground.fitting import fit_from
from ..policies import networks
from ..policies.networks import Layers, layers_from_torch
from .protocol import Actions, Learner, Observation, Outcome, State, ideal_offsets, is_instructive, to_action

BATCH = 256


@final
class Mlp:
    """A small network fitted to the same labels as the ridge regression: supervised learning from throws.

    Two hidden layers, Huber loss, AdamW with a cosine schedule.

    Args:
        width: units per hidden layer.
        steps: gradient steps of one fit; None: as many as throws, but 400 to 3000, because few throws are soon
            overfitted.
        learning_rate: learning rate at the start of the schedule.
        weight_decay: weight decay of AdamW.
    """

    libraries: tuple[str, ...] = ("torch",)
    """Optional libraries by which it fits."""

    def __init__(
        self, width: int = 64, steps: int | None = None, learning_rate: float = 3e-3, weight_decay: float = 0.3
    ) -> None:
        self._width, self._steps = width, steps
        self._learning_rate, self._weight_decay = learning_rate, weight_decay
        self._layers: Layers = ()
        self._centre, self._scale = np.zeros(0), np.ones(0)

    def fit(self, features: Floats, shift: Floats, seed: int) -> None:
        """Fit the network to features (N, D) and offsets (N, E)."""
        import torch  # noqa: PLC0415 - a second to import, needed for fitting only

        self._centre, self._scale = shift.mean(axis=0), shift.std(axis=0) + 1e-6
        x = torch.as_tensor(features, dtype=torch.float32)
        y = torch.as_tensor((shift - self._centre) / self._scale, dtype=torch.float32)
        with fit_from(seed):
            network = _network(torch, features.shape[1], self._width, shift.shape[1])
            self._train(torch, network, x, y)
        self._layers = layers_from_torch(network.parameters(), np.float64)

    def predict(self, features: Floats) -> Floats:
        """Offsets (N, E) for features (N, D)."""
        return networks.run(self._layers, "SiLU", features) * self._scale + self._centre

    def state(self) -> State:
        """Weights and biases by layer, and the scale of the labels."""
        return {**networks.arrays(self._layers), "centre": self._centre, "scale": self._scale}

    def restore(self, state: State) -> None:
        """Load a fit."""
        self._layers = networks.layers(state, np.float64)
        self._centre, self._scale = (networks.numbers(state[name], 1, np.float64) for name in ("centre", "scale"))

    def _train(self, torch: Any, network: Any, x: Any, y: Any) -> None:
        steps = self._steps or min(max(len(x), 400), 3000)
        optimiser = torch.optim.AdamW(network.parameters(), lr=self._learning_rate, weight_decay=self._weight_decay)
        schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, steps)
        loss_of = torch.nn.HuberLoss()
        batch = min(BATCH, len(x))
        for _ in range(steps):
            rows = torch.randint(len(x), (batch,))
            optimiser.zero_grad()
            loss_of(network(x[rows]), y[rows]).backward()
            optimiser.step()
            schedule.step()


def _network(torch: Any, inputs: int, width: int, outputs: int) -> Any:
    sizes = [inputs, width, width, outputs]
    layers: list[Any] = []
    for before, after in pairwise(sizes):
        layers += [torch.nn.Linear(before, after), torch.nn.SiLU()]
    return torch.nn.Sequential(*layers[:-1])


PENALTIES = np.logspace(-2, 4, 19)
GAINS = (0.03, 0.1, 0.3, 1.0)
"""Weights of the quadratic features relative to the linear ones; a small weight means a larger penalty."""


def expand(features: Floats, gain: float) -> Floats:
    """Linear features (N, D) and their D (D + 1) / 2 products times `gain`."""
    row, column = np.triu_indices(features.shape[1])
    return np.concatenate([features, gain * features[:, row] * features[:, column]], axis=1)


@dataclass(frozen=True)
class _Candidate:
    loss: float
    gain: float
    centre: Floats
    weights: Floats


@final
class Ridge:
    """Ridge regression on quadratic features, in closed form: the simple baseline of learned corrections.

    One ridge regression per output; penalty and gain minimise the leave-one-out error, known in closed form.
    """

    libraries: tuple[str, ...] = ()
    """Optional libraries by which it fits."""

    def __init__(self) -> None:
        self._fits: list[_Candidate] = []
        self._offset = np.zeros(0)

    def fit(self, features: Floats, shift: Floats, seed: int) -> None:
        """Fit the regressions to features (N, D) and offsets (N, E); `seed` is not used."""
        self._offset = shift.mean(axis=0)
        targets = shift - self._offset
        tried = [_best_penalty(features, targets, gain) for gain in GAINS]
        self._fits = [min(fits, key=lambda fit: fit.loss) for fits in zip(*tried, strict=True)]

    def predict(self, features: Floats) -> Floats:
        """Offsets (N, E) for features (N, D)."""
        columns = [(expand(features, fit.gain) - fit.centre) @ fit.weights for fit in self._fits]
        return np.stack(columns, axis=-1) + self._offset

    def state(self) -> State:
        """Gains, centres and weights per output, and the offset."""
        return {
            "gain": np.array([f.gain for f in self._fits]),
            "centre": np.stack([f.centre for f in self._fits]),
            "weights": np.stack([f.weights for f in self._fits]),
            "offset": self._offset,
        }

    def restore(self, state: State) -> None:
        """Load a fit."""
        rows = zip(state["gain"], state["centre"], state["weights"], strict=True)
        self._fits = [_Candidate(0.0, float(g), np.asarray(c, float), np.asarray(w, float)) for g, c, w in rows]
        self._offset = np.asarray(state["offset"], dtype=np.float64)


def _best_penalty(features: Floats, targets: Floats, gain: float) -> list[_Candidate]:
    """Fit with the smallest leave-one-out error over the penalties, per output."""
    phi = expand(features, gain)
    centre = phi.mean(axis=0)
    u, s, vt = np.linalg.svd(phi - centre, full_matrices=False)
    projected = u.T @ targets
    losses = np.empty((len(PENALTIES), targets.shape[1]))
    for i, penalty in enumerate(PENALTIES):
        shrink = s**2 / (s**2 + penalty)
        # Leverage of the ridge fit, plus 1/N for the fitted mean; leave-one-out residual = residual / (1 - leverage).
        leverage = np.minimum((u**2) @ shrink + 1.0 / len(phi), 1.0 - 1e-9)
        residual = targets - u @ (shrink[:, None] * projected)
        losses[i] = np.mean((residual / (1.0 - leverage)[:, None]) ** 2, axis=0)
    chosen = losses.argmin(axis=0)
    fits: list[_Candidate] = []
    for output, i in enumerate(chosen):
        weights = vt.T @ (s / (s**2 + PENALTIES[i]) * projected[:, output])
        fits.append(_Candidate(float(losses[i, output]), gain, centre, weights))
    return fits


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
        self._shifts.append(ideal_offsets(outcome, self._correction)[usable])
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
