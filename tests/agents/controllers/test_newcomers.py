"""Kinds that nobody has practised, against throws on paper with a known truth."""

import numpy as np
import pytest

from agents.controllers import filters
from agents.controllers.filters import BIN_CAMERA, NOISE, Filters, landing_noise
from agents.controllers.trackers import UnseenKinds, delay_effect, drift_effects
from pnt_gym.cells.conveyor.observation import TABLE
from tests.agents.controllers.test_trackers import CAMERA, everyone, noise, throws

ROWS = 300
KNOWN = np.array([True, False, False])


def late(thrown: np.ndarray, seconds: float) -> np.ndarray:
    return np.stack([seconds * delay_effect(TABLE.decode(thrown)), np.zeros(len(thrown))], axis=1)


def after(count: int, seconds: float) -> UnseenKinds:
    """Somebody who has seen so many throws of kind 1, which lets go late, in every row."""
    newcomers, kind = UnseenKinds(KNOWN), np.full(ROWS, 1)
    for pick in range(count):
        thrown = throws(ROWS, pick)
        newcomers.learn(kind, thrown, late(thrown, seconds) + noise(ROWS, pick), everyone(ROWS))
    return newcomers


def test_lateness_is_the_effect_of_a_valve_that_lets_go_late() -> None:
    np.testing.assert_array_equal(delay_effect(TABLE.decode(throws(20))), drift_effects(throws(20), CAMERA)[:, 0, 0])


def test_a_kind_that_clings_is_understood_after_three_throws() -> None:
    """Better than any mean landing could: what a late release does differs from throw to throw."""
    fresh = throws(ROWS, 999)
    error = after(3, 0.012).effect(np.full(ROWS, 1), fresh) - late(fresh, 0.012)
    mean_of_three = np.hypot(*NOISE) / np.sqrt(3.0)
    assert np.sqrt(np.square(error).sum(axis=1).mean()) < 1.1 * mean_of_three
    many = after(40, 0.012).effect(np.full(ROWS, 1), fresh) - late(fresh, 0.012)
    assert np.sqrt(np.square(many).sum(axis=1).mean()) < 0.5 * mean_of_three


def test_a_kind_that_is_as_the_others_is_left_alone() -> None:
    """What few throws scatter is not taken for what the kind is off by."""
    off = after(3, 0.0).effect(np.full(ROWS, 1), throws(ROWS, 999))
    assert np.sqrt(np.square(off).sum(axis=1).mean()) < 0.75 * np.hypot(*NOISE) / np.sqrt(3.0)


def test_other_kinds_other_rows_and_kinds_that_are_known_feel_nothing() -> None:
    newcomers, thrown, rows = UnseenKinds(KNOWN), throws(4), np.array([True, True, True, False])
    newcomers.learn(np.array([0, 1, 1, 1]), thrown, np.full((4, 2), 0.03), rows)
    kinds = np.arange(3)[:, None] * np.ones(4, dtype=np.int64)
    off = np.array([newcomers.effect(kind, thrown) for kind in kinds])
    assert not off[0].any()
    assert not off[2].any()
    assert (off[1, 1:3, 0] > 0.005).all()
    assert not off[1, [0, 3]].any()
    assert newcomers.is_unseen(np.array([0, 1, 2])).tolist() == [False, True, True]


def test_another_number_of_rows_is_another_place() -> None:
    newcomers = after(2, 0.012)
    assert not newcomers.effect(np.full(5, 1), throws(5)).any()


@pytest.mark.parametrize("unknowns", [1, 3])
def test_an_update_is_that_of_bayes(unknowns: int) -> None:
    """Against the posterior of a joint normal distribution, written down as one."""
    random = np.random.default_rng(0)
    effect, z = random.normal(0.0, 1.0, (1, 2, unknowns)), np.array([[0.002, -0.001]])
    spread, covariance = np.diag(random.uniform(0.5, 2.0, unknowns)) * 1e-4, np.diag(np.square(NOISE))
    state, left, likely = filters.update(np.zeros((1, unknowns)), spread[None], effect, z, covariance)
    precision = np.linalg.inv(spread) + effect[0].T @ np.linalg.inv(covariance) @ effect[0]
    np.testing.assert_allclose(left[0], np.linalg.inv(precision), rtol=1e-9)
    np.testing.assert_allclose(state[0], left[0] @ effect[0].T @ np.linalg.inv(covariance) @ z[0], rtol=1e-9)
    joint = effect[0] @ spread @ effect[0].T + covariance
    density = -0.5 * (np.log(np.linalg.det(joint)) + z[0] @ np.linalg.inv(joint) @ z[0])
    assert likely[0] == pytest.approx(density, rel=1e-9)


def test_what_each_filter_counts_is_how_it_foresaw() -> None:
    """Two sizes of the unknown: landings that are far off speak for the wide one, near ones for the narrow one."""
    priors, there = np.array([[[1e-6]], [[1e-3]]]), np.arange(2)
    filters = Filters((2,), priors, (0.5, 0.5), noise=landing_noise(BIN_CAMERA))
    filters.learn(there, np.ones((2, 1, 2, 1)), np.array([[[0.001, 0.001]], [[0.03, 0.03]]]))
    assert filters.belief[0, 0] > 0.6
    assert filters.belief[1, 1] > 0.9
    np.testing.assert_allclose(filters.belief.sum(axis=1), 1.0)
    filters.begin(np.array([1]))
    np.testing.assert_array_equal(filters.belief[1], [0.5, 0.5])
    assert not filters.estimate(there)[1].any()
    assert filters.estimate(there)[0] != 0.0
