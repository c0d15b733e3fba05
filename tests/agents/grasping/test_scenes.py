"""Tries without a robot: what is held, what would be kept, and what an oracle expects."""

from dataclasses import replace

import numpy as np
import pytest

from agents.grasping.features import best_places, blur_maps
from agents.grasping.rules import surface_places
from agents.grasping.scenes import HELD, Scenes
from pnt_gym.cells.grasp.images import pixel_places
from tests.tools.throws import same_bits


@pytest.fixture(scope="module")
def scenes():
    return Scenes.draw("grasp", 300, seed=4)


def test_scenes_are_a_function_of_their_seed(scenes):
    again = Scenes.draw("grasp", 300, seed=4)
    assert same_bits(again.images, scenes.images)
    assert same_bits(again.error, scenes.error)
    assert not same_bits(Scenes.draw("grasp", 300, seed=5).images, scenes.images)


def test_what_is_kept_is_held_and_worth_the_most(scenes):
    tries = scenes.try_places(np.zeros((300, 2)))
    assert not (tries.kept & ~tries.held).any()
    assert set(tries.worth.round(9)) == {0.0, HELD, 1.0}
    assert same_bits(tries.worth == 1.0, tries.held & tries.allowed)
    assert tries.kept[tries.held & tries.allowed].mean() > 0.9  # what sensors allow is nearly always kept
    assert 0.6 < tries.held.mean() < 0.9


def test_labels_are_those_of_gauge_and_scales(scenes):
    """What is hidden of an object under a cup that holds it changes no label."""
    objects, places = scenes.objects, np.zeros((300, 2))
    hidden = {"cup_friction": 0.1 * objects.cup_friction, "com_depth": 3.0 * objects.com_depth}
    other = replace(scenes, objects=objects.replace(**hidden))
    tries, others = (one.try_places(places) for one in (scenes, other))
    assert same_bits(tries.worth, others.worth)
    assert not same_bits(tries.kept, others.kept)


def test_worths_of_tries_at_many_places_are_those_of_single_tries(scenes):
    rows = np.repeat(np.arange(300), 3)
    places = np.random.default_rng(1).normal(0.0, 0.01, (900, 2))
    worths = scenes.worths_of_tries(rows, places)
    for k in range(3):
        assert same_bits(worths[k::3], scenes.try_places(places[k::3]).worth)


def test_nothing_is_held_beside_an_object(scenes):
    beside = scenes.middle - scenes.error + [0.2, 0.0]
    assert not scenes.try_places(beside).held.any()


def test_expected_worth_is_the_mean_of_tries(scenes):
    """Over the luck of the tries, at the same true place."""
    rng = np.random.default_rng(0)
    places = scenes.middle - scenes.error + rng.normal(0.0, 0.01, (300, 2))
    expected = scenes.worth((places - scenes.middle + scenes.error)[:, None])[:, 0]
    tries = scenes.try_places(places)
    worth = np.where(tries.held, np.where(tries.kept, 1.0, HELD), 0.0)
    assert worth.mean() == pytest.approx(expected.mean(), abs=0.03)
    assert 0.5 < expected.mean() < 0.9


def test_the_true_surface_holds_more_than_the_middle(scenes):
    known, middle = (scenes.try_places(places).worth.mean() for places in (surface_places(scenes), np.zeros((300, 2))))
    assert known > middle + 0.08


def test_parts_are_the_scenes_in_order(scenes):
    parts = list(scenes.parts(128))
    assert [len(part.images) for part in parts] == [128, 128, 44]
    assert same_bits(np.concatenate([part.middle for part in parts]), scenes.middle)
    assert same_bits(parts[2].objects.mass, scenes.objects.mass[256:])


def test_a_blurred_map_is_the_mean_over_errors():
    maps = np.random.default_rng(0).random((2, 48, 48))
    blurred, reach = blur_maps(maps, (0.004, 0.006)), np.arange(-9, 10)
    across, along = (np.exp(-0.5 * (0.005 * reach / deviation) ** 2) for deviation in (0.004, 0.006))
    across[np.abs(reach) > 3], along[np.abs(reach) > 4] = 0.0, 0.0  # three deviations, in pixels rounded up
    weights = np.outer(across / across.sum(), along / along.sum())
    expected = (weights * maps[1, 20 - 9 : 20 + 10, 30 - 9 : 30 + 10]).sum()
    assert blurred[1, 20, 30] == pytest.approx(expected, rel=1e-12)
    point = np.zeros((1, 48, 48))
    point[0, 7, 40] = 1.0
    np.testing.assert_allclose(best_places(blur_maps(point))[0], pixel_places()[7, 40])
