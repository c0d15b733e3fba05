"""Kinds that are drawn for training."""

import numpy as np

from agents.grasping.practice import practise
from agents.grasping.scenes import Scenes, with_drawn_kinds


def test_drawn_kinds_stand_beside_those_of_the_level_and_are_those_of_the_seed():
    first, again, other = (with_drawn_kinds("grasp", 30, seed) for seed in (1, 1, 2))
    own = with_drawn_kinds("grasp", 0, 1).items
    assert first.items[: len(own)] == own
    assert len(first.items) == len(own) + 30
    assert first == again
    assert first.item_list()[-1] != other.item_list()[-1]


def test_drawn_kinds_are_of_all_shapes_and_their_porous_zones_are_matte():
    kinds = with_drawn_kinds("grasp", 60, 0).item_list()[14:]
    assert {kind.shape for kind in kinds} == {"box", "cylinder", "ellipsoid"}
    assert 5 < sum(kind.relief is not None for kind in kinds) < 50
    zones = [zone for kind in kinds for zone in kind.zones if zone.leak is not None]
    assert min(zone.leak for zone in zones) < 1.0 < max(zone.leak for zone in zones)
    assert all((zone.leak > 1.0) == (zone.look[2] < 0.25) for zone in zones)


def test_cups_hold_some_places_of_drawn_kinds_and_not_others():
    scenes = Scenes.draw(with_drawn_kinds("grasp", 60, 0), 600, seed=3)
    drawn = scenes.objects.kind >= 14
    held = scenes.try_places(np.zeros((600, 2))).held
    assert 0.3 < held[drawn].mean() < 0.95


def test_networks_learn_from_drawn_kinds(monkeypatch):
    for name in ("STEPS", "QUICK_STEPS"):
        monkeypatch.setattr(f"agents.grasping.practice.{name}", 10)
    practice = practise(with_drawn_kinds("grasp", 5, 0), 120, 0)
    assert practice.network.is_fitted
    assert len(practice.worth) == 120
