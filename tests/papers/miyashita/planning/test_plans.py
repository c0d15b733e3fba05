"""Plans of one throw: limits at 1 kHz, optima, and random goals."""

import numpy as np
import pytest

from papers.miyashita.planning.goals import ReleaseBox, random_goals
from papers.miyashita.planning.plan import plan_throw
from papers.miyashita.planning.programme import Programme, Throw, Weighing
from pnt_gym.arrays import take
from pnt_gym.planning.one_joint import Arm, Block, UnreachableGoal, landing_state, plan_releases, plan_throws
from tests.tools.one_joint import assert_keeps_all_limits

BLOCK = Block()
EXAMPLE = np.array([0.0, 0.4, np.deg2rad(150.0), 0.0])
GOALS = random_goals(np.random.default_rng(11), 400)


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


COSTS = {"squares": (-0.574278, -0.436037, -0.216216), "max_min": (-0.798728, -0.804939, -0.440950)}
"""Costs that the interior-point solver IPOPT found in other variables, the spline's control points, by objective: for
the example and two random goals."""


@pytest.mark.parametrize("objective", COSTS)
def test_an_interior_point_solver_found_the_same_optima_in_other_variables(objective):
    plans = [plan_throw(goal, objective=objective) for goal in (EXAMPLE, *GOALS.goal[:2])]
    assert [plan.cost for plan in plans] == pytest.approx(COSTS[objective], rel=5e-5)


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
    with pytest.raises(ValueError, match="hardly any feasible release"):
        random_goals(np.random.default_rng(3), 3, arm=Arm(torque=1e-3))
    with pytest.raises(ValueError, match="speed"):
        ReleaseBox(speed=(-1.0, 2.0))
