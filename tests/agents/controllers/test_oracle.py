"""The oracle: it finds the root of whatever a throw answers, and knows when to stop."""

from collections.abc import Callable
from contextlib import closing
from types import SimpleNamespace

import numpy as np
import pytest

from agents.controllers import make_controller
from agents.controllers.oracle import Oracle
from agents.ground.environments import make_vector
from agents.judging.loop import throw_held_out
from agents.judging.throw_record import summary
from tests.tools.toy_cell import POSE, ToyVectorEnv, observation_of

Answer = Callable[[np.ndarray], np.ndarray]
"""Actions (N, 4) to errors (N, 4), both in actions."""


class Told:
    """A core whose throws answer as they are told to, and that counts how often it is asked."""

    correction = POSE

    def __init__(self, answer: Answer) -> None:
        self._answer, self.asked = answer, 0

    def preview(self, actions: np.ndarray, *, jitter: bool = False) -> SimpleNamespace:
        assert not jitter
        assert (np.abs(actions) <= 1.0).all()
        self.asked += 1
        error = self._answer(actions.astype(np.float64)) * POSE.scale
        return SimpleNamespace(**dict(zip(POSE.errors, error.T, strict=True)))


def solved(answer: Answer, throws: int = 16) -> tuple[np.ndarray, int]:
    """Actions (N, 4) of the oracle, and previews it took."""
    core = Told(answer)
    oracle = Oracle(core, POSE)  # pyright: ignore[reportArgumentType]
    actions = oracle.act(observation_of(np.zeros((throws, 5))))
    assert actions.dtype == np.float32
    return actions, core.asked


WANTED = np.random.default_rng(1).uniform(-0.4, 0.4, (16, 4))


@pytest.mark.parametrize(
    ("gain", "most"), [(1.0, 2), (0.5, 8), (1.8, 8), (2.5, 12), (-0.5, 12)], ids=lambda value: f"{value:g}"
)
def test_any_gain_is_found(gain: float, most: int) -> None:
    """A fixed point with gain 1 crawls at 0.5, swings at 1.8, and runs away beyond 2 and below 0."""
    actions, previews = solved(lambda shift: gain * (shift - WANTED))
    np.testing.assert_allclose(actions, WANTED, atol=0.01)
    assert previews <= most


def test_numbers_that_move_each_other_and_bend_are_found() -> None:
    mix = np.eye(4) + 0.6 * np.random.default_rng(2).standard_normal((4, 4))

    def answer(shift: np.ndarray) -> np.ndarray:
        moved = shift - WANTED
        return moved @ mix.T + 0.3 * np.roll(moved, 1, axis=1) ** 2

    actions, previews = solved(answer)
    assert np.abs(answer(actions.astype(np.float64))).max() < 0.02
    assert previews <= 25


def test_what_lies_beyond_an_action_ends_at_its_edge() -> None:
    wanted = np.where(np.arange(4) == 0, 1.5, WANTED)
    actions, _ = solved(lambda shift: shift - wanted)
    np.testing.assert_allclose(actions, np.clip(wanted, -1.0, 1.0), atol=0.02)


def test_a_throw_that_is_not_measured_tries_elsewhere() -> None:
    def answer(shift: np.ndarray) -> np.ndarray:
        unseen = (np.abs(shift) < 0.005).all(axis=1, keepdims=True)
        return np.where(unseen, np.nan, shift - WANTED)

    actions, _ = solved(answer)
    np.testing.assert_allclose(actions, WANTED, atol=0.02)


def test_what_is_never_measured_is_thrown_as_planned() -> None:
    actions, previews = solved(lambda shift: np.full_like(shift, np.nan))
    assert not actions.any()
    assert previews < 25


def test_errors_are_weighed_by_their_tolerances() -> None:
    """The second action halves the error in plain numbers, but is worse in tolerances: the first one is kept."""
    first, second = [0.004, 0.0, 0.0, 0.2], [0.030, 0.0, 0.0, 0.1]
    actions, _ = solved(lambda shift: np.where(shift.any(axis=1, keepdims=True), second, first) / POSE.scale)
    assert not actions.any()


def test_equal_seeds_look_at_the_same_throws() -> None:
    def rugged(shift: np.ndarray) -> np.ndarray:
        return shift - WANTED + 0.3 * np.sin(40.0 * shift)

    np.testing.assert_array_equal(solved(rugged)[0], solved(rugged)[0])


def test_it_leaves_the_noise() -> None:
    env = ToyVectorEnv(8)
    error = summary(throw_held_out(make_controller("oracle", env), env, 400, 0))["landing_error_mean_m"]
    assert error < 0.003  # the toy's noise is 2 mm per axis


@pytest.mark.parametrize(
    ("env_id", "level", "least"),
    [
        pytest.param("OneJointThrow-v0", "contact", 0.5, marks=pytest.mark.nightly),
        (
            "PnTRelease-v0",
            {"base": "waste_plain", "limits": {"percent": [60]}, "action": {"along": 0.5, "across": 0.15}},
            0.9,
        ),
    ],
    ids=["contact", "60 %"],
)
def test_it_succeeds_where_errors_do_not_follow(env_id: str, level: str, least: float) -> None:
    with closing(make_vector(env_id, level, 24, threads=2)) as env:
        assert throw_held_out(make_controller("oracle", env), env, 24, 0).is_success.mean() >= least
