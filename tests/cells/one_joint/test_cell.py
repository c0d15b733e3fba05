"""The thrower's cell: goals in reach, honest errors, one throw after the other, and the same bits in any company."""

from dataclasses import replace

import numpy as np
import pytest

from pnt_gym.arrays import take
from pnt_gym.cells.one_joint.cell import OneJointCell
from pnt_gym.cells.one_joint.config import OneJointConfig
from pnt_gym.cells.one_joint.hidden import expected_hidden
from pnt_gym.cells.one_joint.outcome import is_within
from pnt_gym.cells.one_joint.pallets import SORTING, STAND, stack_pose
from pnt_gym.errors import ConfigError
from tests.tools.thrower import NO_ERRORS, WEIGHTS, state_at_goal

COUNT = 12
TOLERANCES = np.array([0.0005, 0.0005, np.deg2rad(0.1), 0.005])


def cells(level="nominal", count=COUNT, threads=1, seed=0, **changes):
    """Cells whose row i draws from a generator of seed + i."""
    made = OneJointCell(OneJointConfig.load(level, **changes), count, threads)
    made.reset(np.arange(count), [np.random.default_rng(seed + i) for i in range(count)])
    return made


def throw(cell):
    """The nominal throws."""
    return cell.throw(cell.context.plans)


@pytest.mark.parametrize("task", ["throw", "sort", "assembly"])
def test_without_mismatch_every_throw_succeeds_and_passes_through_its_goal(task):
    cell = cells("ideal", task=task)
    for _ in range(3):
        outcome = throw(cell)
        assert outcome.is_success.all()
        assert (np.abs(outcome.true_error) < TOLERANCES).all()
        assert (np.abs(outcome.error) < TOLERANCES).all()
        assert not outcome.touched_other.any()


def test_drawn_goals_lie_in_their_region_and_differ():
    cell = cells(count=64)
    low, high = cell.job.region.bounds()
    assert (cell.context.goal >= low).all()
    assert (cell.context.goal <= high).all()
    assert len(np.unique(cell.context.goal[:, 0])) == 64
    assert cell.context.plans.feasible.all()


def test_goals_out_of_reach_are_named():
    goal = {"name": "far", "x": -2.5, "y": 0.4, "phi_deg": 150, "dy": 0.0}
    with pytest.raises(ConfigError, match=r"goal 'far' \(x -2\.5 m, .* is out of the arm's reach"):
        cells(goals={"fixed": [goal]})
    with pytest.raises(ConfigError, match=r"no goal of goals\.region is in the arm's reach"):
        cells(count=1, goals={"region": {"x": [2.0, 3.0]}})


def test_errors_are_states_minus_goals():
    outcome = throw(cells())
    np.testing.assert_array_equal(outcome.error, outcome.measured - outcome.goal)
    np.testing.assert_array_equal(outcome.true_error, outcome.true - outcome.goal)
    columns = outcome.error_x, outcome.error_y, outcome.error_phi, outcome.error_dy
    np.testing.assert_array_equal(np.stack(columns, axis=1), outcome.error)
    np.testing.assert_allclose(outcome.landing_error, np.linalg.norm(outcome.true_error[:, :2], axis=1), rtol=1e-12)


def test_the_camera_sees_what_is_true_but_for_its_noise():
    """Ballistic squares of hundreds of frames average 0.3 mm and 0.17 deg; what is left is mostly the drag."""
    outcome = throw(cells(count=48))
    difference = np.abs(outcome.measured - outcome.true)
    assert difference[:, :2].max() < 0.002
    assert difference[:, 2].max() < np.deg2rad(2.0)
    assert difference[:, 0].mean() > 1e-6


def test_a_delay_makes_nominal_throws_fail_and_ten_milliseconds_more_so():
    five, ten = throw(cells("nominal", count=32)), throw(cells("late", count=32))
    assert 0.02 < five.landing_error.mean() < 0.08
    assert 0.05 < ten.landing_error.mean() < 0.16
    assert five.is_success.mean() < 0.1
    assert ten.is_success.mean() < 0.1


@pytest.mark.parametrize(
    ("error", "success"),
    [
        ([0.0, 0.0, 0.0, 0.0], True),
        ([0.003, -0.003, 0.0, 0.0], True),
        ([0.004, 0.004, 0.0, 0.0], False),
        ([0.0, 0.0, np.deg2rad(1.9), 0.0], True),
        ([0.0, 0.0, np.deg2rad(-2.1), 0.0], False),
        ([0.0, 0.0, 0.0, -0.049], True),
        ([0.0, 0.0, 0.0, 0.051], False),
        ([0.0, 0.0, 2.0 * np.pi, 0.0], False),
    ],
)
def test_success_needs_every_coordinate_within_its_tolerance(error, success):
    """5 mm, 2 deg and 0.05 m/s; a whole turn too many is not the same state."""
    assert is_within(np.array([error]), OneJointConfig.load("ideal").tolerance).tolist() == [success]


def test_sorting_throws_into_each_of_the_three_pallets():
    cell = cells("ideal", count=24, task="sort")
    kind = cell.context.kind
    assert set(kind.tolist()) == {0, 1, 2}
    np.testing.assert_allclose(cell.context.goal, np.stack([SORTING[k].state for k in kind]))
    outcome = throw(cell)
    assert outcome.in_pallet.all()
    seats = np.stack([SORTING[k].pose for k in kind])
    assert np.abs(outcome.final[:, 0] - seats)[:, :2].max() < 0.015


def test_a_block_thrown_at_another_pallet_is_no_success_and_says_that_it_touched_it():
    cell = cells("ideal", count=6, task="sort")
    cell.context = replace(cell.context, kind=np.array([0, 0, 1, 1, 2, 2]))
    aimed = np.array([1, 2, 0, 2, 0, 1])
    plans = cell.planner.plan(np.stack([SORTING[k].state for k in aimed]), cell.context.part)
    outcome = cell.preview(plans)
    assert not outcome.is_success.any()
    assert not outcome.in_pallet.any()
    assert outcome.touched_other.all()


def test_an_assembly_puts_a_tee_on_an_aitch():
    cell = cells("ideal", count=4, task="assembly")
    first = throw(cell)
    np.testing.assert_allclose(first.final[:, 0, :2], np.tile(STAND.pose[:2], (4, 1)), atol=0.002)
    assert cell.context.kind.tolist() == [1] * 4
    assert cell.context.part.tolist() == [1] * 4
    np.testing.assert_array_equal(cell.context.lying[:, 0], first.final[:, 0])
    second = throw(cell)
    assert second.is_success.all()
    seat = stack_pose(second.final[:, 0])
    assert np.abs(second.final[:, 1, :2] - seat[:, :2]).max() < 0.003
    assert cell.context.kind.tolist() == [0] * 4
    assert np.isnan(cell.context.lying).all()


def test_a_failed_first_part_is_cleared_away_and_thrown_again():
    cell = cells("late", count=4, task="assembly")
    assert not throw(cell).is_success.any()
    assert cell.context.kind.tolist() == [0] * 4
    assert np.isnan(cell.context.lying).all()


def test_rows_of_an_assembly_may_stand_at_different_parts():
    cell = cells("ideal", count=4, task="assembly")
    throw(cell)
    cell.reset(np.array([1, 3]), [np.random.default_rng(8), np.random.default_rng(9)])
    assert cell.context.kind.tolist() == [1, 0, 1, 0]
    assert np.isnan(cell.context.lying[[1, 3]]).all()
    outcome = throw(cell)
    assert outcome.is_success.all()
    assert cell.context.kind.tolist() == [0, 1, 0, 1]


def test_a_cycle_lasts_until_part_and_arm_have_arrived():
    cell = cells("ideal")
    plans = cell.context.plans
    outcome = throw(cell)
    flight = plans.motion.duration + plans.u[:, 3]
    back = plans.motion.stop_time + cell.planner.return_time(plans)
    assert (outcome.cycle_time >= np.maximum(flight, back) - 1e-9).all()
    np.testing.assert_allclose(outcome.cycle_time, np.maximum(flight, back), atol=2e-9)


def test_the_return_is_a_rest_to_rest_motion_at_the_limits():
    """Compared with the distance that such a motion covers, integrated numerically."""
    cell = cells("ideal")
    plans, arm = cell.context.plans, cell.planner.arm
    total = cell.planner.return_time(plans)
    rate = arm.torque_at_speed / arm.inertia
    share = (np.arange(20000) + 0.5) / 20000
    time = total[:, None] * share
    speed = np.minimum(np.minimum(rate * time, rate * (total[:, None] - time)), arm.speed)
    way = speed.mean(axis=1) * total
    np.testing.assert_allclose(way, np.abs(plans.motion.stop_angle - plans.motion.start_angle), rtol=1e-4)


def test_a_preview_with_jitter_is_the_throw_and_changes_nothing():
    cell = cells()
    before = cell.context
    shown = cell.preview(before.plans, jitter=True)
    assert cell.context is before
    done = throw(cell)
    assert shown.measured.tobytes() == done.measured.tobytes()
    assert shown.true.tobytes() == done.true.tobytes()


def test_a_preview_without_jitter_is_the_expected_throw():
    one, other = cells("paper", seed=1), cells("paper", seed=50)
    first, second = one.preview(one.context.plans), other.preview(other.context.plans)
    assert first.measured.tobytes() == second.measured.tobytes()
    with_jitter = one.preview(one.context.plans, jitter=True)
    assert not np.array_equal(with_jitter.true, first.true)
    assert np.abs(with_jitter.true - first.true)[:, :2].max() < 0.006


def test_an_infeasible_plan_is_refused():
    cell = cells()
    goal = cell.context.goal.copy()
    goal[3, 0] = -2.0
    plans = cell.planner.plan(goal, cell.context.part)
    with pytest.raises(ValueError, match="the plan of cell 3 is not feasible"):
        cell.throw(plans)


def test_a_release_state_can_be_planned_directly():
    cell = cells("ideal")
    u = cell.context.plans.u.copy()
    u[:, 1] -= 0.3
    plans = cell.planner.plan_releases(u, cell.context.part)
    assert plans.feasible.any()
    chosen = take(plans, np.where(plans.feasible, np.arange(COUNT), np.flatnonzero(plans.feasible)[0]))
    flight = cell.plant.fly(replace(cell.context, hidden=expected_hidden(COUNT, cell.config)), chosen)
    wanted = state_at_goal(chosen.u)
    assert (np.abs(flight.nearest(wanted, WEIGHTS) - wanted) < TOLERANCES).all()
    np.testing.assert_allclose(flight.release_speed, chosen.u[:, 1], rtol=1e-4)


@pytest.mark.parametrize("task", ["throw", "assembly"])
def test_a_pose_shows_the_part_on_the_resting_arm(task):
    cell = cells("ideal", count=2, task=task)
    model, data = cell.pose(1)
    start = cell.context.plans.motion.start_angle[1]
    assert data.joint("arm").qpos[0] == pytest.approx(start)
    name = cell.job.parts[cell.context.part[1]].name
    place = data.body(name).xpos[[0, 2]]
    assert np.hypot(*place) == pytest.approx(cell.context.plans.u[1, 2], abs=1e-9)
    assert model.body(name).mass[0] == pytest.approx(cell.job.parts[cell.context.part[1]].mass)


def test_placement_scatter_alone_moves_throws_by_millimetres_at_most():
    errors = {**NO_ERRORS, "placement": 0.0002}
    outcome = throw(cells("paper", count=32, errors=errors))
    assert 5e-5 < outcome.landing_error.mean() < 0.002
