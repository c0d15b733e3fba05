"""Virtual goals: the step, and the way back to what can be thrown."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from papers.miyashita.planning.goals import next_virtual_goal, pull_back, random_goals
from pnt_gym.planning.one_joint import release_states_batch


@given(st.floats(0.1, 1.9))
def test_the_virtual_goal_contracts_a_constant_error(gain):
    goal, shift = np.zeros((1, 4)), np.array([[0.03, -0.02, 0.2, 0.1]])
    virtual = goal
    for _ in range(3):
        virtual = next_virtual_goal(virtual, goal, virtual + shift, gain)
    assert virtual + shift == pytest.approx((1.0 - gain) ** 3 * shift, abs=1e-12)


def test_a_virtual_goal_outside_is_pulled_back_along_its_line():
    goals = random_goals(np.random.default_rng(5), 20).goal
    far = goals + np.array([0.0, 1.5, 0.0, 0.0])
    near = goals.copy()
    proposed = np.concatenate([far[:10], near[10:]])

    def test(goals):
        return release_states_batch(goals).feasible

    kept, pulled = pull_back(goals, proposed, test)
    assert pulled[:10].all() and not pulled[10:].any()
    assert np.array_equal(kept[10:], goals[10:])
    assert test(kept).all()
    way, step = proposed[:10] - goals[:10], kept[:10] - goals[:10]
    share = step[:, 1] / way[:, 1]
    assert step == pytest.approx(share[:, None] * way, abs=1e-12)
    assert not test(goals[:10] + np.minimum(share + 0.02, 1.0)[:, None] * way).all()


def test_updates_of_other_shapes_are_refused():
    with pytest.raises(ValueError, match="shape"):
        next_virtual_goal(np.zeros((2, 4)), np.zeros((3, 4)), np.zeros((2, 4)))
    with pytest.raises(ValueError, match="gain"):
        next_virtual_goal(*np.zeros((3, 1, 4)), gain=-1.0)
