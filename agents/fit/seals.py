"""The chance that a cup seals, for each item of a log."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.conveyor.config import ConveyorConfig

from .model import ThrowModel

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
    share = model.overhang(config)
    for kind in np.unique(log.kind):
        rows = (log.kind == kind) & np.isfinite(log.sealed)
        if not rows.any():
            continue
        usual = float(np.clip(model.chances[kind], 0.01, 0.99))
        seals = np.clip(1.0 - m * (1.0 - GRID[:, None] * share[rows]), 1e-6, 1.0 - 1e-6)
        sealed = log.sealed[rows] == 1.0
        likelihood = np.where(sealed, np.log(seals), np.log1p(-seals)).sum(axis=1)
        prior = PRIOR_TRIES * (usual * np.log(GRID) + (1.0 - usual) * np.log1p(-GRID))
        mean, low, high = _summary(likelihood + prior)
        model.chances[kind] = mean
        results.append(SealChance(config.items[kind], int(rows.sum()), int(sealed.sum()), mean, low, high))
    return results


def _summary(log_density: Floats) -> tuple[float, float, float]:
    """Mean and ends of the 95 % interval of a density on the grid."""
    density = np.exp(log_density - log_density.max())
    density /= density.sum()
    low, high = np.interp((0.025, 0.975), np.cumsum(density), GRID)
    return float(density @ GRID), float(low), float(high)
