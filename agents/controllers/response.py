"""Map from the offset of a throw to its error, learned from throws.

A linear map plus a smooth nonlinear part, both with Gaussian priors (Bayesian least squares, in the form of a Gaussian
process): the map has a Jacobian at every offset, averages the scatter of the throws, and estimates its own uncertainty.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Floats

SLOPE: Final = 1.0
"""Prior standard deviation of the Jacobian's entries from those of the one-to-one map."""
OFFSET: Final = 10.0
"""Prior standard deviation of the error of an uncorrected throw, in actions."""
NOISE: Final = (0.003, 0.01, 0.03, 0.1, 0.3)
"""Candidate standard deviations of the error that the map does not explain, in actions."""
BENDS: Final = ((0.0, 1.0), (0.1, 0.3), (0.1, 0.8), (0.4, 0.3), (0.4, 0.8), (1.5, 0.8))
"""Candidate sizes and length scales of the nonlinear part, in actions."""
REPEATABLE: Final = (0.5, 0.0, 0.95)
"""Candidate shares of the unexplained error that repeat with the offset; the first share while no offset was
repeated."""
ITERATIONS: Final = 12
"""Gauss-Newton steps on the learned map for one step of the offset."""
LEAST_DAMPING: Final = 1e-6
MORE_DAMPING: Final = 1e-3
"""Damping, added to the squares of the Jacobian's singular values: the least, and the least after a step to larger
errors."""


@final
@dataclass(frozen=True)
class _Kernel:
    """Covariance of one error over offsets, in actions."""

    noise: float
    bend: float
    length: float
    repeats: float

    def smooth(self, a: Floats, b: Floats) -> Floats:
        """Covariance of the map (A, B) at offsets (A, E) and (B, E): OFFSET^2 + SLOPE^2 a b + nonlinear part."""
        return OFFSET**2 + SLOPE**2 * (a @ b.T) + self._nonlinear(a, b)

    def slope(self, a: Floats, b: Floats) -> Floats:
        """Derivative of `smooth` by one offset `a` (E,): (E, B)."""
        pull = (b - a) / self.length**2
        return SLOPE**2 * b.T + (self._nonlinear(a[None], b)[0][:, None] * pull).T

    def rough(self, a: Floats, b: Floats) -> Floats:
        """Covariance of the repeatable error at equal offsets, which `smooth` does not contain (A, B)."""
        is_same = (a[:, None] == b).all(axis=2)
        return np.where(is_same, self.repeats * self.noise**2, 0.0)

    def measured(self, a: Floats) -> Floats:
        """Covariance of errors measured at offsets (A, E): (A, A)."""
        scatter = (1.0 - self.repeats) * self.noise**2
        return self.smooth(a, a) + self.rough(a, a) + scatter * np.eye(len(a))

    def variance(self, a: Floats) -> Floats:
        """Prior variance of the error of one throw (A,)."""
        return OFFSET**2 + SLOPE**2 * (a**2).sum(axis=1) + self.bend**2 + self.noise**2

    def _nonlinear(self, a: Floats, b: Floats) -> Floats:
        square = ((a[:, None] - b) ** 2).sum(axis=2)
        return self.bend**2 * np.exp(-0.5 * square / self.length**2)


_KERNELS: Final = tuple(_Kernel(n, *bend, share) for n in NOISE for bend in BENDS for share in REPEATABLE)


def _solve(factor: Floats, right: Floats, *, transposed: bool = False) -> Floats:
    """Solution x of L x = right, or of L^T x = right, for a lower triangle L."""
    scipy = importlib.import_module("scipy.linalg")  # at first use, because it takes a while
    return np.asarray(scipy.solve_triangular(factor, right, lower=True, trans=int(transposed), check_finite=False))


@final
class Response:
    """Error as a function of the offset, learned from throws; in actions, one to one by the prior.

    Args:
        shift: offset of each throw (M, E), M at least 1.
        error: error of each throw (M, E).
    """

    def __init__(self, shift: Floats, error: Floats) -> None:
        self._shift = shift
        surprise = error - shift
        repeated = len(np.unique(shift, axis=0)) < len(shift)
        kernels = [k for k in _KERNELS if repeated or k.repeats == REPEATABLE[0]]
        factors: list[Floats] = [np.asarray(np.linalg.cholesky(k.measured(shift)), np.float64) for k in kernels]
        whitened = [_solve(factor, surprise) for factor in factors]
        # Log-likelihood of each error under each kernel, up to a constant.
        fits = [-0.5 * (w**2).sum(axis=0) - np.log(f.diagonal()).sum() for w, f in zip(whitened, factors, strict=True)]
        best: list[int] = np.array(fits).argmax(axis=0).tolist()
        self._kernels = [kernels[i] for i in best]
        self._factors = [factors[i] for i in best]
        self._weights = [_solve(factors[i], whitened[i][:, e], transposed=True) for e, i in enumerate(best)]

    def error(self, shift: Floats) -> Floats:
        """Smooth part of the error (N, E) expected at offsets (N, E)."""
        parts = [k.smooth(shift, self._shift) @ w for k, w in zip(self._kernels, self._weights, strict=True)]
        return shift + np.stack(parts, axis=1)

    def error_again(self, shift: Floats) -> Floats:
        """Error (N, E) expected where offsets (N, E) of earlier throws are repeated."""
        parts = [k.rough(shift, self._shift) @ w for k, w in zip(self._kernels, self._weights, strict=True)]
        return self.error(shift) + np.stack(parts, axis=1)

    def doubt(self, shift: Floats) -> Floats:
        """Standard deviation (N, E) of the errors of throws with new offsets (N, E), scatter included."""
        parts: list[Floats] = []
        for kernel, factor in zip(self._kernels, self._factors, strict=True):
            explained = _solve(factor, kernel.smooth(self._shift, shift))
            parts.append(kernel.variance(shift) - (explained**2).sum(axis=0))
        return np.sqrt(np.maximum(np.stack(parts, axis=1), 1e-12))

    def jacobian(self, shift: Floats) -> Floats:
        """Derivative (E, E) of the error by one offset (E,)."""
        rows = [k.slope(shift, self._shift) @ w for k, w in zip(self._kernels, self._weights, strict=True)]
        return np.eye(len(shift)) + np.stack(rows)


def gauss_newton(response: Response, weight: Floats, start: Floats) -> Floats:
    """Offset (E,) within [-1, 1] after damped Gauss-Newton steps from `start` (E,) on weighted errors."""
    best, damping = start, LEAST_DAMPING
    error, jacobian = _weigh(response, weight, best)
    for _ in range(ITERATIONS):
        square = jacobian.T @ jacobian + damping * np.eye(len(start))
        trial = np.clip(best - np.linalg.solve(square, jacobian.T @ error), -1.0, 1.0)
        trial_error, trial_jacobian = _weigh(response, weight, trial)
        if trial_error @ trial_error < error @ error:
            best, error, jacobian = trial, trial_error, trial_jacobian
            damping = max(0.1 * damping, LEAST_DAMPING)
        else:
            damping = 10.0 * max(damping, MORE_DAMPING)
    return best


def _weigh(response: Response, weight: Floats, shift: Floats) -> tuple[Floats, Floats]:
    return weight * response.error(shift[None])[0], weight[:, None] * response.jacobian(shift)


def log_chance(error: Floats, doubt: Floats, bound: Floats | float) -> Floats:
    """Logarithm of the chance (N,) that all errors (N, E), normal with deviation `doubt` (N, E), lie within +-bound."""
    log_ndtr: Callable[[Floats], Floats] = importlib.import_module("scipy.special").log_ndtr
    # Mirrored to the lower tail, where the logarithm keeps its digits however unlikely the interval is.
    low, high = (-bound - np.abs(error)) / doubt, (bound - np.abs(error)) / doubt
    upper, lower = log_ndtr(high), log_ndtr(low)
    return (upper + np.log1p(-np.exp(np.minimum(lower - upper, -1e-12)))).sum(axis=1)
