import dataclasses

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from pnt_gym.arrays import take
from pnt_gym.planning import (
    EllipticWorkspace,
    InfeasibleThrow,
    MotionLimits,
    Reason,
    landing_point,
    min_time_scurve,
    plan_release,
    plan_release_batch,
    release_at_elevation,
    release_at_point,
    speed_at,
)
from tests.tools.planning import random_throws

PICKS = np.array([[-0.2, -0.25, -0.85], [-0.2, -0.35, -0.85], [-0.3, -0.35, -0.85]])
TARGET = np.array([0.3, 0.4, -0.85])
PAPER_LIMITS = MotionLimits(velocity=1.8, acceleration=36.0, jerk=900.0)
FIELDS = ("speed", "acceleration", "angle", "azimuth", "distance", "time", "flight_time")

offsets = st.tuples(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5), st.floats(-0.6, 0.6)).map(np.array)
percents = st.floats(5.0, 100.0)


@pytest.mark.parametrize(
    ("ceiling", "tolerance", "positions", "times"),
    [
        (-0.75, 0.0, [[0.1025, 0.1433], [0.1259, 0.1389], [0.1074, 0.1593]], [0.3262, 0.3761, 0.4116]),
        (-0.75, 0.005, [[0.0981, 0.1375], [0.1222, 0.1334], [0.1031, 0.1538]], None),
        (None, 0.0, [[-0.0044, 0.0043], [0.0120, -0.0321], [-0.0329, -0.0162]], [0.2587, 0.2966, 0.3244]),
    ],
)
def test_numeric_example_of_hassan_2022(ceiling, tolerance, positions, times):
    # Section IV-B3 solved exactly. The printed release points are not optimal and one misses its target.
    targets = np.tile(TARGET, (3, 1))
    plans = plan_release_batch(PICKS, targets, PAPER_LIMITS, ceiling=ceiling, tolerance=tolerance)
    np.testing.assert_allclose(plans.position[:, :2], positions, rtol=0, atol=6e-5)
    heights = [-0.6378, -0.6069, -0.5851] if ceiling is None else [-0.75] * 3
    np.testing.assert_allclose(plans.position[:, 2], heights, rtol=0, atol=6e-5)
    assert (plans.speed == 1.8).all()
    assert plans.ceiling_active.all() == (ceiling is not None)
    if times is not None:
        np.testing.assert_allclose(plans.time, times, rtol=0, atol=6e-5)


@given(offsets, percents, st.floats(0.0, 0.05))
def test_released_object_lands_on_the_target_or_its_near_side(offset, percent, tolerance):
    assume(np.hypot(offset[0], offset[1]) > 0.1)
    plan = plan_release(np.zeros(3), offset, MotionLimits.t3kr(percent), tolerance=tolerance)
    landing = landing_point(plan.position, plan.velocity, offset[2])
    miss = landing - offset
    assert np.abs(miss).max() == pytest.approx(tolerance, abs=1e-10)
    assert np.hypot(landing[0], landing[1]) <= np.hypot(offset[0], offset[1]) + 1e-12


@given(offsets, percents, st.floats(0.0, 2.0 * np.pi))
def test_turning_and_shifting_the_scene_turns_and_shifts_the_plan(offset, percent, turn):
    assume(np.hypot(offset[0], offset[1]) > 1e-2)
    limits = MotionLimits.t3kr(percent)
    cosine, sine = np.cos(turn), np.sin(turn)
    rotation = np.array([[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    plan = plan_release(np.zeros(3), offset, limits)
    moved = plan_release(np.array([0.1, -0.2, 0.3]), rotation @ offset + [0.1, -0.2, 0.3], limits)
    assert moved.time == pytest.approx(plan.time, rel=1e-9)
    np.testing.assert_allclose(moved.velocity, rotation @ plan.velocity, rtol=0, atol=1e-6 * plan.speed)


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"ceiling": -0.75},
        {"ceiling": -0.8, "tolerance": 0.01},
        {"workspace": EllipticWorkspace()},
        {"ceiling": -0.7, "workspace": EllipticWorkspace(z_min=-0.9, z_max=-0.72)},
    ],
)
def test_one_throw_gives_the_bits_of_its_row(options):
    picks, targets, numbers = random_throws(400, seed=31)
    limits = MotionLimits(*numbers)
    batch = plan_release_batch(picks, targets, limits, **options)
    assert len(batch) == 400
    for k in range(400):
        try:
            plan = plan_release(picks[k], targets[k], take(limits, k), **options)
        except InfeasibleThrow as error:
            assert not batch.feasible[k]
            assert error.reason == batch.reason[k] != Reason.FEASIBLE
            continue
        assert batch.feasible[k]
        row = batch.row(k)
        for field in dataclasses.fields(plan):
            np.testing.assert_array_equal(getattr(plan, field.name), getattr(row, field.name), field.name)


def test_infeasible_rows_are_nan_and_say_why():
    targets = np.array([[0.3, 0.4, -0.85], [-0.2, -0.25, -0.2], [-0.1, -0.25, 0.5]])
    plans = plan_release_batch(np.tile(PICKS[0], (3, 1)), targets, MotionLimits.t3kr(10), ceiling=-0.75)
    assert plans.feasible.tolist() == [True, False, False]
    assert plans.reason.tolist() == [Reason.FEASIBLE, Reason.NO_REACH, Reason.CEILING]
    for name in (*FIELDS, "position", "velocity", "direction"):
        values = getattr(plans, name)
        assert np.isfinite(values[0]).all()
        assert np.isnan(values[1:]).all()
    assert not plans.ceiling_active[1:].any()
    with pytest.raises(InfeasibleThrow, match="row 2"):
        plans.row(2)


def test_target_straight_above_below_or_within_tolerance_has_no_throw():
    limits = MotionLimits.t3kr(50)
    for target in ((0.0, 0.0, 0.3), (0.0, 0.0, -0.3), (0.0, 0.0, 0.0)):
        with pytest.raises(InfeasibleThrow, match="straight above or below") as error:
            plan_release((0.0, 0.0, 0.0), target, limits)
        assert error.value.reason == Reason.NO_REACH
    with pytest.raises(InfeasibleThrow, match="tolerance"):
        plan_release((0.0, 0.0, 0.0), (0.01, 0.0, 0.0), limits, tolerance=0.02)


def test_target_above_the_ceiling():
    # A strong robot can lob into a bin above its ceiling, a weak one cannot, and says so.
    pick, target = (0.0, 0.0, 0.0), (0.5, 0.0, 0.2)
    plan = plan_release(pick, target, MotionLimits.t3kr(100), ceiling=0.1)
    assert plan.position[2] <= 0.1 + 1e-12
    with pytest.raises(InfeasibleThrow, match=r"ceiling z = 0\.1") as error:
        plan_release(pick, target, MotionLimits.t3kr(5), ceiling=0.1)
    assert error.value.reason == Reason.CEILING


def test_ceiling_at_the_height_of_the_pick_makes_a_level_throw():
    plan = plan_release((0.0, 0.0, 1.0), (0.8, 0.0, 0.6), MotionLimits.t3kr(30), ceiling=1.0)
    assert plan.angle == 0.0
    assert plan.position[2] == 1.0
    assert plan.ceiling_active
    with pytest.raises(InfeasibleThrow, match="ceiling"):
        plan_release((0.0, 0.0, 1.0), (0.8, 0.0, 1.0), MotionLimits.t3kr(30), ceiling=1.0)


def test_workspace_bounds_the_release_point():
    picks, targets, numbers = random_throws(600, seed=32)
    picks[:, :2] *= 0.6
    limits, space = MotionLimits(*numbers), EllipticWorkspace(z_min=-1.0, z_max=-0.7)
    plans = plan_release_batch(picks, targets, limits, workspace=space)
    free = plan_release_batch(picks, targets, limits)
    ok = plans.feasible
    assert space.margin(plans.position[ok]).min() >= -1e-9
    inside = space.contains(free.position)
    np.testing.assert_array_equal(plans.workspace_active, ok & ~inside)
    np.testing.assert_array_equal(plans.time[inside], free.time[inside])
    assert plans.workspace_active.sum() > 30
    lost = ~ok
    assert (plans.reason[lost] == Reason.WORKSPACE).all()
    # An elevation scan finds no quicker throw that stays inside, and none at all for the infeasible rows.
    for angle in np.linspace(-0.6, 1.5, 80):
        other = release_at_elevation(picks, targets, limits, angle)
        legal = other.feasible & (space.margin(np.nan_to_num(other.position)) > 1e-9)
        assert not (legal & lost).any()
        assert (plans.time[legal] <= other.time[legal] * (1 + 1e-9)).all()


def test_workspace_may_ask_for_a_steeper_throw():
    # The free optimum leaves the ellipse sideways; releasing higher and nearer is the way out.
    space = EllipticWorkspace(semi_x=0.1, semi_y=0.1)
    args = ((0.0, 0.0, 0.0), (1.0, 0.0, -0.2), MotionLimits(2.8, 40.0, 900.0))
    free, plan = plan_release(*args), plan_release(*args, workspace=space)
    assert free.position[0] > 0.1
    assert plan.angle > free.angle
    assert plan.position[0] == pytest.approx(0.1, abs=1e-12)
    assert plan.workspace_active


def test_blame_goes_to_the_bound_that_rules_the_throw_out():
    pick, target, limits = (0.0, 0.0, 0.0), (1.5, 0.0, 0.3), MotionLimits.t3kr(20)
    tiny = EllipticWorkspace(semi_x=0.05, semi_y=0.05)
    with pytest.raises(InfeasibleThrow, match="workspace") as error:
        plan_release(pick, target, limits, ceiling=2.0, workspace=tiny)
    assert error.value.reason == Reason.WORKSPACE
    with pytest.raises(InfeasibleThrow, match="ceiling"):
        plan_release(pick, target, limits, ceiling=0.01, workspace=tiny)


def test_elevation_can_be_held_while_the_target_moves():
    picks, targets, numbers = random_throws(300, seed=33)
    limits = MotionLimits(*numbers)
    best = plan_release_batch(picks, targets, limits)
    held = release_at_elevation(picks, targets, limits, best.angle)
    np.testing.assert_allclose(held.time, best.time, rtol=1e-12)
    np.testing.assert_allclose(held.position, best.position, rtol=0, atol=1e-12)
    shifted = targets + np.array([0.03, -0.02, 0.0])
    moved = release_at_elevation(picks, shifted, limits, best.angle)
    np.testing.assert_array_equal(moved.angle[moved.feasible], best.angle[moved.feasible])
    landing = landing_point(moved.position, moved.velocity, shifted[:, 2])[moved.feasible]
    np.testing.assert_allclose(landing, shifted[moved.feasible], rtol=0, atol=1e-10)
    free = plan_release_batch(picks, shifted, limits)
    assert (moved.time[moved.feasible] >= free.time[moved.feasible] * (1 - 1e-12)).all()


def test_elevation_below_the_target_is_infeasible():
    plans = release_at_elevation(np.zeros((2, 3)), [[1.0, 0.0, 0.5], [0.0, 0.0, 0.5]], PAPER_LIMITS, 0.4)
    assert plans.reason.tolist() == [Reason.ELEVATION, Reason.NO_REACH]
    assert np.isnan(plans.time).all()
    with pytest.raises(ValueError, match="elevation"):
        release_at_elevation(np.zeros((1, 3)), np.ones((1, 3)), PAPER_LIMITS, 1.6)


def test_release_at_a_given_point():
    picks, targets, numbers = random_throws(200, seed=34)
    limits = MotionLimits(*numbers)
    best = plan_release_batch(picks, targets, limits)
    given_point = release_at_point(picks, best.position, limits, plane_z=targets[:, 2])
    for name in FIELDS:
        np.testing.assert_allclose(getattr(given_point, name), getattr(best, name), rtol=1e-8)
    landing = landing_point(given_point.position, given_point.velocity, targets[:, 2])
    np.testing.assert_allclose(landing, targets, rtol=0, atol=1e-8)
    assert np.isnan(release_at_point(picks, best.position, limits).flight_time).all()
    np.testing.assert_array_equal(given_point.speed, speed_at(given_point.distance, limits))
    stroke = min_time_scurve(2.0 * best.distance, limits)
    np.testing.assert_allclose(best.acceleration, stroke.acceleration, rtol=1e-9)


def test_release_at_a_point_says_what_is_wrong():
    picks, points = np.zeros((3, 3)), np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.1], [0.0, 0.0, 0.2]])
    plans = release_at_point(picks, points, PAPER_LIMITS, plane_z=[0.0, 5.0, 0.0])
    assert plans.reason.tolist() == [Reason.SAME_POINT, Reason.PLANE, Reason.FEASIBLE]
    assert np.isnan(plans.speed[:2]).all()
    assert plans.angle[2] == pytest.approx(0.5 * np.pi)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_inputs_must_be_finite(value):
    pick, target = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0)
    for bad in ((pick, (1.0, value, 0.0)), ((value, 0.0, 0.0), target)):
        with pytest.raises(ValueError, match="finite") as error:
            plan_release(*bad, PAPER_LIMITS)
        assert not isinstance(error.value, InfeasibleThrow)
        with pytest.raises(ValueError, match="finite"):
            plan_release_batch(*(np.array([x]) for x in bad), PAPER_LIMITS)
    for options in ({"ceiling": value}, {"tolerance": value}):
        with pytest.raises(ValueError, match="finite"):
            plan_release(pick, target, PAPER_LIMITS, **options)
        with pytest.raises(ValueError, match="finite"):
            plan_release_batch([pick], [target], PAPER_LIMITS, **options)


def test_other_bad_inputs_are_named():
    pick, target = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0)
    with pytest.raises(ValueError, match="tolerance"):
        plan_release(pick, target, PAPER_LIMITS, tolerance=-0.1)
    with pytest.raises(ValueError, match="tolerance"):
        plan_release_batch([pick], [target], PAPER_LIMITS, tolerance=-0.1)
    with pytest.raises(ValueError, match="three coordinates"):
        plan_release((0.0, 0.0), target, PAPER_LIMITS)
    with pytest.raises(ValueError, match=r"shape \(N, 3\)"):
        plan_release_batch(np.zeros(3), np.zeros(3), PAPER_LIMITS)
    with pytest.raises(ValueError, match="one row each"):
        plan_release_batch(np.zeros((2, 3)), np.zeros((3, 3)), PAPER_LIMITS)
    with pytest.raises(ValueError, match="ceiling"):
        plan_release_batch(np.zeros((2, 3)), np.ones((2, 3)), PAPER_LIMITS, ceiling=np.zeros(3))
    with pytest.raises(ValueError, match="one set of limits"):
        plan_release(pick, target, MotionLimits.t3kr(np.array([10.0, 20.0])))


def test_empty_batch():
    plans = plan_release_batch(np.zeros((0, 3)), np.zeros((0, 3)), PAPER_LIMITS, ceiling=0.0)
    assert len(plans) == 0
    assert plans.position.shape == (0, 3)
