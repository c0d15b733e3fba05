"""Search for an index by what it brings in shifts alone: weights of a choice's entries, by evolution (CMA-ES)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import cma
import numpy as np

from pnt_gym.arrays import Floats

from ..dispatchers.scored import Scored
from ..policies.scorer import NAMES, Scorer
from .search import EACH, POPULATION, Bench, Settings, Tried

WEIGHED: Final = tuple(name for name in NAMES if name != "real")
"""Entries of a choice that an index can weigh."""
SPREAD: Final = 0.15
"""Of the weights in the first generation, about those that it begins with."""


def searched(
    bench: Bench, patience: float, generations: int, seed: int, begin: Mapping[str, float] | None = None
) -> list[Tried]:
    """The index that a search ends with, and the one that it began with, as settings of `index`.

    Args:
        bench: where both are compared in the end; the search has other shifts.
        patience: of the rule [s].
        generations: of the search.
        seed: of what it draws.
        begin: weights to begin with, others nothing; none at all are the ATC rule.
    """
    first = np.array([(begin or {}).get(name, 0.0) for name in WEIGHED])
    # The seed 0 would mean the time of day there.
    search = cma.CMAEvolutionStrategy(first, SPREAD, {"popsize": POPULATION, "seed": seed + 1, "verbose": -9})
    for generation in range(generations):
        found = search.ask()
        shifts = bench.apart(EACH, generation)
        search.tell(found, (-_worth(shifts, [_settings(patience, one) for one in found])).tolist())
    tried = [_settings(patience, search.result.xfavorite), {"patience": patience, "weights": dict(begin or {})}]
    values = bench.beside([Scored("index", Scorer.linear(**settings)) for settings in tried])
    return [Tried(settings, value) for settings, value in zip(tried, values, strict=True)]


def _worth(bench: Bench, tried: list[Settings]) -> Floats:
    """Mean value per minute of some indices (C,)."""
    return bench.beside([Scored("index", Scorer.linear(**settings)) for settings in tried]).mean(axis=1)


def _settings(patience: float, weights: Floats) -> Settings:
    """Of a controller `index`."""
    return {
        "patience": patience,
        "weights": {name: round(float(w), 3) for name, w in zip(WEIGHED, weights, strict=True)},
    }
