"""The density of the posterior of a cell's parameters, and its maxima.

Parameters are standard scores z of their priors. Residuals of `least_squares` are the landings, whitened by a 2x2
covariance for each throw and scaled together, so that their squares are -2 ln of a mixture of regular throws and throws
gone astray; the scores themselves; and for each throw the square root of -2 ln of the probability of what came of it:
not sealed, lost, seen to land or not seen.
"""

from __future__ import annotations

from collections.abc import Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import repeat
from typing import Any, Final, cast, final

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import norm

from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.errors import PntGymError, one_sentence

from ..ground.cli import UsageError
from .model import ThrowModel
from .parameters import Parameter, level_at, values_at


@contextmanager
def finite_numbers() -> Generator[None]:
    """Context or decorator of a computation that NumPy and SciPy refuse where its numbers are not finite.

    Raises:
        UsageError: they do.
    """
    try:
        yield
    except PntGymError:
        raise
    except (ValueError, ArithmeticError) as error:  # of SciPy's search, and of NumPy's matrices, whose error is a kind
        raise _error(one_sentence(error, 120)) from error


def check(*numbers: Any) -> None:
    """Make sure that the results of a fit are finite.

    Raises:
        UsageError: one is not.
    """
    if not all(np.isfinite(part).all() for part in numbers):
        raise _error("a result is not finite")


def _error(reason: str) -> UsageError:
    return UsageError(
        f"no fit follows from these throws and this level ({reason}); look for values of the log, of the level or of "
        "--prior that no cell has"
    )


ASTRAY: Final = 0.10
"""Standard deviation of a landing after the cup has touched the object again, or of another accident [m]."""
LEAST_ASTRAY, MOST_ASTRAY = 0.03, 0.97
"""Bounds of the share of such throws among throws like one of the log."""
STEP: Final = 0.12
"""Step of differences, in standard scores."""
ROUNDS: Final = 3
"""Times that scatter and mean of the draws are computed anew in the search for the maximum."""
CALLS, NODE_CALLS = 8, 3
"""Largest number of steps of a search in one round, and at a node."""
SETTLED: Final = 0.05
"""Change of the scores below which a search ends."""
FINEST: Final = 5e-4
"""Least noise of a landing: the precision of the model itself [m]."""
LEAST_DENSITY: Final = 1e-300
"""Least density of a landing, so that one that lies metres away still has a logarithm [1/m2]."""
LEAST_CHANCE: Final = 1e-4
"""Chances are kept from this value to 1 minus it, as no model is so sure."""


@final
@dataclass(frozen=True)
class Scatter:
    """What draws of the hidden values say of each throw, at given parameters."""

    shift: Floats
    """Mean landing minus the landing at mean hidden values (N, 2) [m]."""
    covariance: Floats
    """Covariance of the landing, with the camera's noise (N, 2, 2) [m2]."""
    root: Floats
    """Inverse square roots of these covariances (N, 2, 2)."""
    holds: Floats
    """Whether a cup that has sealed holds the object, for each draw (N, K)."""
    astray: Floats
    """Share of throws that the cup touches again, or that go astray otherwise (N,)."""


@final
@dataclass(frozen=True)
class Node:
    """A maximum of the density where some scores are fixed."""

    z: Floats
    """Standard scores (P,)."""
    covariance: Floats
    """Laplace approximation for the free ones (F, F)."""
    cost: float
    """-2 ln of the density, up to a constant."""


@final
@dataclass(frozen=True)
class Mode:
    """The maximum of the density."""

    z: Floats
    """Standard scores (P,)."""
    covariance: Floats
    """Laplace approximation (P, P)."""
    scatter: Scatter
    jacobian: Floats
    """Whitened change of the landings per score, robust weights included (2 L, P)."""
    residual: Floats
    """Whitened landings minus predictions (L, 2)."""
    regular: Floats
    """Probability that each landing is that of a regular throw (L,)."""


@final
class Density:
    """The posterior's density for one log.

    Args:
        model: the throws.
        parameters: free parameters and priors.
        spread: factor of the throws' covariance.
    """

    def __init__(self, model: ThrowModel, parameters: Sequence[Parameter], spread: float = 1.0) -> None:
        self.model, self.parameters, self.spread = model, tuple(parameters), spread
        log = model.log
        self.has_landing = log.has_landing
        self._unsealed, self._lost = log.sealed == 0.0, log.lost == 1.0
        # A throw without a landing and without a word on seal and loss says nothing.
        holds = (log.sealed == 1.0) & ~self._lost
        self._unseen = holds & ~self.has_landing & np.isfinite(log.target).all(axis=1)

    def level(self, z: Floats) -> ConveyorConfig:
        """The cell at standard scores (P,)."""
        return level_at(self.model.config, values_at(self.parameters, z))

    def scatter(self, z: Floats) -> Scatter:
        """Scatter and mean shift of the throws at standard scores (P,)."""
        config = self.level(z)
        outcomes = self.model.outcomes(config)
        middle = self.model.quick_landings([config])[0]
        draws, count = self.model.draws, len(middle)
        landing = outcomes.landing.reshape(count, draws, 2)
        holds = outcomes.holds.reshape(count, draws).astype(np.float64)
        # Of the draws only those count whose cup would have sealed and held, and let go without a second touch.
        chance = outcomes.sealed.reshape(count, draws) * holds + 1e-9
        touched = outcomes.touched.reshape(count, draws)
        astray = (chance * touched).sum(axis=1) / chance.sum(axis=1)
        weight = chance * np.where(touched, 1e-6, 1.0)
        weight /= weight.sum(axis=1, keepdims=True)
        mean = (weight[:, :, None] * landing).sum(axis=1)
        deviation = landing - mean[:, None]
        share = np.einsum("nk,nki,nkj->nij", weight, deviation, deviation)
        share[~self.model.flown] = 0.0
        # Unbiased, and for the inverse of a covariance of few draws (Hartlap's factor for two dimensions).
        size = 1.0 / (weight**2).sum(axis=1)
        share *= (size / np.maximum(size - 4.0, 1.0))[:, None, None]
        share *= 1.0 + 1.0 / draws  # the mean over the draws has an error of its own
        noise = max(self.model.config.feedback.noise, FINEST)
        covariance = self.spread * (share + np.eye(2) * noise**2)
        root = np.linalg.inv(np.linalg.cholesky(covariance))
        return Scatter(mean - middle, covariance, root, holds, np.clip(astray, LEAST_ASTRAY, MOST_ASTRAY))

    def landings(self, z: Floats, scatter: Scatter) -> Floats:
        """Mean landings (N, 2) [m] at standard scores (P,)."""
        return self._landings([z], scatter)[0]

    def _landings(self, scores: Sequence[Floats], scatter: Scatter) -> Floats:
        """Mean landings (C, N, 2) [m] at several standard scores (P,)."""
        return self.model.quick_landings([self.level(z) for z in scores]) + scatter.shift

    def _whiten(self, predicted: Floats, scatter: Scatter) -> Floats:
        """Landings minus predictions (N, 2) [m], whitened, of throws that have a landing (L, 2)."""
        miss = (self.model.log.landing - predicted)[self.has_landing]
        return np.einsum("nij,nj->ni", scatter.root[self.has_landing], miss)

    def chances(self, z: Floats, scatter: Scatter, predicted: Floats) -> Floats:
        """Probabilities of what came of the throws, but for the places of their landings (N + U,).

        The last U are those of throws without a landing though nothing failed: the camera missed them, or they came
        down beyond its view.
        """
        sealed = self.model.seals(self.level(z)).reshape(scatter.holds.shape)
        holds, seal = (sealed * scatter.holds).mean(axis=1), sealed.mean(axis=1)
        # Of a free motion nothing says how likely an object is lost.
        lost = seal if self.model.log.has_free_motion else seal - holds
        chance = np.where(self._unsealed, 1.0 - seal, np.where(self._lost, lost, holds))
        chance[~(self._unsealed | self._lost | self.has_landing | self._unseen)] = 1.0
        rows, feedback = self._unseen, self.model.config.feedback
        distance = np.hypot(*(predicted - self.model.log.target)[rows].T)
        width = np.sqrt(np.trace(scatter.covariance[rows], axis1=1, axis2=2) / 2.0)
        far = norm.cdf((distance - feedback.view) / width)
        unseen = feedback.unseen + (1.0 - feedback.unseen) * far
        return np.clip(np.concatenate([chance, unseen]), LEAST_CHANCE, 1.0 - LEAST_CHANCE)

    def residuals(self, z: Floats, scatter: Scatter) -> Floats:
        """Residuals of `least_squares`: landings, scores, chances."""
        return self._residuals(z, scatter, self.landings(z, scatter))

    def _residuals(self, z: Floats, scatter: Scatter, predicted: Floats) -> Floats:
        miss, chances = self._whiten(predicted, scatter), self.chances(z, scatter, predicted)
        square = (miss**2).sum(axis=1)
        loss = self._regular(square, scatter)[1]
        robust = miss * np.sqrt(loss / np.maximum(square, 1e-12))[:, None]
        return np.concatenate([robust.ravel(), z, np.sqrt(-2.0 * np.log(chances))])

    def _regular(self, square: Floats, scatter: Scatter) -> tuple[Floats, Floats, Floats]:
        """Of landings with squared Mahalanobis distances (L,): a mixture of regular throws and throws gone astray.

        Returns:
            The probability that each is regular, -2 ln of the density relative to the middle, and -2 ln of that in the
            middle, (L,) each.
        """
        covariance, share = scatter.covariance[self.has_landing], scatter.astray[self.has_landing]
        area = np.sqrt(np.linalg.det(covariance))
        # The distance on the wide scale, as if a covariance were round.
        wide = np.exp(-0.5 * square * area / ASTRAY**2) / ASTRAY**2
        close = np.exp(-0.5 * square) / area
        density, peak = (1.0 - share) * close + share * wide, (1.0 - share) / area + share / ASTRAY**2
        density = np.maximum(density, LEAST_DENSITY)
        return (1.0 - share) * close / density, np.maximum(-2.0 * np.log(density / peak), 0.0), -2.0 * np.log(peak)

    def differences(self, z: Floats, scatter: Scatter, free: Bools) -> Floats:
        """Derivatives of the residuals by the free scores (R, F)."""
        scores = [z, *(z + STEP * np.eye(len(z))[free])]
        middle, *ends = map(self._residuals, scores, repeat(scatter), self._landings(scores, scatter))
        return np.stack([(end - middle) / STEP for end in ends], axis=1)

    def node(self, start: Floats, free: Bools) -> Node:
        """The maximum of the density near a start (P,) over the free scores (P,), with the scatter of the start."""
        scatter = self.scatter(start)
        result = self._descend(start, scatter, free, NODE_CALLS)
        z = _insert(start, free, result.x)
        cost = 2.0 * result.cost + self._regular(np.zeros(int(self.has_landing.sum())), scatter)[2].sum()
        # The rows of the scores are an identity, so the information is never singular.
        return Node(z, np.linalg.inv(result.jac.T @ result.jac), float(cost))

    def search(self, start: Floats) -> Mode:
        """The maximum of the density near a start (P,)."""
        z, scatter, free = start, self.scatter(start), np.ones(len(start), dtype=np.bool_)
        for _ in range(ROUNDS):
            result = self._descend(z, scatter, free, CALLS)
            moved, z = np.abs(result.x - z).max(), result.x
            scatter = self.scatter(z)
            if moved < SETTLED:
                break
        return self._laplace(z, scatter)

    def _descend(self, z: Floats, scatter: Scatter, free: Bools, calls: int) -> Any:
        """Result of `least_squares` over the free scores, at a fixed scatter."""

        def residuals(part: Floats) -> Floats:
            return self.residuals(_insert(z, free, part), scatter)

        def differences(part: Floats) -> Floats:
            return self.differences(_insert(z, free, part), scatter, free)

        return least_squares(
            residuals, z[free], cast("Any", differences), xtol=5e-3, ftol=1e-3, gtol=1e-2, max_nfev=calls
        )

    def _laplace(self, z: Floats, scatter: Scatter) -> Mode:
        """The mode at scores (P,), with the curvature there."""
        steps = 0.5 * STEP * np.eye(len(z))
        scores = [z, *(z + steps), *(z - steps)]
        predictions = self._landings(scores, scatter)
        miss, *misses = [self._whiten(predicted, scatter) for predicted in predictions]
        chance, *chances = map(self.chances, scores, repeat(scatter), predictions)
        pairs = range(len(z))
        slopes = [(misses[k] - misses[k + len(z)]) / STEP for k in pairs]
        changes = [(chances[k] - chances[k + len(z)]) / STEP for k in pairs]
        weight, _, _ = self._regular((miss**2).sum(axis=1), scatter)
        jacobian = (np.stack(slopes, axis=2) * np.sqrt(weight)[:, None, None]).reshape(-1, len(z))
        change = np.stack(changes, axis=1) / np.sqrt(chance * (1.0 - chance))[:, None]
        information = np.eye(len(z)) + jacobian.T @ jacobian + change.T @ change
        return Mode(z, np.asarray(np.linalg.inv(information), dtype=np.float64), scatter, jacobian, miss, weight)


def _insert(z: Floats, free: Bools, part: Floats) -> Floats:
    """Scores (P,) in which the free ones are replaced."""
    whole = z.copy()
    whole[free] = part
    return whole
