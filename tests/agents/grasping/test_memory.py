"""What is remembered of a shift of grasps: errors of the cup, and objects of a look."""

from typing import Any

import numpy as np
import pytest

from agents.grasping.foretelling import BINS, Foretold, Straight, labels
from agents.grasping.memory import LANDS, REACH, SIDE, Event, ShiftMemory, around, expected
from pnt_gym.cells.grasp.config import GraspConfig, Surface

LEVEL = {"base": "grasp_shift", "drawn": {"seed": 1}, "drift": {"camera": {"normal": 0.0}}}


def seen(off: tuple[float, float], direction: tuple[float, float] = (0.0, 1.0), **values: Any) -> Event:
    """An object that was held, thrown, and seen to land."""
    known = {"tried": True, "held": True, "thrown": True, "landed": True, "hit": True, **values}
    return Event.of(1, off=np.array([off]), direction=np.array([direction]), **known)


def test_means_over_errors_are_sums_over_shifted_maps() -> None:
    random = np.random.default_rng(0)
    maps, weights = random.random((3, 48, 48)), random.random((3, SIDE, SIDE))
    padded = np.pad(maps, [(0, 0), (REACH, REACH), (REACH, REACH)])
    direct = sum(
        weights[:, i, j, None, None] * padded[:, i : i + 48, j : j + 48] for i in range(SIDE) for j in range(SIDE)
    )
    np.testing.assert_allclose(expected(maps, weights), direct, atol=1e-9)


def test_windows_of_maps_lie_as_the_errors_do() -> None:
    """A cup that is sent to the middle and errs by 15 mm along the belt stands three pixels further along it."""
    memory, maps = ShiftMemory(1, 5, 0.01), np.zeros((1, 48, 48))
    maps[0, 20, 30] = 1.0
    place = np.array([[0.005 * (30 - 23.5) - 0.015, -0.005 * (20 - 23.5) + 0.010]])
    window = around(maps, place, 0.0)[0]
    np.testing.assert_allclose(memory.offsets[window > 0.5], [[0.015, -0.010]], atol=1e-12)


def test_readings_of_tries_find_the_error_of_the_cup() -> None:
    memory, rows = ShiftMemory(1, 5, 0.015), np.array([0])
    true = (REACH + 2, REACH - 3)
    before = memory.doubt(rows)
    for _ in range(3):
        likelihood = np.full((1, SIDE, SIDE), 0.2)
        likelihood[0, true[0], true[1]] = 0.9
        memory.watch(rows, likelihood)
    assert memory.weights(rows)[0, true[0], true[1]] > 0.3
    assert memory.doubt(rows) < before
    memory.begin(rows)
    np.testing.assert_array_equal(memory.weights(rows)[0], memory.first)


def test_landings_find_the_error_of_the_cup_across_the_throw() -> None:
    memory, rows = ShiftMemory(1, 40, 0.015), np.array([0])
    error = np.array([0.015, 0.0])
    for _ in range(30):  # thrown along y: left of the throw is against x
        memory.add(rows, np.zeros((1, 8)), seen((0.0, LANDS * error[0])))
    np.testing.assert_allclose(memory.error(rows)[0], error, atol=0.004)


def test_objects_of_a_look_are_recalled_and_others_are_not() -> None:
    memory, rows = ShiftMemory(1, 40, 1e-4), np.array([0])
    like, unlike = np.zeros((1, 8)), np.full((1, 8), 5.0)
    for _ in range(6):
        memory.add(rows, like, seen((-0.06, 0.0)))
        memory.add(rows, unlike, seen((0.0, 0.0), held=False, thrown=False, landed=False, hit=False))
    near, far = memory.recall(rows, like), memory.recall(rows, unlike)
    assert near.held[0] > 0.2 > -0.5 > far.held[0]
    assert near.along[0] == pytest.approx(-0.06 * 6.0 / 6.5, abs=0.002)
    assert abs(far.along[0]) < 1e-9
    assert near.columns().shape == (1, 9)
    memory.begin(rows)
    assert memory.recall(rows, like).tries[0] == 0.0


def test_labels_stand_for_the_vacuum_over_the_least_one() -> None:
    radius = np.full(3, 0.018)
    least = Surface().pressure * np.pi * radius[0] ** 2
    label = labels(np.array([0.0, least, 10.0 * least]), radius, Surface())
    np.testing.assert_allclose(label, [0.0, 0.5, 0.5 + np.log(10.0) / 6.0])


def test_a_regression_foretells_the_gauge_and_knows_how_well() -> None:
    foretold, random = Foretold(Straight()), np.random.default_rng(0)
    foretold.practise(GraspConfig.load(LEVEL), 600, seed=0)
    grid = (np.arange(BINS) + 0.5) / BINS
    held = foretold.table.held(grid)
    assert held[0] < 0.1
    assert held[6:9].mean() > 0.5
    read = random.random(4)
    shares = [foretold.table.likelihood(np.full((4, 2, 3), value), read) for value in grid]
    assert shares[0].shape == (4, 2, 3)
    again = Foretold(Straight())
    again.restore(foretold.state())
    np.testing.assert_array_equal(again.table.held(grid), held)
