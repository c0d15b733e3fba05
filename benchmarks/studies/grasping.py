"""Where a cup holds: rules, networks that learned from tries, and an oracle, on the same objects; without a throw."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, Final

import numpy as np

from agents.grasping.fcn import PlaceMaps, input_maps, learn_maps
from agents.grasping.features import SIGHTS, PlaceFeatures, place_features
from agents.grasping.practice import Practice, network_places, practise
from agents.grasping.rules import COLOURED, TUNED, centroid_places, flattest_places, oracle_places, rule_places
from agents.grasping.scenes import Scenes, Tries
from agents.grasping.tuning import DEPTH_SETTINGS, colour_settings, tune
from agents.ground.metrics import wilson
from benchmarks.studies.cells import Amount, Figures, Settings
from pnt_gym.arrays import Floats

PLACES: Final[dict[str, Callable[[Scenes, PlaceFeatures], Floats]]] = {
    "centre": lambda scenes, features: np.zeros_like(scenes.middle),
    "centroid": lambda scenes, features: centroid_places(features),
    "flattest, naive": lambda scenes, features: flattest_places(features),
    "flattest, tuned": lambda scenes, features: rule_places(features, TUNED),
    "flattest, tuned with colour": lambda scenes, features: rule_places(features, COLOURED),
    "oracle": lambda scenes, features: oracle_places(scenes),
}
"""Rules, and the oracle, by their names in a plan."""


@cache
def _scenes(level: str, amount: Amount) -> tuple[Scenes, PlaceFeatures]:
    """The objects on which all are judged, and the features of their pictures."""
    scenes = Scenes.draw(level, amount.throws, amount.seed)
    return scenes, place_features(scenes.images, scenes.radius)


@cache
def _practice(tries: int, seed: int, sees: str) -> Practice:
    """A network that learned on seen kinds."""
    return practise("grasp", tries, seed, SIGHTS[sees])


def place(settings: Settings, amount: Amount) -> Figures:
    """Tries at the places of a rule.

    Args:
        settings: `kinds`, a level with surfaces; `place`, one of `PLACES`.
        amount: objects.
    """
    scenes, features = _scenes(settings["kinds"], amount)
    return _figures(scenes, scenes.try_places(PLACES[settings["place"]](scenes, features)))


def network(settings: Settings, amount: Amount) -> Figures:
    """Tries at the places of a network that learned from tries on seen kinds.

    Args:
        settings: `kinds`; `tries`; `seed` of the tries; `sees`, one of `SIGHTS`.
        amount: objects.
    """
    practice = _practice(settings["tries"], settings["seed"], settings["sees"])
    scenes, features = _scenes(settings["kinds"], amount)
    places = network_places(features, practice.network)
    last = practice.held[-settings["tries"] // 5 :]
    return {**_figures(scenes, scenes.try_places(places)), "held_in_last_tries": float(last.mean())}


@cache
def _maps(tries: int, seed: int, with_features: bool, epochs: int) -> PlaceMaps:
    """A fully convolutional network, fitted to the tries of a practice on seen kinds."""
    practice = _practice(tries, seed, "all")
    return learn_maps(practice, "grasp", with_features=with_features, seed=seed, epochs=epochs)


def pixels(settings: Settings, amount: Amount) -> Figures:
    """Tries at the places of a fully convolutional network, fitted to the same tries as `network`.

    Args:
        settings: `kinds`; `tries`; `seed`; `with_features`, whether the network sees the features of places beside the
            pixels; `epochs` of the fit.
        amount: objects.
    """
    scenes, features = _scenes(settings["kinds"], amount)
    network = _maps(settings["tries"], settings["seed"], settings["with_features"], settings["epochs"])
    maps = input_maps(scenes.images, scenes.radius, features if settings["with_features"] else None)
    return _figures(scenes, scenes.try_places(network.places(maps, features)))


def tuning(settings: Settings, amount: Amount) -> Figures:
    """The settings of the rules that tries choose, first without colour, then with colour.

    Args:
        settings: `tries` of each choice; `seed`.
        amount: nothing of it.
    """
    depth = tune("grasp", DEPTH_SETTINGS, settings["tries"], settings["seed"])
    colour = tune("grasp", colour_settings(depth), settings["tries"], settings["seed"] + 1)
    return {"tuned": list(depth), "coloured": list(colour)}


def _figures(scenes: Scenes, tries: Tries) -> dict[str, Any]:
    """Shares of tries, with the interval of what is held, and by kind."""
    count, held = len(tries.held), wilson(int(tries.held.sum()), len(tries.held))
    return {
        "count": count,
        "held": held.value,
        "held_low": held.low,
        "held_high": held.high,
        "kept": float(tries.kept.mean()),
        "worth": float(tries.worth.mean()),
        "held_by_kind": {
            name: float(tries.held[scenes.objects.kind == k].mean()) for k, name in enumerate(scenes.config.items)
        },
    }
