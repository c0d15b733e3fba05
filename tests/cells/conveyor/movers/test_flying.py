"""The straight throw with a return that does not stop: the same throws, shorter cycles, every limit kept."""

import numpy as np
import pytest

from pnt_gym.planning.motion.limits import LimitRows
from tests.tools.throws import is_feasible, make_core, same_bits, spy_on_plant, vary

COUNT = 24
WINDOW = {"follow_through": {"window": 0.030}}


def core_of(planner, picks, mode="release_point", **changes):
    return make_core(vary("ideal", planner=planner, motion=WINDOW, **changes), COUNT, picks=picks, mode=mode)


def assert_same_releases(first, second):
    for name in ("position", "velocity", "distance", "time", "flight_time", "reason"):
        assert same_bits(getattr(first, name), getattr(second, name)), name


def test_throws_are_those_of_the_straight_throw():
    stopping, flying = (core_of(planner, "independent") for planner in ("straight", "straight_flying"))
    assert flying.context.plan.straight.all()
    assert_same_releases(stopping.context.plan, flying.context.plan)
    action = np.random.default_rng(0).uniform(-0.5, 0.5, (COUNT, 2))
    corrected = [core.plan(action) for core in (stopping, flying)]
    assert_same_releases(corrected[0][0], corrected[1][0])
    assert is_feasible(flying, corrected[1][0]).all()


@pytest.mark.parametrize("picks", ["belt", "independent"])
def test_the_return_is_quicker_and_keeps_every_limit(picks):
    stopping, flying = (core_of(planner, picks) for planner in ("straight", "straight_flying"))
    calls = spy_on_plant(flying)
    infos = [core.step(np.zeros((COUNT, 2))).info for core in (stopping, flying)]
    # On the belt the hand also waits for objects.
    assert infos[1]["cycle_time"].mean() < (0.98 if picks == "belt" else 0.92) * infos[0]["cycle_time"].mean()
    assert infos[1]["is_success"].mean() >= infos[0]["is_success"].mean() - 0.05
    for context, cycle, _ in calls:
        for ratio in cycle.path.peak_ratios(LimitRows.t3kr(context.objects.percent)):
            assert ratio.max() < 1.0 + 1e-6
