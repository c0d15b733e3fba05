"""The free release direction in the cell: legal motion, no second contact, and straight throws where there is none."""

import gymnasium as gym
import numpy as np
import pytest

from pnt_gym.cells.conveyor.movers.straight import StraightMover
from pnt_gym.planning.motion.limits import LimitRows, MotionLimits
from tests.tools.nightly import with_nightly
from tests.tools.throws import is_feasible, make_core, same_bits, vary

FREE = {"planner": "free_direction", "motion": {"follow_through": {"window": 0.0}}}
COUNT = 14


def core_of(level="ideal", picks="belt", count=COUNT, mode="release_point", threads=2, **changes):
    return make_core(vary(level, **{**FREE, **changes}), count, picks=picks, mode=mode, threads=threads)


@pytest.mark.parametrize("picks", with_nightly(("belt", "independent"), ["independent"]))
def test_without_mismatch_every_throw_lands_and_the_cup_never_touches_again(picks):
    core = core_of(picks=picks)
    for _ in range(3):
        assert not core.context.plan.straight.any()
        info = core.step(np.zeros((COUNT, 2))).info
        assert info["landing_error"].max() < 0.010
        assert not info["recontact"].any()
        assert info["is_success"].all()
        assert info["peak_torque"].max() < 530.0


def test_an_impossible_correction_is_shortened_and_stays_legal():
    count, far = 8, {"xyz": [0.6, 0.6, 0.4]}
    core = core_of(level="waste_plain", picks="independent", count=count, mode="release_xyz", action=far)
    action = np.random.default_rng(0).uniform(-1.0, 1.0, (count, 3))
    release, clipped = core.plan(action)
    assert clipped.any()
    assert is_feasible(core, release).all()
    assert np.isfinite(core.step(action).reward).all()


def test_picks_without_a_free_throw_are_thrown_straight_beside_the_others():
    """Little height below the ceiling and a wide margin leave some picks no free release."""
    tight = {"ceiling": 0.05, "follow_through": {"window": 0.0, "margin": 0.9, "hand_cap": 0.0}}
    core = core_of(picks="independent", motion=tight)
    straight = core.context.plan.straight
    assert straight.any() and not straight.all()
    pick, limits = core.context.pick, LimitRows.t3kr(core.context.objects.percent)
    plain = StraightMover(core.config, core.cell.planner.workspace)
    expected = plain.plan(pick, core.context.target, limits, core.context.ceiling)
    assert same_bits(expected.position[straight], core.context.plan.position[straight])
    assert np.isfinite(core.step(np.zeros((COUNT, 2))).reward).all()


def test_a_step_makes_its_limits_once_and_hands_them_on(monkeypatch):
    env = gym.make("PnTConveyor-v0", level="fast")
    env.reset(seed=1)
    calls, arrays = [], MotionLimits.arrays
    monkeypatch.setattr(MotionLimits, "arrays", lambda limits, count: calls.append(count) or arrays(limits, count))
    env.step(np.full(2, 0.1))
    assert not calls
