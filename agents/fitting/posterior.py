"""The posterior of a cell's parameters: maximum a posteriori from several starts, and a mixture of the modes.

Parameters are standard scores z of their priors. Residuals of `least_squares` are the landings, whitened by a 2x2
covariance for each throw and made robust together (pseudo-Huber of the Mahalanobis distance), the scores themselves,
and for each throw the square root of -2 ln of the probability of what came of it: not sealed, lost, or seen to land.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import norm

from pnt_gym.arrays import Floats
from pnt_gym.cells.conveyor.config import ConveyorConfig

from .model import Outcomes, ThrowModel
from .parameters import Parameter, level_at, values_at

ASTRAY: Final = 0.10
"""Standard deviation of a landing after the cup has touched the object again, or of another accident [m]."""
LEAST_ASTRAY, MOST_ASTRAY = 0.03, 0.97
"""Bounds of the share of such throws among throws like one of the log."""
STARTS: Final = (-2.0, -1.2, -0.6, 0.0, 0.6, 1.4)
"""Starts of the lip's stiffness, in standard scores: the phase of a swing at the release has several solutions."""
SEARCHES: Final = 3
"""Starts that are followed to their modes."""
SOFT: Final = 6.0
"""Factor of the covariances while a search begins."""
STEP: Final = 0.12
"""Step of differences, in standard scores."""
ROUNDS: Final = 3
"""Times that scatter and mean of the draws are computed anew at the new parameters."""
LEAST_CHANCE: Final = 1e-4
"""Chances are kept from this value to 1 minus it, as no model is so sure."""
SAMPLES: Final = 4000
"""Samples of the posterior."""
SAME: Final = 0.5
"""Largest distance of scores at which two modes are one."""


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
    held: Floats
    """Whether a cup that has sealed holds the object, for each draw (N, K)."""
    astray: Floats
    """Share of throws that the cup touches again, or that go astray otherwise (N,)."""


@final
@dataclass(frozen=True)
class Mode:
    """One mode of the posterior."""

    z: Floats
    """Standard scores (P,)."""
    covariance: Floats
    """Laplace approximation (P, P)."""
    cost: float
    """-2 ln of the posterior's density, up to a constant."""
    scatter: Scatter
    jacobian: Floats
    """Whitened change of the landings per score, robust weights included (2 L, P)."""
    residual: Floats
    """Whitened landings minus predictions (L, 2)."""
    regular: Floats
    """Probability that each landing is that of a regular throw (L,)."""


@final
class Problem:
    """The posterior's density for one log.

    Args:
        model: the throws.
        parameters: free parameters and priors.
        spread: factor of the throws' covariance.
    """

    def __init__(self, model: ThrowModel, parameters: Sequence[Parameter], spread: float = 1.0) -> None:
        self.model, self.parameters, self.spread = model, tuple(parameters), spread
        log = model.log
        self.landed = log.landed
        self._unsealed, self._lost = log.sealed == 0.0, log.lost == 1.0
        # A throw without a landing and without a word on seal and loss says nothing.
        self._unseen = (log.sealed == 1.0) & ~(log.lost == 1.0) & ~self.landed & np.isfinite(log.target).all(axis=1)

    def level(self, z: Floats) -> ConveyorConfig:
        """The cell at standard scores (P,)."""
        return level_at(self.model.config, values_at(self.parameters, z))

    def scatter(self, z: Floats, soft: float = 1.0) -> Scatter:
        """Scatter and mean shift of the throws at standard scores (P,), with covariances times a factor."""
        config = self.level(z)
        return self.scatter_of(self.model.outcomes(config), self.model.landings(config), soft)

    def scatter_of(self, outcomes: Outcomes, middle: Floats, soft: float = 1.0) -> Scatter:
        """Scatter from the outcomes of draws, and landings at mean hidden values (N, 2) [m]."""
        draws, count = self.model.draws, len(middle)
        landing = outcomes.landing.reshape(count, draws, 2)
        held = outcomes.held.reshape(count, draws).astype(np.float64)
        # Of the draws only those count whose cup would have sealed and held, and let go without a second touch.
        thrown = outcomes.sealed.reshape(count, draws) * held + 1e-9
        touched = outcomes.touched.reshape(count, draws)
        astray = (thrown * touched).sum(axis=1) / thrown.sum(axis=1)
        weight = thrown * np.where(touched, 1e-6, 1.0)
        weight /= weight.sum(axis=1, keepdims=True)
        mean = (weight[:, :, None] * landing).sum(axis=1)
        apart = landing - mean[:, None]
        share = np.einsum("nk,nki,nkj->nij", weight, apart, apart)
        # Unbiased, and for the inverse of a covariance of few draws (Hartlap's factor for two dimensions).
        size = 1.0 / (weight**2).sum(axis=1)
        share *= (size / np.maximum(size - 4.0, 1.0))[:, None, None]
        covariance = soft * self.spread * (share + np.eye(2) * self.model.config.feedback.noise**2)
        root = np.linalg.inv(np.linalg.cholesky(covariance))
        return Scatter(mean - middle, covariance, root, held, np.clip(astray, LEAST_ASTRAY, MOST_ASTRAY))

    def predicted(self, z: Floats, scatter: Scatter) -> Floats:
        """Mean landings (N, 2) [m] at standard scores (P,)."""
        return self.model.landings(self.level(z)) + scatter.shift

    def whiten(self, predicted: Floats, scatter: Scatter) -> Floats:
        """Landings minus predictions (N, 2) [m], whitened, of throws that have a landing (L, 2)."""
        miss = (self.model.log.landing - predicted)[self.landed]
        return np.einsum("nij,nj->ni", scatter.root[self.landed], miss)

    def chances(self, z: Floats, scatter: Scatter, predicted: Floats) -> Floats:
        """Probabilities of what came of the throws, but for the places of their landings (N + U,).

        The last U are those of throws without a landing though nothing failed: the camera missed them, or they came
        down beyond its view.
        """
        sealed = self.model.seals(self.level(z)).reshape(scatter.held.shape)
        held, seal = (sealed * scatter.held).mean(axis=1), sealed.mean(axis=1)
        chance = np.where(self._unsealed, 1.0 - seal, np.where(self._lost, seal - held, held))
        chance[~(self._unsealed | self._lost | self.landed | self._unseen)] = 1.0
        rows, feedback = self._unseen, self.model.config.feedback
        distance = np.hypot(*(predicted - self.model.log.target)[rows].T)
        width = np.sqrt(np.trace(scatter.covariance[rows], axis1=1, axis2=2) / 2.0)
        far = norm.cdf((distance - feedback.view) / width)
        unseen = feedback.unseen + (1.0 - feedback.unseen) * far
        return np.clip(np.concatenate([chance, unseen]), LEAST_CHANCE, 1.0 - LEAST_CHANCE)

    def residuals(self, z: Floats, scatter: Scatter) -> Floats:
        """Residuals of `least_squares`: landings, scores, chances."""
        predicted = self.predicted(z, scatter)
        miss, chances = self.whiten(predicted, scatter), self.chances(z, scatter, predicted)
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
        covariance, share = scatter.covariance[self.landed], scatter.astray[self.landed]
        area = np.sqrt(np.linalg.det(covariance))
        # The distance on the wide scale, as if a covariance were round.
        wide = np.exp(-0.5 * square * area / ASTRAY**2) / ASTRAY**2
        close = np.exp(-0.5 * square) / area
        density, peak = (1.0 - share) * close + share * wide, (1.0 - share) / area + share / ASTRAY**2
        return (1.0 - share) * close / density, np.maximum(-2.0 * np.log(density / peak), 0.0), -2.0 * np.log(peak)

    def differences(self, z: Floats, scatter: Scatter) -> Floats:
        """Derivatives of the residuals by the scores (R, P)."""
        here = self.residuals(z, scatter)
        columns = [(self.residuals(z + step, scatter) - here) / STEP for step in STEP * np.eye(len(z))]
        return np.stack(columns, axis=1)

    def approach(self, start: Floats) -> tuple[float, Floats]:
        """Cost and scores (P,) after a short search from a start, in which far landings still pull."""
        scatter = self.scatter(start, SOFT)
        search = least_squares(self.residuals, start, self.differences, args=(scatter,), xtol=1e-2, max_nfev=4)
        return self.cost(search.x), search.x

    def cost(self, z: Floats) -> float:
        """-2 ln of the posterior's density at scores (P,), up to a constant."""
        scatter = self.scatter(z)
        residuals = self.residuals(z, scatter)
        return float(residuals @ residuals + self._regular(np.zeros(int(self.landed.sum())), scatter)[2].sum())

    def mode(self, start: Floats) -> Mode:
        """The mode that a start (P,) leads to."""
        z, scatter = start, self.scatter(start)
        for _ in range(ROUNDS):
            search = least_squares(
                self.residuals, z, self.differences, args=(scatter,), xtol=5e-3, ftol=1e-3, gtol=1e-2, max_nfev=8
            )
            moved, z = np.abs(search.x - z).max(), search.x
            scatter = self.scatter(z)
            if moved < 0.05:
                break
        return self._laplace(z, scatter)

    def _laplace(self, z: Floats, scatter: Scatter) -> Mode:
        """The mode at scores (P,), with the curvature there."""
        slopes, changes = [], []
        for step in STEP * np.eye(len(z)):
            ends = [(z + sign * step, self.predicted(z + sign * step, scatter)) for sign in (1.0, -1.0)]
            high, low = (self.whiten(predicted, scatter) for _, predicted in ends)
            slopes.append((high - low) / (2.0 * STEP))
            high, low = (self.chances(end, scatter, predicted) for end, predicted in ends)
            changes.append((high - low) / (2.0 * STEP))
        predicted = self.predicted(z, scatter)
        miss, chance = self.whiten(predicted, scatter), self.chances(z, scatter, predicted)
        weight, _, peak = self._regular((miss**2).sum(axis=1), scatter)
        jacobian = (np.stack(slopes, axis=2) * np.sqrt(weight)[:, None, None]).reshape(-1, len(z))
        change = np.stack(changes, axis=1) / np.sqrt(chance * (1.0 - chance))[:, None]
        information = np.eye(len(z)) + jacobian.T @ jacobian + change.T @ change
        residuals = self.residuals(z, scatter)
        cost = float(residuals @ residuals + peak.sum())
        return Mode(z, np.linalg.inv(information), cost, scatter, jacobian, miss, weight)


@final
@dataclass(frozen=True)
class Posterior:
    """Posterior of the parameters of one log, as a mixture of normal distributions of their scores."""

    problem: Problem
    modes: tuple[Mode, ...]
    """Distinct modes, the most probable first."""
    weights: Floats
    """Their probabilities (M,)."""
    inflation: float
    """Factor of the covariances, for throws that scatter more than assumed; at least 1."""

    @property
    def best(self) -> Mode:
        """The most probable mode."""
        return self.modes[0]

    def samples(self, count: int = SAMPLES, seed: int = 0) -> Floats:
        """Samples of the scores (S, P)."""
        random = np.random.default_rng(seed)
        chosen = random.choice(len(self.modes), size=count, p=self.weights)
        normal = random.standard_normal((count, len(self.best.z)))
        scores = np.empty_like(normal)
        for index, mode in enumerate(self.modes):
            rows = chosen == index
            root = np.linalg.cholesky(self.inflation * mode.covariance)
            scores[rows] = mode.z + normal[rows] @ root.T
        return scores


def mixture(modes: Sequence[Mode]) -> tuple[tuple[Mode, ...], Floats]:
    """Distinct modes and their probabilities, by cost and volume, the most probable first."""
    distinct: list[Mode] = []
    for mode in sorted(modes, key=lambda mode: mode.cost):
        if all(np.abs(mode.z - kept.z).max() > SAME for kept in distinct):
            distinct.append(mode)
    weight = [-mode.cost / 2.0 + np.linalg.slogdet(mode.covariance)[1] / 2.0 for mode in distinct]
    share = np.exp(np.array(weight) - max(weight))
    order = np.argsort(-share)
    return tuple(distinct[index] for index in order), share[order] / share.sum()


def find_modes(problem: Problem) -> list[Mode]:
    """Modes of a posterior: of several starts the best after a short search are followed to their ends."""
    names = [parameter.name for parameter in problem.parameters]
    zero = np.zeros(len(names))
    if "stiffness" not in names:
        return [problem.mode(problem.approach(zero)[1])]
    column = np.arange(len(names)) == names.index("stiffness")
    begun = sorted((problem.approach(np.where(column, score, zero)) for score in STARTS), key=lambda pair: pair[0])
    return [problem.mode(z) for _, z in begun[:SEARCHES]]
