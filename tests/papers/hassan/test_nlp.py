"""The paper's Method 1 and Method 2 against the exact optimum."""

import numpy as np
import pytest

from papers.hassan.nlp import method_1, method_2
from pnt_gym.arrays import take
from pnt_gym.errors import PlanningError
from pnt_gym.planning import InfeasibleThrow, MotionLimits, landing_point, plan_release
from tests.tools.planning import random_throws

COUNT = 60
PICKS, TARGETS, NUMBERS = random_throws(COUNT, seed=51)
LIMITS = MotionLimits(*NUMBERS)


def close(found, exact):
    return found.success and found.time == pytest.approx(exact.time, rel=1e-6)


@pytest.mark.parametrize(("above", "share"), [(None, 0.95), (0.1, 0.85)])
def test_method_1_mostly_finds_the_exact_optimum_and_never_beats_it(above, share):
    good = feasible = 0
    for k in range(COUNT):
        ceiling = None if above is None else PICKS[k, 2] + above
        found = method_1(PICKS[k], TARGETS[k], take(LIMITS, k), ceiling=ceiling)
        try:
            exact = plan_release(PICKS[k], TARGETS[k], take(LIMITS, k), ceiling=ceiling)
        except InfeasibleThrow:
            assert not found.success
            continue
        feasible += 1
        assert not found.success or found.time >= exact.time * (1 - 1e-6)
        good += close(found, exact)
    assert good >= share * feasible
    assert feasible == COUNT or above


def test_method_1_with_a_tolerance():
    for k in range(10):
        exact = plan_release(PICKS[k], TARGETS[k], take(LIMITS, k), tolerance=0.005)
        found = method_1(PICKS[k], TARGETS[k], take(LIMITS, k), tolerance=0.005)
        assert close(found, exact)
        np.testing.assert_allclose(found.position, exact.position, rtol=0, atol=1e-3)


def test_method_1_with_trust_constr():
    for k in range(3):
        exact = plan_release(PICKS[k], TARGETS[k], take(LIMITS, k))
        found = method_1(PICKS[k], TARGETS[k], take(LIMITS, k), solver="trust-constr")
        assert found.time == pytest.approx(exact.time, rel=1e-4)


def test_method_1_stops_at_the_wrong_branch_and_reports_success():
    # The reason the exact search exists: the flat branch takes more than twice as long.
    args = (-0.389, -0.443, -0.85), (0.209, 0.200, -0.79), MotionLimits(2.7, 54.0, 1350.0)
    exact = plan_release(*args, ceiling=-0.75)
    wrong = method_1(*args, ceiling=-0.75)
    assert wrong.success
    assert wrong.violation < 1e-6
    assert wrong.time > 2.0 * exact.time
    right = method_1(*args, ceiling=-0.75, start=(0.2, 0.7))
    assert close(right, exact)


def test_method_1_reports_failure_where_there_is_no_throw():
    args = (0.0, 0.0, 0.0), (0.5, 0.0, 0.2), MotionLimits.t3kr(5)
    with pytest.raises(InfeasibleThrow):
        plan_release(*args, ceiling=0.1)
    found = method_1(*args, ceiling=0.1)
    assert not found.success
    assert found.violation > 1e-3


def test_method_2_finds_the_exact_optimum_in_every_segment():
    good, speeds = 0, []
    for k in range(COUNT):
        limits = take(LIMITS, k)
        exact, found = plan_release(PICKS[k], TARGETS[k], limits), method_2(PICKS[k], TARGETS[k], limits)
        assert found.time >= exact.time * (1 - 1e-6)
        assert found.speed <= limits.velocity * (1 + 1e-9)
        good += close(found, exact)
        knee = limits.acceleration**2 / limits.jerk
        speeds.append(0 if exact.speed == limits.velocity else 1 if exact.speed > knee else 2)
    assert good >= 0.9 * COUNT
    assert set(speeds) == {0, 1, 2}


def test_method_2_lands_on_the_target():
    for k in range(10):
        found = method_2(PICKS[k], TARGETS[k], take(LIMITS, k))
        direction = (found.position - PICKS[k]) / found.distance
        landing = landing_point(found.position, found.speed * direction, TARGETS[k, 2])
        np.testing.assert_allclose(landing, TARGETS[k], rtol=0, atol=1e-6)


def test_methods_refuse_a_target_straight_above():
    for method in (method_1, method_2):
        with pytest.raises(PlanningError, match="straight above"):
            method((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), MotionLimits.t3kr(50))


@pytest.mark.parametrize(
    "wrong", [{"ceiling": np.nan}, {"ceiling": "low"}, {"tolerance": -0.1}, {"limits": 40.0}], ids=str
)
def test_method_1_refuses_what_is_no_bound(wrong):
    right = {"pick": PICKS[0], "target": TARGETS[0], "limits": take(LIMITS, 0)}
    with pytest.raises(PlanningError, match=next(iter(wrong))):
        method_1(**{**right, **wrong})
