"""Kalman filters that tell from landings what nobody measures, two for what may be in either of two ways."""

from __future__ import annotations

from typing import Final, final

import numpy as np

from pnt_gym.arrays import Floats, Ints

NOISE: Final = (0.012, 0.008)
"""Standard deviation along and across of what the static policy leaves of a throw, with the bin's camera's [m]."""
BIN_CAMERA: Final = 0.005
"""Standard deviation of the bin's camera in it, along and across [m]; of another one `seen_by` tells."""
SURPRISE: Final = 2.5
"""A landing further off than so many deviations counts less: it tells of a touch or a rim."""


@final
class Filters:
    """For each of many things two filters of the same S unknowns; each counts as much as it foresaw landings.

    Args:
        shape: of the things.
        priors: covariances of the unknowns that the two begin with (2, S, S).
        beliefs: what each counts at first (2,).
        walks: covariances of the change from one landing to the next (2, S, S).
        turning: chance from one landing to the next that the other filter is right from now on.
        camera: standard deviation of the bin's camera [m].
    """

    def __init__(
        self,
        shape: tuple[int, ...],
        priors: Floats,
        beliefs: tuple[float, float],
        *,
        walks: Floats | float = 0.0,
        turning: float = 0.0,
        camera: float = BIN_CAMERA,
    ) -> None:
        self._priors, self._beliefs, self._walks, self._turning = priors, np.array(beliefs), walks, turning
        self._noise = seen_by(camera)
        self.state = np.zeros((*shape, *priors.shape[:-1]))
        self.spread = np.broadcast_to(priors, (*shape, *priors.shape)).copy()
        self.belief = np.broadcast_to(self._beliefs, (*shape, 2)).copy()

    def begin(self, at: Ints) -> None:
        """What was learned of some things is forgotten."""
        self.state[at], self.spread[at], self.belief[at] = 0.0, self._priors, self._beliefs

    def learn(self, at: Ints | tuple[Ints, ...], effect: Floats, z: Floats) -> None:
        """Landings z (N, 2) [m] of N things at these places, and what the unknowns do to them (N, 2, S)."""
        state, spread, likely = corrected(self.state[at], self.spread[at], effect[:, None], z[:, None], self._noise)
        belief = self.belief[at] * np.exp(likely - likely.max(axis=-1, keepdims=True))
        belief = (1.0 - self._turning) * belief / belief.sum(axis=-1, keepdims=True) + 0.5 * self._turning
        self.state[at], self.spread[at], self.belief[at] = state, spread, belief

    def wander(self) -> None:
        """Everything has moved on, by nobody knows what."""
        self.spread += self._walks

    def estimate(self, at: Ints | tuple[Ints, ...]) -> Floats:
        """Of the unknowns of N things (N, S)."""
        return (self.belief[at][..., None] * self.state[at]).sum(axis=-2)


def seen_by(camera: float) -> Floats:
    """Covariance of landings whose unknowns are known (2, 2) [m2], seen by a camera with a standard deviation [m]."""
    return np.diag(np.square(NOISE) + (camera**2 - BIN_CAMERA**2))


def landing(effect: Floats, state: Floats) -> Floats:
    """How far off throws come down (..., 2) [m] by effects (..., 2, S) of what is off (..., S)."""
    return (effect @ state[..., None])[..., 0]


def corrected(state: Floats, spread: Floats, effect: Floats, z: Floats, noise: Floats) -> tuple[Floats, Floats, Floats]:
    """The update of Kalman filters by landings z (..., 2) [m], with what S unknowns do to them (..., 2, S).

    A landing far off gets the noise with which it would be `SURPRISE` deviations off.

    Args:
        state: estimates (..., S).
        spread: their covariances (..., S, S).
        effect: see above.
        z: see above.
        noise: covariance of a landing whose unknowns are known (2, 2).

    Returns:
        Estimates, covariances, and how likely each filter took its landing to be: logarithm of the density (...), but
        for a constant.
    """
    turned = effect.swapaxes(-1, -2)
    new = z - landing(effect, state)
    expected = effect @ spread @ turned + noise
    far = np.einsum("...i,...ij,...j->...", new, np.linalg.inv(expected), new) / SURPRISE**2
    expected = expected + np.maximum(far - 1.0, 0.0)[..., None, None] * noise
    inverse = np.linalg.inv(expected)
    gain = spread @ turned @ inverse
    likely = np.log(np.linalg.det(inverse)) - np.einsum("...i,...ij,...j->...", new, inverse, new)
    return state + landing(gain, new), spread - gain @ effect @ spread, 0.5 * likely
