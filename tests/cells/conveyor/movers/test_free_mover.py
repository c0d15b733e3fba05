"""Throws in a free direction as the mover plans them: any rules are kept, the told release is flown."""

from typing import NamedTuple

import numpy as np
import pytest

from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.movers.free_mover import FreeMover
from pnt_gym.cells.conveyor.movers.straight import ThrowMotion
from pnt_gym.constants import GRAVITY
from pnt_gym.planning import JerkTrajectory
from pnt_gym.planning.motion.limits import LimitRows
from tests.tools.nightly import with_nightly
from tests.tools.throw_check import check_throw
from tests.tools.throws import make_core, vary, whole_cycle

COUNT = 32


class Flown(NamedTuple):
    """Throws of a cell's picks, each back to the pick of another row."""

    context: Context
    mover: FreeMover
    motion: ThrowMotion
    following: np.ndarray
    path: JerkTrajectory

    @property
    def curved(self):
        return ~self.context.plan.straight


def flown(clearance=0.05, ceiling=0.10, **follow_through):
    motion = {"clearance": clearance, "ceiling": ceiling, "follow_through": {"window": 0.0, **follow_through}}
    level = vary("ideal", planner="free_direction", motion=motion, limits={"percent": (15.0, 30.0, 45.0)})
    core = make_core(level, COUNT, picks="independent")
    following = np.roll(core.context.pick, -1, axis=0)
    motion, cycle = whole_cycle(core, following=following)
    return Flown(core.context, core.cell.planner.mover, motion, following, cycle.path)


@pytest.fixture(scope="module")
def throws():
    return flown()


RULES = [
    {}, {"window": 0.01}, {"window": 0.03, "margin": 0.5}, {"hand_cap": 0.08}, {"clear_distance": 0.0, "hand_cap": 1.0},
    {"clearance": 0.02, "margin": 0.9}, {"ceiling": 0.05}, {"ceiling": 0.15},
]  # fmt: skip


@pytest.mark.parametrize("changes", with_nightly(RULES, [RULES[0], RULES[2], RULES[5]]))
def test_limits_and_rules_are_kept_at_10_khz_whatever_they_are(changes):
    found = flown(**changes)
    context, rules = found.context, found.mover.rules
    assert found.curved.mean() > 0.9
    check = check_throw(
        found.path,
        found.motion.release_time,
        context.target,
        LimitRows.t3kr(context.objects.percent),
        context.ceiling,
        rules,
    )
    bad = ~check.keeps_rules(landing=1e-9) & found.curved
    assert not bad.any(), {name: value[bad] for name, value in check._asdict().items()}
    np.testing.assert_allclose(found.path.end, found.following, rtol=0, atol=1e-9)
    np.testing.assert_allclose(found.path.knots.velocity[:, -1], 0.0, atol=1e-9)
    np.testing.assert_allclose(found.path.knots.acceleration[:, -1], 0.0, atol=1e-8)


def test_the_told_release_is_that_of_the_path_and_hits(throws):
    plan, context = throws.context.plan, throws.context
    at = throws.path.sample(throws.motion.release_time[:, None])
    np.testing.assert_allclose(at.position[:, 0], plan.position, rtol=0, atol=1e-11)
    np.testing.assert_allclose(at.velocity[:, 0], plan.velocity, rtol=0, atol=1e-10)
    np.testing.assert_allclose(at.acceleration[:, 0], 0.0, atol=1e-8)
    t = plan.flight_time[:, None]
    landing = plan.position + t * plan.velocity - t * t * [0.0, 0.0, 0.5 * GRAVITY]
    np.testing.assert_allclose(landing, context.target, rtol=0, atol=1e-10)
    assert (plan.velocity[:, 2] < GRAVITY * plan.flight_time).all()
    assert (plan.position[:, 2] <= context.ceiling + 1e-12).all()


def test_the_hand_comes_down_vertically_on_the_next_pick(throws):
    duration = throws.path.duration[:, None]
    for before in (0.005, 0.01, 0.02):
        place = throws.path.sample(duration - before).position[:, 0]
        near = (place[:, 2] < throws.following[:, 2] + 0.04) & throws.curved
        assert near.any()
        np.testing.assert_allclose(place[near, :2], throws.following[near, :2], rtol=0, atol=1e-9)


def test_an_impossible_pick_is_told_and_disturbs_no_other(throws):
    context, mover = throws.context, throws.mover
    target, ceiling = context.target.copy(), context.ceiling.copy()
    target[1, 2] += 5.0
    ceiling[3] = context.pick[3, 2] - 0.05
    found = mover.plan(context.pick, target, LimitRows.t3kr(context.objects.percent), ceiling)
    good = np.ones(COUNT, dtype=bool)
    good[[1, 3]] = False
    np.testing.assert_array_equal(mover.is_feasible(context.pick, found, LimitRows.t3kr(context.objects.percent)), good)
    for name in ("position", "velocity", "flight_time", "straight"):
        np.testing.assert_array_equal(getattr(found, name)[good], getattr(context.plan, name)[good], name)
    assert np.isnan(found.position[~good]).all()
