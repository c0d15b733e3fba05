"""The network that foretells the gauge with attention to earlier tries of a shift."""

from typing import Any

import numpy as np
import pytest

from agents.grasping.attention import INPUTS, KINDS, LABEL, LOOKS, Shown, TryMemory, TryNetwork, show_tries
from agents.grasping.foretelling import Foretold, Straight
from pnt_gym.cells.grasp.config import GraspConfig

PLACES = 6


def of_hidden_kinds(kinds: int, each: int) -> Shown:
    """Objects of kinds that differ in looks, and in what the gauge reads where the first number is high."""
    random = np.random.default_rng(0)
    kind = np.repeat(np.arange(kinds), each)
    inputs = random.standard_normal((len(kind), PLACES, INPUTS))
    inputs[:, :, -LOOKS:] = (10.0 * random.standard_normal((kinds, LOOKS)))[kind][:, None]
    inputs[:, :, LABEL] = 0.5
    leaks = random.choice([-0.4, 0.4], kinds)[kind]
    label = 0.5 + np.where(inputs[:, :, 0] > 0.0, leaks[:, None], 0.0)
    return Shown(kind, inputs.astype(np.float32), label.astype(np.float32))


@pytest.fixture(scope="module")
def fitted() -> TryNetwork:
    network = TryNetwork()
    network.fit(of_hidden_kinds(200, 8), 0, 400)
    return network


@pytest.mark.nightly
def test_tries_of_a_kind_tell_where_it_leaks(fitted: TryNetwork) -> None:
    shown, errors = of_hidden_kinds(400, 8), {0: list[float](), 7: list[float]()}
    for first in range(200 * 8, 260 * 8, 8):  # of kinds that were not learned
        places, label = shown.inputs[first].astype(float), shown.label[first]
        for known, kept in errors.items():
            tried = shown.inputs[first + 1 : first + 1 + known, :2].reshape(-1, INPUTS).astype(float)
            surprise = shown.surprise[first + 1 : first + 1 + known, :2].reshape(-1).astype(float)
            kept.append(float(np.abs(fitted.predict(places, tried, surprise) - label).mean()))
    assert np.mean(errors[0]) > 0.15  # a guess of 0.5 is off by 0.4 at every second place
    assert np.mean(errors[7]) < 0.6 * np.mean(errors[0])


def test_the_first_try_of_a_shift_needs_no_other(fitted: TryNetwork) -> None:
    label = fitted.predict(np.zeros((3, INPUTS)), np.zeros((0, INPUTS)), np.zeros(0))
    assert label.shape == (3,)
    assert ((label > 0.0) & (label < 1.0)).all()


def test_a_file_keeps_the_network(fitted: TryNetwork) -> None:
    again, random = TryNetwork(), np.random.default_rng(1)
    again.restore(fitted.state())
    arrays = random.standard_normal((5, INPUTS)), random.standard_normal((4, INPUTS)), random.standard_normal(4)
    np.testing.assert_array_equal(again.predict(*arrays), fitted.predict(*arrays))
    grid = np.linspace(0.0, 1.0, 11)
    np.testing.assert_array_equal(again.table.held(grid), fitted.table.held(grid))
    assert again.table.held(np.array([0.95]))[0] > again.table.held(np.array([0.05]))[0]


def test_tries_of_a_row_are_its_own_until_its_shift_ends() -> None:
    memory = TryMemory(2, 3)
    for k in range(4):  # the last place is written anew when there are more than three
        memory.add(0, np.full(INPUTS, float(k)), 0.1 * k)
    memory.add(1, np.full(INPUTS, 9.0), 0.5)
    np.testing.assert_allclose(memory.of_row(0)[1], [0.0, 0.1, 0.3])
    np.testing.assert_array_equal(memory.of_row(1)[0], np.full((1, INPUTS), 9.0))
    memory.begin(np.array([0]))
    assert [len(memory.of_row(row)[1]) for row in (0, 1)] == [0, 1]


def test_simulated_tries_read_what_the_regression_foretells_on_average() -> None:
    level: Any = GraspConfig.load({"base": "grasp_shift", "drawn": {"kinds": 40, "seed": 1}})
    foretold = Foretold(Straight())
    foretold.practise(level, 600, seed=0)
    shown = show_tries(level, foretold, 80, 1)
    assert shown.inputs.shape[0] == len(shown.kind) == len(shown.label) > 60
    assert abs(shown.surprise.mean()) < 0.1
    assert shown.surprise.std() < shown.label.std()
    half = shown.label.shape[1] // 2
    assert shown.inputs[:, half:, LABEL].mean() > shown.inputs[:, :half, LABEL].mean()
    same = shown.inputs[:, :, -LOOKS:] == shown.inputs[:, :1, -LOOKS:]
    assert same.all()
    assert KINDS < len(np.unique(shown.kind)) <= 40
