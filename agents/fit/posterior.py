"""The posterior of a cell's parameters: a profile over the lip's stiffness, and normal given the stiffness.

An object swings under a lip, and the phase of the swing at the release repeats: very different stiffnesses may explain
the same landings. So the stiffness goes through a grid of nodes. At each node the other parameters have their maximum
and a Laplace approximation there; between nodes log density, means and covariances are interpolated.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Final, final

import numpy as np
from scipy.stats import norm, truncnorm

from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.conveyor.config import ConveyorConfig

from .density import Density, Mode, Node, finite_numbers
from .log import ThrowLog
from .model import ThrowModel
from .parameters import Parameter, values_at

PRIOR_TRIES: Final = 20.0
"""Number of tries that the level's own chance counts for, assumed."""
GRID: Final = np.linspace(0.005, 0.995, 199)
"""Chances that are compared."""


@final
@dataclass(frozen=True)
class SealChance:
    """Chance that a cup well inside the outline of an item seals."""

    item: str
    tries: int
    sealed: int
    mean: float
    low: float
    high: float
    """Ends of the 95 % interval."""


def seal_chances(model: ThrowModel, config: ConveyorConfig) -> list[SealChance]:
    """Chances of the items of a log, from its picks: a beta prior about the level's chance, and the lip's overhang.

    The chances of the model are set to these.
    """
    if not config.pick.fails:
        return []
    log, m, results = model.log, config.mismatch, list[SealChance]()
    share = model.overhangs(config).reshape(-1, model.draws).mean(axis=1)
    for kind in np.unique(log.kind):
        rows = (log.kind == kind) & np.isfinite(log.sealed)
        if not rows.any():
            continue
        usual = float(np.clip(model.chances[kind], 0.01, 0.99))
        seals = np.clip(1.0 - m * (1.0 - GRID[:, None] * share[rows]), 1e-6, 1.0 - 1e-6)
        sealed = log.sealed[rows] == 1.0
        likelihood = np.where(sealed, np.log(seals), np.log1p(-seals)).sum(axis=1)
        prior = PRIOR_TRIES * (usual * np.log(GRID) + (1.0 - usual) * np.log1p(-GRID))
        # Mean and ends of the 95 % interval of a density on the grid.
        log_density = likelihood + prior
        density = np.exp(log_density - log_density.max())
        density /= density.sum()
        low, high = np.interp((0.025, 0.975), np.cumsum(density), GRID)
        mean, low, high = float(density @ GRID), float(low), float(high)
        model.chances[kind] = mean
        results.append(SealChance(config.items[kind], int(rows.sum()), int(sealed.sum()), mean, low, high))
    return results


COARSE: Final = np.linspace(-2.5, 2.5, 12)
"""Scores of the stiffness at the first nodes."""
FINER: Final = 3
"""Parts into which the gap beside a probable node is divided."""
PROBABLE: Final = 9.0
"""Cost above the least at which a node is still refined."""
WIDE: Final = 25.0
"""Factor of the covariances with which the search begins, so that landings far from a first guess still pull."""
SAMPLES: Final = 4000
"""Samples of a posterior."""


@final
@dataclass(frozen=True)
class Posterior:
    """Posterior of the parameters of one log."""

    density: Density
    nodes: tuple[Node, ...]
    """Maxima at fixed stiffnesses in ascending order; none where the stiffness is not free."""
    best: Mode
    """The maximum."""
    inflation: float
    """Factor of covariances, for throws that scatter more than the level says; at least 1."""

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The free parameters."""
        return self.density.parameters

    @cached_property
    def least(self) -> Floats:
        """Standard scores of the least values of the parameters (P,)."""
        return np.array([p.score(p.least) if np.isfinite(p.least) else -np.inf for p in self.parameters])

    @property
    def z(self) -> Floats:
        """Standard scores at the maximum over the values that a cell may have (P,); the search knows no least value."""
        z, covariance = self.best.z, self.best.covariance
        low = np.flatnonzero(z < self.least)
        return z + covariance[:, low] @ np.linalg.solve(covariance[np.ix_(low, low)], (self.least - z)[low])

    @property
    def values(self) -> dict[str, float]:
        """SI values at the maximum, by name; none is a last digit below the least value of its parameter."""
        values = values_at(self.parameters, self.z)
        return {parameter.name: max(values[parameter.name], parameter.least) for parameter in self.parameters}

    @finite_numbers()
    def samples(self, count: int = SAMPLES, seed: int = 0) -> Floats:
        """Samples of the standard scores (S, P)."""
        random, size = np.random.default_rng(seed), len(self.parameters)
        normal = random.standard_normal((count, size))
        means, covariances = self._normals()
        if len(means) == 1:
            mean, nearest = means[np.zeros(count, dtype=np.int64)], np.zeros(count, dtype=np.int64)
        else:
            place, share = self._places(random, count, means, covariances)
            mean = (1.0 - share)[:, None] * means[place] + share[:, None] * means[place + 1]
            nearest = place + (share > 0.5)
        roots = np.zeros_like(covariances)
        free = covariances[0].diagonal() > 0.0
        roots[:, free[:, None] & free] = np.linalg.cholesky(covariances[:, free][:, :, free]).reshape(len(means), -1)
        samples = mean + np.einsum("sij,sj->si", roots[nearest], normal)
        for index in np.flatnonzero(np.isfinite(self.least)):
            # A draw above the least value, and what the other parameters are beside it.
            column = covariances[nearest, :, index]
            width = np.sqrt(column[:, index])
            low = (self.least[index] - mean[:, index]) / width
            drawn = mean[:, index] + width * truncnorm.ppf(random.random(count), low, np.inf)
            samples += column / width[:, None] ** 2 * (drawn - samples[:, index])[:, None]
        return samples

    def _normals(self) -> tuple[Floats, Floats]:
        """Means (K, P) and covariances (K, P, P) at the nodes, or of the whole; zero where a score is fixed."""
        if not self.nodes:
            return self.best.z[None], self.inflation * self.best.covariance[None]
        free = np.array([parameter.name != "stiffness" for parameter in self.parameters])
        covariances = np.zeros((len(self.nodes), len(free), len(free)))
        covariances[:, free[:, None] & free] = [self.inflation * node.covariance.ravel() for node in self.nodes]
        return np.stack([node.z for node in self.nodes]), covariances

    def _places(
        self, random: np.random.Generator, count: int, means: Floats, covariances: Floats
    ) -> tuple[np.ndarray, Floats]:
        """Gaps between nodes, and shares of the way through them (S,), drawn from the density of the stiffness."""
        fixed = np.array([parameter.name == "stiffness" for parameter in self.parameters])
        score = np.array([node.z[fixed][0] for node in self.nodes])
        log_density = profile(self.nodes) / self.inflation
        for index in np.flatnonzero(np.isfinite(self.least)):  # the share of a node that lies above the least value
            log_density += norm.logsf(self.least[index], means[:, index], np.sqrt(covariances[:, index, index]))
        log_density -= log_density.max()
        fine = np.linspace(score[0], score[-1], 1001)
        density = np.exp(np.interp(fine, score, log_density))
        cumulated = np.cumsum(density) / density.sum()
        drawn = np.interp(random.random(count), cumulated, fine)
        place = np.clip(np.searchsorted(score, drawn) - 1, 0, len(score) - 2)
        return place, (drawn - score[place]) / (score[place + 1] - score[place])


def profile(nodes: Sequence[Node]) -> Floats:
    """Ln of the marginal density of the fixed score at nodes (K,), relative to the largest."""
    volume = [np.linalg.slogdet(node.covariance)[1] for node in nodes]
    log_density = (np.array(volume) - np.array([node.cost for node in nodes])) / 2.0
    return log_density - log_density.max()


def posterior(
    log: ThrowLog, config: ConveyorConfig, parameters: Sequence[Parameter], spread: float = 1.0
) -> tuple[Posterior, list[SealChance]]:
    """The posterior of one log, and the chances of its items' seals.

    Args:
        log: the throws.
        config: the level, about whose values the priors lie.
        parameters: the free parameters.
        spread: factor of the covariance of the throws.
    """
    model = ThrowModel(log, config)
    seals = seal_chances(model, config)
    density = Density(model, parameters, spread)
    fixed, nodes = np.array([parameter.name == "stiffness" for parameter in parameters]), ()
    middle = np.where(fixed, COARSE[len(COARSE) // 2], 0.0)
    start = Density(model, parameters, WIDE * spread).node(middle, ~fixed).z
    if fixed.any():
        nodes = _nodes(density, fixed, start)
        start = min(nodes, key=lambda node: node.cost).z
    return Posterior(density, nodes, density.search(start), 1.0), seals


def _nodes(density: Density, fixed: Bools, begin: Floats) -> tuple[Node, ...]:
    """Maxima at fixed stiffnesses: a coarse grid from the middle outwards, and a finer one where it is probable.

    Args:
        density: the density.
        fixed: which of the scores is the stiffness (P,).
        begin: scores from which the search of the middle node begins (P,).
    """
    middle = len(COARSE) // 2
    nodes: dict[float, Node] = {}
    for half in (COARSE[middle:], COARSE[:middle][::-1]):
        z = nodes[COARSE[middle]].z if nodes else begin
        for score in half:
            nodes[score] = density.node(np.where(fixed, score, z), ~fixed)
            z = nodes[score].z
    least = min(node.cost for node in nodes.values())
    for low, high in pairwise(COARSE):
        near = min((nodes[low], nodes[high]), key=lambda node: node.cost)
        if near.cost < least + PROBABLE:
            for share in np.arange(1, FINER) / FINER:
                score = low + share * (high - low)
                start = (1.0 - share) * nodes[low].z + share * nodes[high].z
                nodes[score] = density.node(np.where(fixed, score, start), ~fixed)
    return tuple(nodes[score] for score in sorted(nodes))
