"""Where a cup holds: rules, networks that learned from tries, and an oracle; and what they sort."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final, cast

import numpy as np

from agents.grasping.features import SIGHTS, PlaceFeatures, place_features
from agents.grasping.practice import Practice, network_places, practise
from agents.grasping.rules import PLACES
from agents.grasping.scenes import Scenes, Tries, with_drawn_kinds
from agents.grasping.tuning import FREE, PlaceTable, tune
from agents.ground.metrics import rate, rate_difference, throughput, wilson
from agents.judging import trials
from agents.judging.evaluation import open_cells
from agents.judging.throw_record import ThrowRecord
from agents.judging.throws import Throws
from agents.results.study import Amount, Figures, Settings
from pnt_gym.arrays import Floats, concatenate_records, take
from pnt_gym.cells.grasp.config import GraspConfig
from pnt_gym.cells.grasp.images import draw_images
from pnt_gym.cells.grasp.surfaces import surface_table

ENV: Final = "PnTGrasp-v0"
CELLS: Final = 64
"""Rows side by side; a part of what a seed means."""
PRACTISED: Final = 5_000_000
"""Offset of the seeds of the objects on which rules are tuned."""


@cache
def _scenes(level: str, amount: Amount) -> tuple[Scenes, PlaceFeatures]:
    """The objects on which all are judged, and the features of their pictures."""
    scenes = Scenes.draw(level, amount.throws, amount.seed)
    return scenes, place_features(scenes.images, scenes.radius)


@cache
def _practice(tries: int, seed: int, sees: str, drawn: int = 0) -> Practice:
    """A network that learned on seen kinds, and on kinds that are drawn at random."""
    return practise(with_drawn_kinds("grasp", drawn, seed), tries, seed, SIGHTS[sees])


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
        settings: `kinds`; `tries`; `seed` of the tries; `sees`, one of `SIGHTS`; `drawn`, the number of further kinds.
        amount: objects.
    """
    practice = _practice(settings["tries"], settings["seed"], settings["sees"], settings.get("drawn", 0))
    scenes, features = _scenes(settings["kinds"], amount)
    places = network_places(features, practice.network)
    last = practice.held[-settings["tries"] // 5 :]
    return {**_figures(scenes, scenes.try_places(places)), "held_in_last_tries": float(last.mean())}


def tuning(settings: Settings, amount: Amount) -> Figures:
    """The weights of a rule that tries choose, and what the rule's tries are worth on other objects.

    Args:
        settings: `objects` on which every setting is tried; `sees`, depth or colour; `seed` of objects and search.
        amount: objects on which the choice is judged, of seen and of unseen kinds.
    """
    table = _table("grasp", settings["objects"], PRACTISED + settings["seed"])
    weights = tune(table, FREE[settings["sees"]], settings["seed"])
    judged = {"seen": "grasp", "unseen": "grasp_unseen"}
    worths = {name: _table(level, amount.throws, amount.seed).worths(weights) for name, level in judged.items()}
    return {
        "practised": float(table.worths(weights).mean()),
        **{name: estimate(worth) for name, worth in worths.items()},
        **weights._asdict(),
    }


@cache
def _table(level: str, objects: int, seed: int) -> PlaceTable:
    """The places of objects and what tries there are worth."""
    return PlaceTable.draw(level, objects, seed)


def estimate(values: Floats) -> Figures:
    """The mean of values (N,) with its 95 % interval."""
    value, half = float(values.mean()), 1.96 * float(values.std()) / len(values) ** 0.5
    return {"value": value, "low": value - half, "high": value + half}


def camera(settings: Settings, amount: Amount) -> Figures:
    """Tries at the places of a rule, and of a network, in pictures with or without the camera's noise.

    Args:
        settings: `kinds`; `is_noisy`; `tries`, `seed` and `sees` of the network, or `place`, one of `PLACES`.
        amount: objects.
    """
    scenes, features = _scenes(settings["kinds"], amount)
    if not settings["is_noisy"]:
        middles, pairs = scenes.middle[:, None], take(scenes.objects, np.s_[:, None])
        images = draw_images(surface_table(scenes.config.item_list()), pairs, middles)
        features = place_features(images, scenes.radius)
    if settings["place"] != "network":
        return _figures(scenes, scenes.try_places(PLACES[settings["place"]](scenes, features)))
    learned = _practice(settings["tries"], settings["seed"], settings["sees"])
    return _figures(scenes, scenes.try_places(network_places(features, learned.network)))


def thrown(settings: Settings, amount: Amount) -> Figures:
    """What a controller sorts, over the seeds of its learning, and its gain on a reference on the same objects.

    Args:
        settings: `level`; `controller` and its `options`; `seeds` of the learning; `learned`, the `tries`, `sees` and
            `drawn` of a network; `practice`, the throws from which the residual is learned; `cups`, a factor on the
            radii of all cups; `reference`, a controller.
        amount: picks of each seed.
    """
    level = with_cups(settings["level"], settings.get("cups", 1.0))
    runs = [_throws_of(settings, level, seed, amount) for seed in range(settings.get("seeds", 1))]
    throws = concatenate_records(runs)
    sorted_share, seconds = (np.mean([getattr(run, name) for run in runs], axis=0) for name in ("sorted", "cycle_time"))
    figures = {
        "rate": asdict(rate(sorted_share, seconds)),
        "sorted_per_min": throughput(throws.sorted, throws.cycle_time).sorted,
        "success": float(throws.sorted.mean()),
        "held": float(throws.picked.mean()),
        "dropped": float(throws.info["dropped"][throws.picked].mean()),
        "tries_a_pick": float(throws.info["tries"].mean()),
        "landing_error_m": float(np.nanmean(throws.landing_error)),
    }
    if "reference" not in settings:
        return figures
    reference = _throws(json.dumps(level), settings["reference"], "{}", 0, 0, amount)
    gain = rate_difference(sorted_share, seconds, reference.sorted, reference.cycle_time)
    return {**figures, "gain": asdict(gain)}


def with_cups(level: Mapping[str, Any], factor: float) -> dict[str, Any]:
    """A level whose cups have radii by a factor, as far as the items are wide; forces go with the areas."""
    if factor == 1.0:
        return dict(level)
    config, kinds = GraspConfig.load(dict(level)), list[dict[str, Any]]()
    for item in config.item_list():
        radius = min(factor * item.fitted_radius, item.width / 2.0)
        assert item.seal_force is not None  # or a suction cup could not hold the item
        force = item.seal_force * (radius / item.fitted_radius) ** 2
        kinds.append({"name": f"{item.name}_cup", "like": item.name, "cup_radius": radius, "seal_force": force})
    return {**level, "items": [kind["name"] for kind in kinds], "extra_items": kinds}


def _throws_of(settings: Settings, level: Mapping[str, Any], seed: int, amount: Amount) -> Throws:
    """Throws of a controller that learned with a seed."""
    options, practice = dict(settings.get("options", {})), settings.get("practice", 0)
    controller, learned = settings["controller"], settings.get("learned")
    if learned is None:
        return _throws(json.dumps(level), controller, json.dumps(options), practice, seed, amount)
    with TemporaryDirectory() as folder:
        file = Path(folder) / "network.npz"
        _practice(learned["tries"], seed, learned["sees"], learned["drawn"]).network.save(file)
        options = json.dumps({**options, "file": str(file)})
        return _throws(json.dumps(level), controller, options, practice, seed, amount)


@cache
def _throws(level: str, controller: str, options: str, practice: int, seed: int, amount: Amount) -> Throws:
    """Throws of a controller after its practice; level and options as JSON, which can be remembered."""
    config = GraspConfig.load(json.loads(level))
    with open_cells(ENV, {"level": config, "num_envs": CELLS, "threads": 1}) as cells:
        trial = trials.of(cells)
        actor = trial.controller(controller, **json.loads(options))
        actor.reset(seed)
        actor = trial.practise(actor, practice, seed)
        return cast("ThrowRecord", trial.run(actor, amount.throws, amount.seed)).throws


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
