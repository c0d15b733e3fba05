"""Settings of rules from tries: many settings with few tries each, then the better ones with more."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import Final

import numpy as np

from .features import place_features
from .rules import Weights, rule_places
from .scenes import Scenes

DEPTH_SETTINGS: Final = tuple(
    Weights(rough_in=share, rough_out=1.0 - share, distance=distance, slope=slope)
    for share, distance, slope in product((0.0, 0.5, 1.0), (0.2, 0.5, 1.0, 2.0, 4.0, 8.0), (0.0, 4.0, 8.0, 16.0))
)
"""72 settings without colour."""
STAGES: Final = 3
"""Rounds; each leaves a quarter of the settings, and takes the same number of tries."""


def colour_settings(weights: Weights) -> tuple[Weights, ...]:
    """64 settings with colour and gloss around a setting without."""
    return tuple(
        weights._replace(matte=matte, odd=odd, distance=weights.distance * factor)
        for matte, odd, factor in product(
            (-2.0, 0.0, 1.0, 2.0, 4.0, 8.0, 12.0, 16.0), (-2.0, 0.0, 1.0, 2.0), (0.5, 1.0)
        )
    )


def tune(level: str, settings: Sequence[Weights], tries: int, seed: int) -> Weights:
    """The setting whose tries are worth the most, by successive halving; every try is on a fresh object."""
    left = list(settings)
    for stage in range(STAGES):
        count = max(tries // (STAGES * len(left)), 1)
        scores: list[float] = []
        for k, weights in enumerate(left):
            scenes = Scenes.draw(level, count, 100_000 * (seed + 1) + 1000 * stage + k)
            features = place_features(scenes.images, scenes.radius)
            scores.append(float(scenes.try_places(rule_places(features, weights)).worth.mean()))
        keep = max(len(left) // 4, 1) if stage < STAGES - 1 else 1
        left = [left[k] for k in np.argsort(scores)[::-1][:keep]]
    return left[0]
