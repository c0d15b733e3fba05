"""The one rule by which a residual is shortened, and the one table in which a mode is looked up."""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest

from pnt_gym.cells.base.action import ActionMode, by_name, corrected, mode_of, pad_residual, quarter_names
from pnt_gym.errors import ConfigError
from tests.tools.throws import same_bits


@dataclass(frozen=True)
class Toy:
    """Plans of a toy robot, which reaches as far as each row's own limit."""

    reached: np.ndarray
    feasible: np.ndarray


@dataclass(frozen=True)
class ToyContext:
    limit: np.ndarray


class ToyPlanner:
    """Counts the rows that it is asked to plan."""

    def __init__(self):
        self.asked = []

    def plan(self, context, residual):
        self.asked.append(len(residual))
        return Toy(residual.copy(), np.linalg.norm(residual, axis=1) <= context.limit)


REACH = ActionMode("reach", ("x", "y"), lambda config: np.ones(2), ToyPlanner.plan)
ACTIONS = np.array([[0.3, 0.4], [0.6, 0.8], [0.0, 0.0]])
LIMIT = ToyContext(np.full(3, 0.6))
for values in (ACTIONS, LIMIT.limit):
    values.flags.writeable = False  # what is planned is not written to


def test_a_feasible_residual_is_not_touched_and_another_is_shortened_as_little_as_possible():
    found, clipped = corrected(REACH, ToyPlanner(), LIMIT, ACTIONS, np.ones(2))
    np.testing.assert_array_equal(clipped, [False, True, False])
    assert same_bits(found.reached[[0, 2]], ACTIONS[[0, 2]])
    np.testing.assert_allclose(found.reached[1], [0.36, 0.48], atol=1 / 4096)
    assert np.linalg.norm(found.reached[1]) <= 0.6
    assert found.feasible.all()


def test_only_rows_that_fail_are_planned_again_each_under_its_own_circumstances():
    planner, limit = ToyPlanner(), ToyContext(np.array([0.1, 2.0, 0.5]))
    found, clipped = corrected(REACH, planner, limit, np.tile([0.6, 0.8], (3, 1)), np.ones(2))
    assert planner.asked[0] == 3
    assert set(planner.asked[1:]) == {2}
    np.testing.assert_array_equal(clipped, [True, False, True])
    np.testing.assert_allclose(np.linalg.norm(found.reached, axis=1), [0.1, 1.0, 0.5], atol=1 / 4096)


def test_the_scale_turns_actions_into_units_and_without_a_failing_row_nothing_is_planned_twice():
    planner = ToyPlanner()
    found, clipped = corrected(REACH, planner, ToyContext(np.full(3, 9.0)), ACTIONS, np.array([0.1, 10.0]))
    np.testing.assert_allclose(found.reached, ACTIONS * [0.1, 10.0])
    assert planner.asked == [3]
    assert not clipped.any()


def test_modes_are_looked_up_by_their_names():
    shove = ActionMode("shove", ("x",), lambda config: np.array([config.x]), ToyPlanner.plan)
    modes = by_name(REACH, shove)
    assert list(modes) == ["reach", "shove"]
    assert mode_of(modes, "shove") is shove
    assert mode_of(modes, "shove").scale(SimpleNamespace(x=3.0)) == [3.0]
    with pytest.raises(ConfigError, match=r"unknown action_mode 'pull'; known are reach, shove"):
        mode_of(modes, "pull")


def test_numbers_that_a_mode_leaves_out_are_zero():
    np.testing.assert_array_equal(pad_residual(np.array([[1.0, 2.0]]), 4), [[1.0, 2.0, 0.0, 0.0]])
    np.testing.assert_array_equal(pad_residual(np.array([[1.0, 2.0]]), 2), [[1.0, 2.0]])


def test_quarters_of_an_area():
    x, y = np.array([-1.0, 1.0, -1.0, 1.0]), np.array([0.0, 0.0, 5.0, 5.0])
    assert quarter_names(x, y, (0.0, 2.0), ("far", "near")) == ["left-near", "right-near", "left-far", "right-far"]
