"""Plans of one throw and of many: limits at 1 kHz, optima of two solvers, rows that stand alone."""

import numpy as np
import pytest

from pnt_gym.arrays import take
from pnt_gym.planning.one_joint import (
    Arm,
    Block,
    ReleaseBox,
    ThrowReason,
    UnreachableGoal,
    landing_state,
    plan_releases,
    plan_throw,
    plan_throws,
    random_goals,
)
from pnt_gym.planning.one_joint.grasp import joint_torque, reactions, rests, torque_limit
from pnt_gym.planning.one_joint.programme import Programme, Throw, Weighing

ARM, BLOCK = Arm(), Block()
EXAMPLE = np.array([0.0, 0.4, np.deg2rad(150.0), 0.0])
GOALS = random_goals(np.random.default_rng(11), 400)


def assert_keeps_all_limits(motion, radius, static=True):
    """At 1 kHz and at the release, from the formulas of the forces alone."""
    times = np.minimum(np.arange(0.0, motion.duration.max() + 1e-3, 1e-3), motion.duration[:, None])
    state = motion.sample(times)
    held = reactions(*state, radius[:, None], BLOCK)
    torque = joint_torque(*state, radius[:, None], ARM, BLOCK)
    assert (held.normal > 0).all() and (held.moment_a < 0).all() and (held.moment_b > 0).all()
    assert (np.abs(torque) < torque_limit(state.speed, ARM)).all()
    assert (np.abs(state.speed) < ARM.speed).all()
    assert (state.angle > ARM.angle[0]).all() and (state.angle < ARM.angle[1]).all()
    assert (motion.time_step <= ARM.time_step * (1 + 1e-9)).all()
    assert (rests(motion.start_angle, BLOCK) > 0).all() or not static


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


def test_low_releases_swing_back_first():
    goals = random_goals(np.random.default_rng(2), 60, box=ReleaseBox(angle=(-1.1, -0.8), speed=(4.0, 9.0)))
    plans = plan_releases(goals.u)
    good = take(plans, plans.feasible)
    assert plans.feasible.mean() > 0.95
    assert_keeps_all_limits(good.motion, good.radius)
    assert (good.motion.start_angle > good.u[:, 0]).any()
    for goal in good.goal[:6]:
        plan = plan_throw(goal)
        assert_keeps_all_limits(plan.motion, np.array([plan.radius]))


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


def test_the_papers_example():
    plan = plan_throw(EXAMPLE)
    assert float(plan.motion.duration[0]) == pytest.approx(0.156, abs=1e-3)
    assert np.rad2deg(plan.motion.start_angle[0]) == pytest.approx(-20.8, abs=0.1)
    assert plan.delta[0] == pytest.approx(0.71, abs=0.01)
    assert plan.delta[1] == pytest.approx(-11.3e-3, abs=0.1e-3)
    assert 18.0 - plan.delta[5] == pytest.approx(5.6, abs=0.05)
    assert_keeps_all_limits(plan.motion, np.array([plan.radius]))
    bang = plan_throw(EXAMPLE, weights="bang")
    assert float(bang.motion.duration[0]) == pytest.approx(0.049, abs=1e-3)
    assert bang.delta[5] < 0.01


def test_without_the_static_start_the_gentlest_motion_begins_where_the_block_would_tip():
    free = plan_throw(EXAMPLE, weights="torque", static_start=False)
    kept = plan_throw(EXAMPLE, weights="torque")
    assert free.motion.start_angle[0] < np.deg2rad(-63.5) < kept.motion.start_angle[0]
    assert free.margins[5] > kept.margins[5]
    assert_keeps_all_limits(free.motion, np.array([free.radius]), static=False)


@pytest.mark.parametrize("objective", ["squares", "max_min"])
def test_two_solvers_in_different_variables_agree(objective):
    for goal in [EXAMPLE, *GOALS.goal[:4]]:
        sequential, interior = (plan_throw(goal, objective=objective, solver=s) for s in ("slsqp", "ipopt"))
        assert sequential.cost == pytest.approx(interior.cost, rel=2e-3)
        assert_keeps_all_limits(interior.motion, np.array([interior.radius]))


def test_single_plans_succeed_and_do_not_lose_to_the_family():
    for goal in GOALS.goal[:40]:
        plan = plan_throw(goal, objective="max_min", starts=1)
        assert_keeps_all_limits(plan.motion, np.array([plan.radius]))
        assert landing_state(plan.u) == pytest.approx(goal, abs=1e-9)
        family = plan_throws(goal[None]).margins[0]
        assert plan.margins[[0, 1, 2, 5]].min() > family[[0, 1, 2, 5]].min() - 2e-3


def test_random_first_guesses_repeat_with_their_seed():
    one, two = (plan_throw(EXAMPLE, guesses="random", seed=4) for _ in range(2))
    assert np.array_equal(one.motion.knots, two.motion.knots)
    assert one.cost >= plan_throw(EXAMPLE).cost - 1e-6


@pytest.mark.parametrize("objective", ["squares", "max_min"])
def test_the_jacobian_of_the_programme_is_exact(objective):
    rng = np.random.default_rng(1)
    arm = Arm(friction=0.3)
    programme = Programme(
        Throw(0.36, 11.3, 0.25), arm, BLOCK, Weighing(objective, np.ones(6)), static_start=True, per_interval=2
    )
    x = programme.start(rng.uniform(20.0, 90.0, 11))
    slope, jacobian = programme.cost(x)[1], programme.constraints(x)[1]
    for k in range(x.size):
        step = 1e-6 * np.eye(x.size)[k]
        difference = (programme.constraints(x + step)[0] - programme.constraints(x - step)[0]) / 2e-6
        assert jacobian[:, k] == pytest.approx(difference, abs=1e-7)
        assert slope[k] == pytest.approx((programme.cost(x + step)[0] - programme.cost(x - step)[0]) / 2e-6, abs=1e-7)


def test_an_unreachable_goal_says_why():
    with pytest.raises(UnreachableGoal, match="too long") as error:
        plan_throw([0.25, 0.1, np.pi, -2.0])
    assert isinstance(error.value, ValueError) and len(error.value.reasons) == 1
    with pytest.raises(UnreachableGoal, match=r"117\.1 deg is out of the range"):
        plan_throw([5.0, 5.0, 0.0, 0.0])


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"weights": "heavy"}, "heavy"),
        ({"weights": [1.0, 2.0]}, "six"),
        ({"solver": "newton"}, "solver"),
        ({"objective": "most"}, "objective"),
        ({"starts": 0}, "starts"),
        ({"guesses": "none"}, "guesses"),
    ],
)
def test_unknown_options_are_named(options, words):
    with pytest.raises(ValueError, match=words):
        plan_throw(EXAMPLE, **options)


def test_random_goals_are_exact_in_number_and_repeat():
    one, two = (random_goals(np.random.default_rng(3), 50) for _ in range(2))
    assert one.goal.shape == (50, 4) and np.array_equal(one.goal, two.goal)
    assert landing_state(one.u) == pytest.approx(one.goal)
    assert random_goals(np.random.default_rng(3), 0).goal.shape == (0, 4)
    with pytest.raises(ValueError, match="next to nothing"):
        random_goals(np.random.default_rng(3), 3, arm=Arm(torque=1e-3))
    with pytest.raises(ValueError, match="speed"):
        ReleaseBox(speed=(-1.0, 2.0))
