"""The exact optimum against brute force that shares no code with it."""

import numpy as np
import pytest

from pnt_gym.planning import GRAVITY, MotionLimits, plan_release, plan_release_batch
from tests.tools.planning import brute_force, half_stroke, random_throws

CASES = 1500
# The bounds of a release, its own numbers, and how far they may be off.
ROUNDING = 1e-11


def check_plans(plans, picks, targets, limits, ceiling):
    """Every plan obeys the S-curve, the ceiling and the law of falling bodies."""
    ok = plans.feasible
    speed, time = half_stroke(plans.distance[ok], tuple(x[ok] for x in limits))
    np.testing.assert_allclose(plans.speed[ok], speed, rtol=1e-7)
    np.testing.assert_allclose(plans.time[ok], time, rtol=1e-7)
    t = plans.flight_time[ok][:, None]
    landing = plans.position[ok] + t * plans.velocity[ok] + 0.5 * t**2 * np.array([0.0, 0.0, -GRAVITY])
    np.testing.assert_allclose(landing, targets[ok], rtol=0, atol=1e-9)
    assert (plans.position[ok, 2] <= ceiling[ok] + ROUNDING).all()
    np.testing.assert_allclose(np.linalg.norm(plans.velocity[ok], axis=1), plans.speed[ok], rtol=1e-12)
    reached = picks[ok] + plans.distance[ok][:, None] * plans.direction[ok]
    np.testing.assert_allclose(plans.position[ok], reached, rtol=0, atol=1e-12)


def compare(plans, picks, targets, limits, ceiling):
    """Nothing brute force finds is quicker, and all but a handful of narrow optima it finds too."""
    step = targets - picks
    reach = np.hypot(step[:, 0], step[:, 1])
    time, distance, speed, _ = brute_force(reach, step[:, 2], limits, ceiling=ceiling - picks[:, 2])
    exists = np.isfinite(time)
    assert plans.feasible[exists].all()
    assert (plans.time[exists] <= time[exists] * (1.0 + 1e-9)).all()
    same = exists & (plans.time >= time * (1.0 - 1e-6))
    assert (plans.feasible & ~same).sum() <= 0.002 * reach.size
    np.testing.assert_allclose(plans.time[same], time[same], rtol=1e-6)
    np.testing.assert_allclose(plans.distance[same], distance[same], rtol=1e-6)
    np.testing.assert_allclose(plans.speed[same], speed[same], rtol=1e-6)


def test_free_optimum():
    picks, targets, limits = random_throws(CASES, seed=21)
    plans = plan_release_batch(picks, targets, MotionLimits(*limits))
    assert plans.feasible.all()
    assert not plans.ceiling_active.any()
    unbounded = np.full(CASES, np.inf)
    check_plans(plans, picks, targets, limits, unbounded)
    compare(plans, picks, targets, limits, unbounded)


def test_optimum_under_a_ceiling():
    picks, targets, limits = random_throws(CASES, seed=22)
    ceiling = picks[:, 2] + np.random.default_rng(23).uniform(0.005, 0.2, CASES)
    plans = plan_release_batch(picks, targets, MotionLimits(*limits), ceiling=ceiling)
    assert 0.1 < plans.ceiling_active.mean() < 0.9
    assert 0.0 < 1.0 - plans.feasible.mean() < 0.5
    check_plans(plans, picks, targets, limits, ceiling)
    compare(plans, picks, targets, limits, ceiling)
    free = plan_release_batch(picks, targets, MotionLimits(*limits))
    moved = plans.ceiling_active
    assert (plans.time[moved] > free.time[moved]).all()
    same = plans.feasible & ~moved
    np.testing.assert_array_equal(plans.time[same], free.time[same])


def test_ceiling_below_the_pick():
    picks, targets, limits = random_throws(200, seed=24, rise=(-0.6, -0.1))
    ceiling = picks[:, 2] - np.random.default_rng(25).uniform(0.001, 0.09, 200)
    plans = plan_release_batch(picks, targets, MotionLimits(*limits), ceiling=ceiling)
    assert plans.feasible.all()
    assert (plans.angle < 0.0).all()
    check_plans(plans, picks, targets, limits, ceiling)
    compare(plans, picks, targets, limits, ceiling)


def test_steep_branch_is_found_where_the_feasible_elevations_split():
    # Local solvers stop at 0.2051 s here: the flat branch, with an infeasible stretch in between.
    pick, target, limits = (-0.389, -0.443, -0.85), (0.209, 0.200, -0.79), MotionLimits(2.7, 54.0, 1350.0)
    plan = plan_release(pick, target, limits, ceiling=-0.75)
    assert plan.time == pytest.approx(0.0963, abs=5e-5)
    assert np.degrees(plan.angle) == pytest.approx(43.7, abs=0.05)
    reach = np.hypot(0.598, 0.643)
    time, distance, speed, angle = brute_force(reach, 0.06, limits.numbers(), ceiling=0.1, nodes=8000)[:, 0]
    assert (plan.time, plan.distance, plan.speed) == pytest.approx((time, distance, speed), rel=1e-6)
    assert plan.angle == pytest.approx(angle, abs=1e-3)
    flat = brute_force(reach, 0.06, limits.numbers(), ceiling=0.0435)
    assert flat[0, 0] > 1.5 * plan.time


def test_binding_ceiling_with_a_split_takes_the_steep_branch():
    # Lower the ceiling of the case above until it binds within the steep branch.
    pick, target, limits = (-0.389, -0.443, -0.85), (0.209, 0.200, -0.79), MotionLimits(2.7, 54.0, 1350.0)
    free = plan_release(pick, target, limits)
    reach, found = np.hypot(0.598, 0.643), 0
    for drop in np.linspace(1e-4, 0.02, 40):
        ceiling = float(free.position[2]) - drop
        plan = plan_release(pick, target, limits, ceiling=ceiling)
        time = brute_force(reach, 0.06, limits.numbers(), ceiling=ceiling + 0.85, nodes=4000)[0, 0]
        assert plan.time == pytest.approx(time, rel=1e-6)
        assert plan.ceiling_active
        found += plan.time < 0.15
    assert 0 < found < 40
