"""Learners that ship with no command, for comparison alone: a Gaussian process, and CMA-ES on a linear policy."""

from __future__ import annotations

import importlib
from typing import Any, Final, final

import numpy as np

from agents.controllers.protocol import Actions, Controller, Observation, Outcome, State
from agents.controllers.regression import OnPolicyRegression
from pnt_gym.arrays import Floats
from pnt_gym.cells.base.action import Correction
from pnt_gym.cells.base.core import Core

MOST_POINTS: Final = 1000
"""Throws that a Gaussian process keeps, because its cost grows with their third power; of more, so many by chance."""
LENGTHS: Final = (1.0, 2.0, 4.0, 8.0, 16.0)
"""Length scales that are tried, in deviations of the features, times the root of their number over 4."""
NOISES: Final = (0.03, 0.1, 0.3, 1.0)
"""Deviations of the noise that are tried, in deviations of the targets."""
FIRST_STEP: Final = 0.1
"""First deviation of the weights of CMA-ES, in actions."""


@final
class GaussianProcess:
    """Regression by a Gaussian process with a squared exponential kernel; length and noise by the evidence."""

    libraries: tuple[str, ...] = ()

    def __init__(self) -> None:
        self._points = self._weights = np.zeros((0, 0))
        self._centre = self._scale = self._mean = np.zeros(0)
        self._length = 1.0

    def fit(self, features: Floats, shift: Floats, seed: int) -> None:
        """Fit to features (N, D) and offsets (N, E)."""
        if len(features) > MOST_POINTS:
            kept = np.random.default_rng(seed).choice(len(features), MOST_POINTS, replace=False)
            features, shift = features[kept], shift[kept]
        self._centre, scale = features.mean(axis=0), features.std(axis=0)
        self._scale = np.where(scale > 1e-9, scale, 1.0)
        self._points = (features - self._centre) / self._scale
        self._mean = shift.mean(axis=0)
        deviation = np.maximum(shift.std(axis=0), 1e-9)
        targets = (shift - self._mean) / deviation
        unit = np.sqrt(features.shape[1]) / 4.0
        tried = [(length * unit, noise) for length in LENGTHS for noise in NOISES]
        self._length, noise = max(tried, key=lambda choice: _evidence(self._points, targets, *choice))
        self._weights = np.linalg.solve(_kernel(self._points, self._length, noise), targets) * deviation

    def predict(self, features: Floats) -> Floats:
        """Offsets (N, E) for features (N, D)."""
        squares = _squares((features - self._centre) / self._scale, self._points)
        return np.exp(-0.5 * squares / self._length**2) @ self._weights + self._mean

    def state(self) -> State:
        """Points, weights and scales."""
        return {
            "points": self._points,
            "weights": self._weights,
            "centre": self._centre,
            "scale": self._scale,
            "mean": self._mean,
            "length": np.array(self._length),
        }

    def restore(self, state: State) -> None:
        """Load a fit."""
        self._points, self._weights = np.array(state["points"]), np.array(state["weights"])
        self._centre, self._scale = np.array(state["centre"]), np.array(state["scale"])
        self._mean, self._length = np.array(state["mean"]), float(state["length"])


def _squares(left: Floats, right: Floats) -> Floats:
    """Squared distances (N, M) of points (N, D) and (M, D)."""
    both = (left**2).sum(axis=1)[:, None] + (right**2).sum(axis=1)
    return np.maximum(both - 2.0 * left @ right.T, 0.0)


def _kernel(points: Floats, length: float, noise: float) -> Floats:
    return np.exp(-0.5 * _squares(points, points) / length**2) + noise**2 * np.eye(len(points))


def _evidence(points: Floats, targets: Floats, length: float, noise: float) -> float:
    """Logarithm of the evidence of a kernel, with the amplitude that fits best, over all outputs."""
    factor = np.linalg.cholesky(_kernel(points, length, noise))
    whitened = np.linalg.solve(factor, targets)
    amplitude = np.maximum((whitened**2).mean(axis=0), 1e-12)
    return float(-targets.shape[1] * np.log(np.diag(factor)).sum() - 0.5 * len(points) * np.log(amplitude).sum())


@final
class Gp(OnPolicyRegression):
    """The controller of a Gaussian process; practises as `ridge` and `mlp` do."""

    def __init__(self, core: Core) -> None:
        width = int(np.prod(core.observation_space.shape or ()))
        super().__init__("gp", _correction(core), width, GaussianProcess())


@final
class CmaEs(Controller):
    """CMA-ES on the weights of a linear policy; each throw tries one set of weights, and its error is the loss."""

    name = "cma_es"

    def __init__(self, core: Core) -> None:
        self._correction = _correction(core)
        self._width = int(np.prod(core.observation_space.shape or ()))
        self.reset(0)

    def reset(self, seed: int) -> None:
        """Forget all weights."""
        cma: Any = importlib.import_module("cma")
        size = (self._width + 1) * self._correction.count
        self._search = cma.CMAEvolutionStrategy(
            np.zeros(size), FIRST_STEP / np.sqrt(self._width + 1), {"seed": seed + 1, "verbose": -9}
        )
        self._tried: list[Floats] = []
        self._exploring = False
        self._weights = np.zeros(size)

    def begin_practice(self, throws: int) -> None:
        """Try weights."""
        del throws
        self._exploring = True

    def end_practice(self) -> None:
        """Use the mean of the weights."""
        self._exploring = False
        self._weights = np.asarray(self._search.mean)

    def act(self, observation: Observation) -> Actions:
        """Actions of the tried weights, or of the mean (N, E)."""
        features = np.concatenate([observation.features, np.ones((len(observation.kind), 1))], axis=1)
        if self._exploring:
            sets = [np.asarray(weights) for weights in self._search.ask(len(features))]
            self._tried = sets
        else:
            sets = [self._weights] * len(features)
        weights = np.stack(sets).reshape(len(features), -1, self._correction.count)
        return np.clip(np.einsum("nd,nde->ne", features, weights), -1.0, 1.0).astype(np.float32)

    def learn(self, outcome: Outcome) -> None:
        """Tell the losses of a population: the throws of one batch. A batch that was cut short teaches nothing."""
        losses = np.hypot.reduce(outcome.error / self._correction.tolerance, axis=1)
        if not self._exploring or len(losses) < len(self._tried) or not np.isfinite(losses).any():
            return
        # A throw without a landing counts as the worst of its batch.
        self._search.tell(self._tried, np.nan_to_num(losses, nan=np.nanmax(losses)).tolist())

    def state(self) -> State:
        """The weights."""
        return {"weights": self._weights}

    def restore(self, state: State) -> None:
        """Load weights."""
        self._weights = np.array(state["weights"])


def _correction(core: Core) -> Correction:
    if core.correction is None:
        raise RuntimeError(f"level {core.config.name!r}: actions do not shift the landing")
    return core.correction
