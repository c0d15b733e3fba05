"""newton_goal where the error follows the shift, where it does not, and where a throw cannot be had."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.stats import norm

from agents.controllers.goals import virtual_goal
from agents.controllers.newton import NewtonGoal
from agents.controllers.protocol import Learner as LearnerProtocol
from agents.controllers.response import Response, gauss_newton, log_chance
from tests.tools.toy_cell import POSE, observation_of, outcome_of

Errors = Callable[[np.ndarray], np.ndarray]
"""Errors (N, 4) in tolerances of actions (N, 4)."""

BIAS = np.array([3.0, -2.0, 5.0, 1.0])
RATIO = POSE.scale / POSE.tolerance
TURNED = np.diag([1.0, 1.0, -1.2, 1.0]) + 0.3 * np.eye(4)[::-1]
"""What a shift does to the errors, both in tolerances: the third error runs the other way."""
ONE = observation_of(np.zeros((1, 5)))


def turned(action: np.ndarray) -> np.ndarray:
    return BIAS + (action * RATIO) @ TURNED.T


def bent(action: np.ndarray) -> np.ndarray:
    """The third error has its largest value at an action of -0.2: beyond, a higher goal makes it fall short more."""
    error = BIAS + action * RATIO
    error[:, 2] = 2.0 - 120.0 * (action[:, 2] + 0.2) ** 2 - 2.0 * action[:, 0]
    return error


def thrown(controller: LearnerProtocol, errors: Errors, batches: int, rows: int = 1, noise: float = 0.0) -> np.ndarray:
    """Throw batches into one cell and return the largest error of each throw's first row, in tolerances."""
    seen, random = observation_of(np.zeros((rows, 5))), np.random.default_rng(0)
    size = []
    for _ in range(batches):
        action = controller.act(seen)
        error = errors(action.astype(float)) + noise * random.standard_normal((rows, 4))
        controller.learn(outcome_of(seen, action, error * POSE.tolerance))
        size.append(np.abs(error[0]).max())
    return np.array(size)


def practised(errors: Errors, batches: int, rows: int = 1, noise: float = 0.0) -> tuple[NewtonGoal, np.ndarray]:
    """A controller after its practice, and how far its throws were off."""
    newton = NewtonGoal(POSE)
    newton.begin_practice(batches * rows)
    size = thrown(newton, errors, batches, rows, noise)
    newton.end_practice()
    return newton, size


def kept(controller: LearnerProtocol, errors: Errors) -> float:
    """Largest error of the shift that is kept, in tolerances and without noise."""
    return float(np.abs(errors(controller.act(ONE).astype(float))).max())


def test_the_first_step_is_that_of_the_virtual_goal_with_a_gain_of_one() -> None:
    newton, paper = NewtonGoal(POSE), virtual_goal(POSE, 1.0)
    for controller in (newton, paper):
        assert not controller.act(ONE).any()
        controller.learn(outcome_of(ONE, np.zeros((1, 4)), np.array([[0.03, -0.02, 0.2, 0.1]])))
    assert newton.act(ONE) == pytest.approx(paper.act(ONE), abs=1e-4)


@pytest.mark.parametrize("errors", [turned, bent])
def test_errors_that_run_the_other_way_are_learned_where_the_virtual_goal_runs_away(errors: Errors) -> None:
    newton, _ = practised(errors, 30)
    assert kept(newton, errors) < 1.0
    assert thrown(virtual_goal(POSE, 0.5), errors, 30)[-1] > 5.0


@pytest.mark.parametrize("rows", [1, 6])
def test_no_throw_is_spent_on_a_shift_of_which_the_correction_says_that_it_has_no_plan(rows: int) -> None:
    asked: list[np.ndarray] = []

    def low(features: np.ndarray, kind: int, shift: np.ndarray) -> np.ndarray:
        assert features.shape == (len(ONE.features[0]),)
        assert kind == ONE.kind[0]
        return shift[:, 0] <= 0.1

    def errors(action: np.ndarray) -> np.ndarray:
        asked.append(action.copy())
        return turned(action)

    newton = NewtonGoal(replace(POSE, possible=low))
    newton.begin_practice(30)
    thrown(newton, errors, 30 // rows, rows=rows)
    newton.end_practice()
    assert newton.act(ONE)[0, 0] <= 0.1 + 1e-6
    assert np.concatenate(asked)[:, 0].max() <= 0.1 + 1e-6
    assert len(np.unique(np.concatenate(asked), axis=0)) > 10


def test_without_practice_the_throws_themselves_become_good() -> None:
    size = thrown(NewtonGoal(POSE), turned, 20)
    assert size[0] > 4.0
    assert size[10:].min() < 0.5


def test_the_rows_of_a_batch_show_the_jacobian_at_once() -> None:
    newton, _ = practised(turned, 3, rows=16)
    assert kept(newton, turned) < 0.5


def test_rows_differ_in_practice_only() -> None:
    newton, seen = NewtonGoal(POSE), observation_of(np.zeros((6, 5)))
    thrown(newton, turned, 3, rows=6)
    assert len(np.unique(newton.act(seen), axis=0)) == 1
    newton.begin_practice(12)
    thrown(newton, turned, 1, rows=6)
    assert len(np.unique(newton.act(seen), axis=0)) == 6
    newton.end_practice()
    assert len(np.unique(newton.act(seen), axis=0)) == 1


def test_what_is_kept_is_as_good_as_the_best_throw() -> None:
    newton, first = practised(turned, 30)
    assert first.max() > 5.0
    assert thrown(newton, turned, 5).max() <= first.min() + 0.05


def test_newtons_shift_is_kept_where_the_map_is_sure_before_it_was_ever_thrown() -> None:
    newton, _ = practised(turned, 1, rows=16)
    shift = newton.act(ONE).astype(float)
    thrown_there = newton.state()["shift"]
    assert np.abs(shift - thrown_there).max(axis=1).min() > 0.01
    assert np.abs(turned(shift)).max() < 0.5


def test_scatter_is_averaged() -> None:
    newton, _ = practised(lambda action: BIAS + action * RATIO, 20, rows=16, noise=1.0)
    assert kept(newton, lambda action: BIAS + action * RATIO) < 0.8


def test_where_throws_are_refused_none_is_tried_again() -> None:
    """Half of all shifts has no plan; the goal lies just on the good side of the border."""
    newton, refused = NewtonGoal(POSE), []
    newton.begin_practice(30)
    for _ in range(30):
        action = newton.act(ONE)
        outcome = outcome_of(ONE, action, turned(action.astype(float)) * POSE.tolerance)
        outcome.clipped[:] = action[:, 2] < -0.05
        refused.append(bool(outcome.clipped[0]))
        newton.learn(outcome)
    newton.end_practice()
    assert refused[1]  # one to one, the first step leads there
    assert np.mean(refused[15:]) < 0.3
    assert newton.act(ONE)[0, 2] >= -0.05


def test_what_is_kept_can_be_had_though_the_map_promises_more_beyond() -> None:
    newton = NewtonGoal(POSE)
    newton.begin_practice(25)
    for _ in range(25):
        action = newton.act(ONE)
        outcome = outcome_of(ONE, action, (BIAS + action * RATIO) * POSE.tolerance)
        outcome.clipped[:] = action[:, 2] < -0.1  # the error is gone at -0.22
        newton.learn(outcome)
    newton.end_practice()
    assert -0.1 <= newton.act(ONE)[0, 2] < 0.0


def test_cells_are_kept_apart() -> None:
    newton = NewtonGoal(POSE)
    newton.learn(outcome_of(ONE, np.zeros((1, 4)), np.full((1, 4), 0.02)))
    both = newton.act(observation_of(np.zeros((2, 5)), np.array([0, 1])))
    assert both[0].any()
    assert not both[1].any()


@given(
    arrays(np.float64, (2, 3), elements=st.floats(-3.0, 3.0)),
    arrays(np.float64, (2, 3), elements=st.floats(0.05, 2.0)),
    st.floats(0.01, 2.0),
)
@settings(max_examples=60, deadline=None)
def test_the_chance_is_that_of_the_normal_distribution(error: np.ndarray, doubt: np.ndarray, bound: float) -> None:
    share = norm.cdf(bound, error, doubt) - norm.cdf(-bound, error, doubt)
    likely = share.min(axis=1) > 1e-9  # below, the oracle itself loses its digits
    found = log_chance(error, doubt, bound)
    assert np.isfinite(found).all()
    np.testing.assert_allclose(found[likely], np.log(share[likely]).sum(axis=1), rtol=1e-5, atol=1e-7)


def learned(count: int) -> tuple[Response, np.random.Generator]:
    random = np.random.default_rng(count)
    shift = random.uniform(-0.5, 0.5, (count, 3))
    error = np.stack([shift[:, 0] ** 2 + 0.2, shift[:, 1] - shift[:, 2], np.sin(2.0 * shift[:, 2])], axis=1)
    return Response(shift, error), random


@pytest.mark.parametrize("count", [1, 5, 40])
def test_the_jacobian_is_the_slope_of_the_error(count: int) -> None:
    response, random = learned(count)
    at, step = random.uniform(-0.5, 0.5, 3), 1e-5
    moved = np.concatenate([at + step * np.eye(3), at - step * np.eye(3)])
    ends = response.error(moved)
    np.testing.assert_allclose(response.jacobian(at), (ends[:3] - ends[3:]).T / (2.0 * step), atol=1e-5)


def test_newton_ends_within_the_actions_at_the_smallest_error() -> None:
    shift = np.zeros((1, 2))
    response = Response(shift, np.array([[0.5, -0.3]]))
    np.testing.assert_allclose(gauss_newton(response, np.ones(2), shift[0]), [-0.5, 0.3], atol=1e-4)
    far = Response(shift, np.array([[2.5, 0.0]]))
    np.testing.assert_allclose(gauss_newton(far, np.ones(2), shift[0]), [-1.0, 0.0], atol=1e-3)


def test_reset_forgets_everything_and_repeats_itself() -> None:
    newton, actions = NewtonGoal(POSE), []
    for _ in range(2):
        newton.reset(7)
        assert not newton.act(ONE).any()
        newton.begin_practice(48)
        thrown(newton, bent, 3, rows=8)
        actions.append(newton.act(observation_of(np.zeros((8, 5)))))
    assert np.array_equal(*actions)


def test_memory_is_bounded_and_holds_the_best(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("agents.controllers.newton.MEMORY", 12)
    newton = NewtonGoal(POSE)
    newton.begin_practice(90)
    size = thrown(newton, turned, 60)
    newton.end_practice()
    assert len(newton.state()["shift"]) <= 13
    assert kept(newton, turned) == pytest.approx(size.min(), abs=0.05)
