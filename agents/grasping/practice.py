"""Tries from which a network learns: at random first, then mostly where the network expects the most."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.grasp.config import GraspConfig

from .features import NAMES, PlaceFeatures, best_places, blur_maps, place_features
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
    """Features of the tried places (N, D)."""
    worth: Floats
    held: Bools
    pixel: Ints
    """Row and column of each try (N, 2)."""
    rounds: tuple[tuple[int, int], ...]
    """Number of tries and seed of the objects of each round."""


def practise(
    level: str | GraspConfig,
    tries: int,
    seed: int,
    columns: tuple[int, ...] | None = None,
    progress: Callable[[int], object] | None = None,
) -> Practice:
    """Try places on fresh objects of a level, one try an object, and learn from the results alone.

    Args:
        level: a level with surfaces.
        tries: number of tries.
        seed: seed of objects, places and networks.
        columns: features that the network sees; None for all.
        progress: called with the number of tries just done.
    """
    network, rng = PlaceNetwork(columns), np.random.default_rng([seed, 2])
    rounds = tuple((size, 1000 * (seed + 1) + k) for k, size in enumerate(_rounds(tries)))
    practice = Practice(
        network, np.empty((0, len(NAMES))), np.empty(0), np.empty(0, bool), np.empty((0, 2), int), rounds
    )
    for k, (size, own) in enumerate(rounds, 1):
        scenes = Scenes.draw(level, size, own)
        features = place_features(scenes.images, scenes.radius)
        rows = _choose(features, network, rng)
        tried = scenes.try_places(features.places()[rows])
        practice = replace(
            practice,
            values=np.concatenate([practice.values, features.values[rows]]),
            worth=np.concatenate([practice.worth, tried.worth]),
            held=np.concatenate([practice.held, tried.held]),
            pixel=np.concatenate([practice.pixel, features.pixel[rows]]),
        )
        steps = STEPS if k == len(rounds) else QUICK_STEPS
        network.fit(practice.values, practice.worth, seed, steps)
        if progress is not None:
            progress(size)
    return practice


def worth_maps(features: PlaceFeatures, network: PlaceNetwork) -> Floats:
    """Expected worths of tries in pictures (N, 48, 48), averaged over the error of the cup's place."""
    return blur_maps(features.maps(network.predict(features.values), 0.0))


def network_places(features: PlaceFeatures, network: PlaceNetwork) -> Floats:
    """The places with the highest expected worths (N, 2) [m]."""
    return best_places(worth_maps(features, network))


def _rounds(tries: int) -> list[int]:
    """Numbers of tries between fits; the first ones are random."""
    first = max(int(RANDOM * tries), min(tries, 100))
    remaining = tries - first
    return [first, *[min(ROUND, remaining - k) for k in range(0, remaining, ROUND)]]


def _choose(features: PlaceFeatures, network: PlaceNetwork, rng: np.random.Generator) -> Ints:
    """Rows of one place in each picture (N,): random without a fit, else mostly by the softmax of the worths."""
    # The largest of scores with Gumbel noise is a draw from their softmax.
    score = rng.gumbel(size=len(features.picture))
    if network.is_fitted:
        maps = worth_maps(features, network)
        worth = maps[features.picture, features.pixel[:, 0], features.pixel[:, 1]]
        learned = rng.random(features.pictures) >= EXPLORES
        score += learned[features.picture] * worth / TEMPERATURE
    return features.best_rows(score)
