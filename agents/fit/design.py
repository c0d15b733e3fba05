"""The next throws that tell most of a cell's parameters: greedy D-optimal choice among reachable releases."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import closing
from typing import Final, NamedTuple, final

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


class Worth(NamedTuple):
    """What candidates tell of the parameters.

    Attributes:
        slopes: whitened slopes of the landings by the scores (N, 2, P), times the root of their chance to land.
        chance: chance that a throw seals, holds, and lands without a second touch of the cup (N,).
        deviation: scatter of the landings (N,) [m].
    """

    slopes: Floats
    chance: Floats
    deviation: Floats


class Choice(NamedTuple):
    """Chosen candidates.

    Attributes:
        rows: indices in their order of choice (M,).
        gains: ln of the factor by which each multiplied the determinant of the information (M,).
        left: the same for each candidate as a further throw (N,).
    """

    rows: Ints
    gains: Floats
    left: Floats


class Plan(NamedTuple):
    """The next throws.

    Attributes:
        throws: the throws, without results.
        absent: a sentence on each item of which there is no throw.
    """

    throws: ThrowLog
    absent: list[str]


def information(log: ThrowLog, config: ConveyorConfig, parameters: Sequence[Parameter], z: Floats) -> Worth:
    """What candidates tell at standard scores (P,)."""
    model = ThrowModel(log, config)
    density = Density(model, parameters)
    scatter = density.scatter(z)
    slopes = [
        (density.landings(z + step, scatter) - density.landings(z - step, scatter)) / (2.0 * SLOPE)
        for step in SLOPE * np.eye(len(parameters))
    ]
    white = np.einsum("nij,njp->nip", scatter.root, np.stack(slopes, axis=2))
    holds = (model.seals(density.level(z)).reshape(scatter.holds.shape) * scatter.holds).mean(axis=1)
    chance = holds * (1.0 - scatter.astray)
    deviation = np.sqrt(np.trace(scatter.covariance, axis1=1, axis2=2) / 2.0)
    return Worth(white * np.sqrt(chance)[:, None, None], chance, deviation)


def choose(slopes: Floats, count: int, before: Floats | None = None) -> Choice:
    """The candidates that tell most, greedily.

    Args:
        slopes: of the candidates, as of `Worth` (N, 2, P).
        count: number of throws to choose.
        before: information that there is already (P, P); None for that of the prior.
    """
    whole, chosen, gains = np.eye(slopes.shape[2]) if before is None else before.copy(), list[int](), list[float]()
    while True:
        spread = np.linalg.inv(whole)
        # det(A + G'G) = det(A) det(I + G A^-1 G') for the two rows G of a throw.
        inner = np.eye(2) + np.einsum("nip,pq,njq->nij", slopes, spread, slopes)
        gain = np.log(np.maximum(np.nan_to_num(np.linalg.det(inner), nan=1.0), 1.0))
        gain[chosen] = -1.0
        if len(chosen) == min(count, len(slopes)):
            return Choice(np.array(chosen, dtype=np.int64), np.array(gains), gain)
        best = int(np.argmax(gain))
        chosen.append(best)
        gains.append(float(gain[best]))
        whole += slopes[best].T @ slopes[best]


@finite_numbers()
def plan_throws(
    config: ConveyorConfig, parameters: Sequence[Parameter], count: int, seed: int, fitted: Fitted | None = None
) -> Plan:
    """The next throws that tell most, without results, and why some items have none.

    Args:
        config: the level.
        parameters: the free parameters.
        count: number of throws.
        seed: of the picks and releases among which to choose.
        fitted: fit of the throws that were logged before; None for none.
    """
    z, before = np.zeros(len(parameters)), None
    if fitted is not None:
        best = fitted.posterior.best
        z, before = best.z, np.asarray(np.linalg.inv(best.covariance), dtype=np.float64)
    with closing(DesignPool(config, seed)) as pool:
        worth = information(pool.log, config, parameters, z)
        choice = choose(worth.slopes, count, before)
        return Plan(take(pool.log, choice.rows), list(_absent(pool.log, config, worth, choice)))


def _absent(log: ThrowLog, config: ConveyorConfig, worth: Worth, choice: Choice) -> Iterator[str]:
    """A sentence on each item of which no candidate was chosen."""
    thrown, usual = set(log.kind[choice.rows].tolist()), float(np.median(worth.deviation[choice.rows]))
    for kind, (name, share) in enumerate(zip(config.items, config.shares(), strict=True)):
        rows = np.flatnonzero(log.kind == kind)
        if kind in thrown:
            continue
        start = f"No throw of {name}: "
        if share == 0.0:
            yield f"{start}the level's mix has none."
        elif not rows.size:
            yield (
                f"{start}none of {len(log)} simulated picks is one, of {share * len(log):.0f} by its share; the "
                "planner finds no throw of it that its cup holds into a bin within reach, or it is rare."
            )
        else:
            best = int(rows[np.argmax(choice.left[rows])])
            yield (
                f"{start}the best of its {len(rows)} candidates would add {choice.left[best] / choice.gains[-1]:.0%} "
                f"of what the last chosen throw adds; it lands with a chance of {worth.chance[best]:.0%} and scatters "
                f"{1e3 * worth.deviation[best]:.0f} mm, the chosen ones {1e3 * usual:.0f} mm."
            )
