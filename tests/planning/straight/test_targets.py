"""The choice among targets in machine code is that of planning and checking one target after the other."""

import numpy as np
import pytest

from pnt_gym.planning import plan_release_batch
from pnt_gym.planning.motion.limits import LimitRows, Space
from pnt_gym.planning.straight.kernel import choose_targets, stops_inside
from pnt_gym.planning.straight.plan import ReleaseBatch
from pnt_gym.planning.straight.release import aim_lines, release_at_elevation
from pnt_gym.planning.straight.rows import StopRules
from tests.tools.throws import same_bits

COUNT, TARGETS = 600, 5
SPACE = Space(0.45, 0.80, -0.95, 0.0, x=0.0, y=0.0, hole=0.0)
RULES = [StopRules(0.08, 0.0, 0.10), StopRules(0.0, 0.8, 0.05), StopRules(0.1, 0.0, 0.0)]


def throws(seed):
    random = np.random.default_rng(seed)
    pick = random.uniform([-0.45, -0.6, -0.9], [0.45, -0.2, -0.8], (COUNT, 3))
    target = random.uniform([-0.8, 0.25, -0.85], [0.8, 1.2, -0.85], (COUNT, TARGETS, 3))
    limits = LimitRows.t3kr(random.choice([15.0, 30.0, 45.0, 100.0], COUNT))
    return pick, target, limits, pick[:, 2] + 0.10, random.random(COUNT) < 0.9


def accepted(pick, target, limits, ceiling, rules, origin):
    """Plans to one target each, and which of them the rules accept: by the planner and a check of each moved target."""
    plans = plan_release_batch(pick, target, limits, ceiling=ceiling)
    way = target[:, :2] - origin[:, :2]
    shift = rules.reserve * way / np.sqrt((way**2).sum(axis=1))[:, None]
    return plans, stops_inside(pick, np.ascontiguousarray(target), limits, plans.rows, shift, rules, SPACE)


@pytest.mark.parametrize("rules", RULES, ids=["plain", "shaped", "no reserve"])
@pytest.mark.parametrize("ahead", [0.0, 0.03])
def test_each_object_gets_the_first_target_that_is_accepted_and_the_last_where_none_is(rules, ahead):
    origin, target, limits, ceiling, may_throw = throws(3)
    pick = origin + np.array([ahead, 0.0, 0.0])
    attempt, releases, accepts = choose_targets(pick, target, limits, ceiling, rules, SPACE, origin, may_throw)
    plan = ReleaseBatch(releases)
    one_by_one = [accepted(pick, target[:, k], limits, ceiling, rules, origin) for k in range(TARGETS)]
    good = np.array([is_good for _, is_good in one_by_one]) & may_throw
    first = np.where(good.any(axis=0), good.argmax(axis=0), TARGETS - 1)
    np.testing.assert_array_equal(attempt, first)
    np.testing.assert_array_equal(accepts, good.any(axis=0))
    for name in ("position", "velocity", "speed", "angle", "distance", "time", "flight_time", "feasible", "reason"):
        values = np.array([getattr(plans, name) for plans, _ in one_by_one])[first, np.arange(COUNT)]
        assert same_bits(getattr(plan, name), values), name
    assert len(set(attempt[accepts])) == TARGETS
    assert 0.05 < accepts.mean() < 0.95


def test_lines_without_checks_are_those_with_checks():
    pick, target, limits, _, _ = throws(5)
    angle = np.random.default_rng(0).uniform(-0.3, 1.2, COUNT)
    plain, checked = (
        aim_lines(pick, target[:, 0], limits, angle),
        release_at_elevation(pick, target[:, 0], limits, angle),
    )
    for name in ("position", "velocity", "angle", "feasible", "reason", "ceiling_active"):
        assert same_bits(getattr(plain, name), getattr(checked, name)), name
    assert 0.1 < plain.feasible.mean() < 1.0
