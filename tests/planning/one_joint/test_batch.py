"""Plans of many throws: limits at 1 kHz, and rows that stand alone."""

import numpy as np
import pytest

from papers.miyashita.planning.goals import random_goals
from pnt_gym.arrays import take
from pnt_gym.planning.one_joint import ThrowReason, landing_state, plan_releases, plan_throws
from tests.tools.one_joint import assert_keeps_all_limits

GOALS = random_goals(np.random.default_rng(11), 400)


def test_plans_of_many_throws_keep_every_limit_and_hit():
    plans = plan_throws(GOALS.goal)
    assert plans.feasible.mean() >= 0.99
    good = take(plans, plans.feasible)
    assert_keeps_all_limits(good.motion, good.radius)
    u = good.u
    assert good.motion.release_angle == pytest.approx(u[:, 0], abs=1e-9)
    assert good.motion.release_speed == pytest.approx(u[:, 1], abs=1e-9)
    assert landing_state(u) == pytest.approx(good.goal, abs=1e-9)
    assert (good.margins > 0).all()


def test_a_row_is_the_same_alone_and_in_a_batch():
    goals = np.concatenate([GOALS.goal[:70], [[0.25, 0.1, np.pi, -2.0], [9.0, 9.0, 0.0, 0.0]]])
    whole = plan_throws(goals)
    for k in (0, 15, 16, 69, 70):
        one = plan_throws(goals[k : k + 1])
        for name in ("u", "margins", "feasible", "reason", "radius"):
            assert np.array_equal(getattr(one, name)[0], getattr(whole, name)[k], equal_nan=True), name
        for name in ("knots", "time_step", "braking"):
            assert np.array_equal(getattr(one.motion, name)[0], getattr(whole.motion, name)[k], equal_nan=True)
    assert whole.reason[70] == ThrowReason.RADIUS
    assert whole.reason[71] == ThrowReason.NO_RELEASE
    assert np.isnan(whole.motion.knots[70:]).all()


def test_plans_from_releases_are_the_plans_of_their_goals():
    from_goals, from_releases = plan_throws(GOALS.goal[:20]), plan_releases(GOALS.u[:20])
    assert from_releases.goal == pytest.approx(GOALS.goal[:20], abs=1e-12)
    same = np.abs(from_goals.u - GOALS.u[:20]).max(axis=1) < 1e-7
    assert same.sum() >= 18
    assert from_releases.motion.knots[same] == pytest.approx(from_goals.motion.knots[same], abs=1e-4)


def test_releases_that_cannot_be_are_refused_with_a_reason():
    u = np.tile(GOALS.u[:1], (5, 1))
    u[0, 1], u[1, 0], u[2, 2], u[3, 1] = 13.0, 1.6, 0.4, -3.0
    u[4, 2] = 0.01
    plans = plan_releases(u)
    expected = [ThrowReason.SPEED, ThrowReason.ANGLE, ThrowReason.RADIUS, ThrowReason.SPEED, ThrowReason.RADIUS]
    assert plans.reason.tolist() == expected
    assert not plans.feasible.any()
    assert plan_releases(np.zeros((0, 4))).u.shape == (0, 4)
