"""The next throws that tell most of a cell's parameters: greedy D-optimal choice among reachable releases."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Floats, Ints, take
from pnt_gym.cells.conveyor.config import ConveyorConfig

from ..ground.environments import core_of, make_vector
from ..ground.infos import results
from . import log
from .density import Density, finite_numbers
from .fitted import Fitted
from .log import ThrowLog
from .model import ThrowModel
from .parameters import Parameter

POOL: Final = 800
"""Releases among which throws are chosen."""
DRAWS: Final = 32
"""Draws of each candidate's hidden values; with few, throws are chosen whose scatter seems small by chance."""
SLOWER: Final = (0.67, 0.83)
"""Further speed settings of a plan, as shares of the level's slowest."""
REACH: Final = 0.5
"""Largest action by which a candidate's release differs from the planner's, of 1."""
SLOPE: Final = 0.25
"""Step of differences, in standard scores."""


@final
class DesignPool:
    """Picks of a cell with releases, of which a plan throws some.

    Args:
        config: the cell.
        seed: of picks and releases.
    """

    def __init__(self, config: ConveyorConfig, seed: int) -> None:
        slowest = min(config.limits.percent)
        settings = sorted({*config.limits.percent, *(max(round(share * slowest), 1) for share in SLOWER)})
        limits = config.limits.model_copy(update={"percent": tuple(float(s) for s in settings)})
        # A new name, so that a cell that is no shipped one is checked as a user's.
        self.config = config.model_copy(update={"limits": limits, "name": "pool"})
        self._env = make_vector("PnTRelease-v0", self.config, POOL, 1)
        self._core = core_of(self._env)
        self._env.reset(seed=seed)
        self._actions = np.random.default_rng((seed, 3)).uniform(-REACH, REACH, (POOL, 2)).astype(np.float32)
        plans, _ = self._core.plan(self._actions)
        self.log = ThrowLog.of(self._core.context, plans)
        """The candidates, without results."""

    def throw(self, seed: int) -> ThrowLog:
        """The candidates with the results of their throws."""
        _, _, _, _, info = self._env.step(self._actions)
        return log.complete(self.log, results(info, POOL), self.config, np.random.default_rng((seed, 7)))

    def close(self) -> None:
        """Close the environment."""
        self._env.close()


def information(log: ThrowLog, config: ConveyorConfig, parameters: Sequence[Parameter], z: Floats) -> Floats:
    """Whitened slopes of the landings of candidates by the scores (N, 2, P), times the root of their chance to land."""
    model = ThrowModel(log, config)
    density = Density(model, parameters)
    scatter = density.scatter(z)
    slopes = [
        (density.landings(z + step, scatter) - density.landings(z - step, scatter)) / (2.0 * SLOPE)
        for step in SLOPE * np.eye(len(parameters))
    ]
    white = np.einsum("nij,njp->nip", scatter.root, np.stack(slopes, axis=2))
    holds = (model.seals(density.level(z)).reshape(scatter.holds.shape) * scatter.holds).mean(axis=1)
    return white * np.sqrt(holds * (1.0 - scatter.astray))[:, None, None]


def choose(
    log: ThrowLog,
    config: ConveyorConfig,
    parameters: Sequence[Parameter],
    count: int,
    z: Floats | None = None,
    before: Floats | None = None,
) -> Ints:
    """Indices of the candidates that tell most, in their order of choice.

    Args:
        log: the candidates.
        config: the level.
        parameters: the free parameters.
        count: number of throws to choose.
        z: standard scores at which slopes are taken; None for the prior's mean.
        before: information that there is already (P, P); None for that of the prior.
    """
    scores = np.zeros(len(parameters)) if z is None else z
    slopes = information(log, config, parameters, scores)
    whole, chosen = np.eye(len(parameters)) if before is None else before.copy(), list[int]()
    for _ in range(min(count, len(log))):
        spread = np.linalg.inv(whole)
        # det(A + G'G) = det(A) det(I + G A^-1 G') for the two rows G of a throw.
        inner = np.eye(2) + np.einsum("nip,pq,njq->nij", slopes, spread, slopes)
        gain = np.linalg.det(inner)
        gain[chosen] = 0.0
        best = int(np.argmax(np.nan_to_num(gain)))
        chosen.append(best)
        whole += slopes[best].T @ slopes[best]
    return np.array(chosen, dtype=np.int64)


@finite_numbers()
def plan_throws(
    config: ConveyorConfig, parameters: Sequence[Parameter], count: int, seed: int, fitted: Fitted | None = None
) -> ThrowLog:
    """The next throws that tell most, without results.

    Args:
        config: the level.
        parameters: the free parameters.
        count: number of throws.
        seed: of the picks and releases among which to choose.
        fitted: fit of the throws that were logged before; None for none.
    """
    with closing(DesignPool(config, seed)) as pool:
        if fitted is None:
            return take(pool.log, choose(pool.log, config, parameters, count))
        best = fitted.posterior.best
        before = np.asarray(np.linalg.inv(best.covariance), dtype=np.float64)
        return take(pool.log, choose(pool.log, config, parameters, count, best.z, before))
