"""Kalman filters of hidden states from landings, one for each of several hypotheses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Floats, Ints

NOISE: Final = (0.012, 0.008)
"""Standard deviation of the static policy's landing error along and across, with the bin camera's noise [m]."""
BIN_CAMERA: Final = 0.005
"""Standard deviation of the bin's camera contained in `NOISE`, along and across [m]."""
SURPRISE: Final = 2.5
"""Deviations beyond which a landing counts less, because the object probably touched something or hit a rim."""


@final
class Filters:
    """Sets of Kalman filters of the same S unknowns, one for each of H hypotheses, weighed by their likelihoods.

    Args:
        shape: shape of the array of sets.
        priors: initial covariances of the filters of a set (H, S, S).
        beliefs: initial weights of the filters of a set (H,).
        walks: covariances of the change of the unknowns from one landing to the next (H, S, S).
        turning: probability from one landing to the next that any hypothesis becomes true, one like the other.
        noise: covariance of landings with known unknowns (2, 2) [m2].
    """

    def __init__(
        self,
        shape: tuple[int, ...],
        priors: Floats,
        beliefs: Sequence[float],
        *,
        walks: Floats | float = 0.0,
        turning: float = 0.0,
        noise: Floats,
    ) -> None:
        self._priors, self._beliefs, self._walks, self._turning = priors, np.array(beliefs), walks, turning
        self._noise = noise
        self.state = np.zeros((*shape, *priors.shape[:-1]))
        self.spread = np.broadcast_to(priors, (*shape, *priors.shape)).copy()
        self.belief = np.broadcast_to(self._beliefs, (*shape, len(self._beliefs))).copy()

    def begin(self, at: Ints) -> None:
        """Reset some sets to their priors."""
        self.state[at], self.spread[at], self.belief[at] = 0.0, self._priors, self._beliefs

    def learn(self, at: Ints | tuple[Ints, ...], effect: Floats, z: Floats) -> None:
        """Update N sets by landings z [m], with the unknowns' effects on them; the random walk advances in every set.

        Args:
            at: the sets.
            effect: effects in each filter of a set (N, H, 2, S), or in all alike (N, 1, 2, S).
            z: the landings (N, H, 2) or (N, 1, 2) [m].
        """
        state, spread, likely = self.updated(at, effect, z)
        # Bayes' rule for the hypotheses, then a Markov switch between them.
        belief = self.belief[at] * np.exp(likely - likely.max(axis=-1, keepdims=True))
        belief = (1.0 - self._turning) * belief / belief.sum(axis=-1, keepdims=True)
        belief += self._turning / len(self._beliefs)
        self.state[at], self.spread[at], self.belief[at] = state, spread, belief
        self.spread += self._walks

    def updated(self, at: Ints | tuple[Ints, ...], effect: Floats, z: Floats) -> tuple[Floats, Floats, Floats]:
        """Estimates, covariances and log-likelihoods of N sets after landings as of `learn`; the sets do not change."""
        return update(self.state[at], self.spread[at], effect, z, self._noise)

    def estimate(self, at: Ints | tuple[Ints, ...]) -> Floats:
        """Estimates of the unknowns of N sets (N, S)."""
        return (self.belief[at][..., None] * self.state[at]).sum(axis=-2)


def landing_noise(camera: float) -> Floats:
    """Covariance of the static policy's landings without drift (2, 2) [m2], as a camera of this deviation [m] sees."""
    return np.diag(np.square(NOISE) + (camera**2 - BIN_CAMERA**2))


def landing_offset(effect: Floats, state: Floats) -> Floats:
    """Offsets of landings (..., 2) [m] from effects (..., 2, S) of unknowns (..., S)."""
    return (effect @ state[..., None])[..., 0]


def update(state: Floats, spread: Floats, effect: Floats, z: Floats, noise: Floats) -> tuple[Floats, Floats, Floats]:
    """Kalman update by landings z (..., 2) [m], with the effects of S unknowns on them (..., 2, S).

    A far landing gets so much noise that it lies `SURPRISE` deviations off.

    Args:
        state: estimates (..., S).
        spread: covariances of the estimates (..., S, S).
        effect: see above.
        z: see above.
        noise: covariance of a landing with known unknowns (2, 2).

    Returns:
        Estimates, covariances, and each filter's log-likelihood of its landing (...), up to a constant.
    """
    transposed = effect.swapaxes(-1, -2)
    innovation = z - landing_offset(effect, state)
    covariance = effect @ spread @ transposed + noise
    # Squared Mahalanobis distance of the landing, in units of SURPRISE.
    distance = np.einsum("...i,...ij,...j->...", innovation, np.linalg.inv(covariance), innovation) / SURPRISE**2
    covariance = covariance + np.maximum(distance - 1.0, 0.0)[..., None, None] * noise
    inverse = np.linalg.inv(covariance)
    gain = spread @ transposed @ inverse
    likely = np.log(np.linalg.det(inverse)) - np.einsum("...i,...ij,...j->...", innovation, inverse, innovation)
    return state + landing_offset(gain, innovation), spread - gain @ effect @ spread, 0.5 * likely
