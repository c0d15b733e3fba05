"""Search for an index by its value in whole shifts: weights of a choice's entries, by evolution (CMA-ES)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

import cma
import numpy as np

from pnt_gym.arrays import Floats

from ..policies.scorer import NAMES, Scorer
from .scored import ScoreController
from .search import EACH, POPULATION, Bench, Settings, SettingsResult

WEIGHED: Final = tuple(name for name in NAMES if name != "real")
"""Entries of a choice that an index can weigh."""
SPREAD: Final = 0.15
"""Standard deviation of the weights in the first generation about their initial values."""


def search_weights(
    bench: Bench, patience: float, generations: int, seed: int, begin: Mapping[str, float] | None = None
) -> list[SettingsResult]:
    """Results of the index at the end of a search and of the initial one, with their settings of `index`.

    Args:
        bench: bench on which both are compared in the end; the search uses other shifts.
        patience: patience of the rule [s].
        generations: generations of the search.
        seed: seed of the search.
        begin: initial weights, zero for entries not listed; without any the index is the ATC rule.
    """
    first = np.array([(begin or {}).get(name, 0.0) for name in WEIGHED])
    # For cma the seed 0 means the time of day.
    search = cma.CMAEvolutionStrategy(first, SPREAD, {"popsize": POPULATION, "seed": seed + 1, "verbose": -9})
    for generation in range(generations):
        candidates = search.ask()
        shifts = bench.other_shifts(EACH, generation)
        search.tell(
            candidates, (-_mean_values(shifts, [_index_settings(patience, weights) for weights in candidates])).tolist()
        )
    settings_pair = [
        _index_settings(patience, search.result.xfavorite),
        {"patience": patience, "weights": dict(begin or {})},
    ]
    values = bench.compare([ScoreController("index", Scorer.linear(**settings)) for settings in settings_pair])
    return [SettingsResult(settings, value) for settings, value in zip(settings_pair, values, strict=True)]


def _mean_values(bench: Bench, candidates: list[Settings]) -> Floats:
    """Mean value per minute of some indices (C,)."""
    return bench.compare([ScoreController("index", Scorer.linear(**settings)) for settings in candidates]).mean(axis=1)


def _index_settings(patience: float, weights: Floats) -> Settings:
    """Settings of a controller `index`."""
    return {
        "patience": patience,
        "weights": {name: round(float(w), 3) for name, w in zip(WEIGHED, weights, strict=True)},
    }
