"""Ridge regression on quadratic features, in closed form: the simple baseline of learned corrections."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from pnt_gym.arrays import Floats

from .protocol import State

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
    """One ridge regression per output; penalty and gain minimise the leave-one-out error, known in closed form."""

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
