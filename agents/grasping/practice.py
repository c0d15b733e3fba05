"""Tries from which a network learns: at random first, then mostly where the network expects the most."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats

from .features import PlaceFeatures, place_features
from .maps import best_places, blur_maps
from .network import PlaceNetwork
from .scenes import Scenes

RANDOM: Final = 0.3
"""Share of the tries that are random before the first fit."""
ROUND: Final = 2000
"""Tries between two fits."""
EXPLORES: Final = 0.15
"""Share of the later tries that are random."""
TEMPERATURE: Final = 0.05
"""Of the other tries: a place is tried with a probability proportional to exp(expected worth / temperature)."""
QUICK_STEPS, STEPS = 500, 3000
"""Gradient steps of a fit on the way, and of the last one."""


@final
@dataclass(frozen=True)
class Practice:
    """A network and the tries from which it learned."""

    network: PlaceNetwork
    values: Floats
    """Features of the places (N, D)."""
    worth: Floats
    held: Bools


def practise(level: str, tries: int, seed: int, columns: tuple[int, ...] | None = None) -> Practice:
    """Try places on fresh objects of a level, one try an object, and learn from the results alone.

    Args:
        level: one of `scenes.LEVELS`.
        tries: number of tries.
        seed: seed of objects, places and networks.
        columns: features that the network sees; None for all.
    """
    network, rng = PlaceNetwork(), np.random.default_rng([seed, 2])
    values: list[Floats] = []
    worths: list[Floats] = []
    held: list[Bools] = []
    sizes = _rounds(tries)
    for k, size in enumerate(sizes):
        scenes = Scenes.draw(level, size, 1000 * (seed + 1) + k)
        features = place_features(scenes.images, scenes.radius)
        rows = _choose(features, network, rng, columns)
        results = scenes.try_places(features.places()[rows])
        values.append(features.values[rows])
        worths.append(results.worth)
        held.append(results.held)
        steps = STEPS if k == len(sizes) - 1 else QUICK_STEPS
        network.fit(_select(np.concatenate(values), columns), np.concatenate(worths), seed, steps)
    return Practice(network, np.concatenate(values), np.concatenate(worths), np.concatenate(held))


def worth_maps(features: PlaceFeatures, network: PlaceNetwork, columns: tuple[int, ...] | None = None) -> Floats:
    """Expected worths of tries in pictures (N, 48, 48), averaged over the error of the cup's place."""
    return blur_maps(features.maps(network.predict(_select(features.values, columns)), 0.0))


def network_places(features: PlaceFeatures, network: PlaceNetwork, columns: tuple[int, ...] | None = None) -> Floats:
    """The places with the highest expected worths (N, 2) [m]."""
    return best_places(worth_maps(features, network, columns))


def _select(values: Floats, columns: tuple[int, ...] | None) -> Floats:
    return values if columns is None else values[:, list(columns)]


def _rounds(tries: int) -> list[int]:
    """Numbers of tries between fits; the first ones are random."""
    first = max(int(RANDOM * tries), min(tries, 100))
    remaining = tries - first
    return [first, *[min(ROUND, remaining - k) for k in range(0, remaining, ROUND)]]


def _choose(
    features: PlaceFeatures, network: PlaceNetwork, rng: np.random.Generator, columns: tuple[int, ...] | None
) -> np.ndarray:
    """Rows of one place in each picture (N,): random without a fit, else mostly by the softmax of the worths."""
    # The largest of scores with Gumbel noise is a draw from their softmax.
    score = rng.gumbel(size=len(features.picture))
    if network.is_fitted:
        maps = worth_maps(features, network, columns)
        worth = maps[features.picture, features.pixel[:, 0], features.pixel[:, 1]]
        learned = rng.random(features.pictures) >= EXPLORES
        score += learned[features.picture] * worth / TEMPERATURE
    return features.best_rows(score)
