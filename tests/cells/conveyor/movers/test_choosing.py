"""Throwing some objects and putting others down: as each mover alone would, by the rule or as the action says."""

from itertools import product

import gymnasium as gym
import numpy as np
import pytest

from pnt_gym.arrays import take
from pnt_gym.cells.base.catalogue import LIGHT_ITEMS
from pnt_gym.cells.conveyor.action import modes_of
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.movers.placing import EllipseMover, is_at_rest
from pnt_gym.cells.conveyor.movers.straight import StraightMover
from pnt_gym.errors import ConfigError
from pnt_gym.planning.motion.limits import LimitRows
from pnt_gym.planning.motion.trajectory import JerkTrajectory
from tests.tools.nightly import with_nightly
from tests.tools.throws import PLAIN, make_core, vary

COUNT = 40
HARD_TO_REACH = {"fixed": [{"name": "only", "x": 0.0, "y": 0.85, "size": [0.34, 0.34]}]}


def core_of(picks="independent", mode="release_point", **changes):
    return make_core(vary("light", **{**PLAIN, **changes}), COUNT, picks=picks, mode=mode)


def is_light(core):
    return np.isin([core.item_names[kind] for kind in core.context.kind], LIGHT_ITEMS)


def paths(mover, context, following):
    motion = mover.throw(context.pick, context.plan, context.throw_limits, context.ceiling)
    back = mover.back(motion, following, LimitRows.t3kr(context.objects.percent))
    return JerkTrajectory.concatenate(motion.pick, [motion.segments, back])


FLOWN = [*product(("belt", "independent"), ("full", "flight"))]


@pytest.mark.parametrize(("picks", "fidelity"), with_nightly(FLOWN, [FLOWN[0], FLOWN[3]]))
def test_light_objects_are_put_down_and_nothing_is_missed(picks, fidelity):
    core = core_of(picks, fidelity=fidelity)
    for _ in range(2):
        light, down = is_light(core), is_at_rest(core.context.plan)
        info = core.step(np.zeros((COUNT, 2))).info
        np.testing.assert_array_equal(info["placed"], down)
        assert (light == down).mean() > 0.9  # by what is measured, so that a heavy sheet is thrown
        assert (light & down).any()
        assert (~light & ~down).any()
        assert info["is_success"].mean() > 0.9
        assert np.nanmax(info["landing_error"][down]) < 0.06


def test_each_moves_as_with_the_mover_that_it_is_for():
    core = core_of()
    context = core.context
    following = np.roll(context.pick, 1, axis=0)
    times = np.linspace(0.0, 2.0, 300)
    both, down = paths(core.cell.planner.mover, context, following), is_at_rest(context.plan)
    for rows, mover in ((~down, StraightMover), (down, EllipseMover)):
        alone = paths(mover(core.config, core.cell.planner.workspace), take(context, rows), following[rows])
        np.testing.assert_array_equal(alone.duration, both.duration[rows])
        for one, other in zip(alone.sample(times), take(both, rows).sample(times), strict=True):
            np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("mode", ["release_point", "release_xyz", "virtual_goal", "throw_or_place"])
def test_zero_is_the_plan_however_it_gets_there(mode):
    core = core_of(mode=mode)
    plans, clipped = core.plan(np.zeros((COUNT, core.action_sizes[mode])))
    assert not clipped.any()
    np.testing.assert_allclose(plans.position, core.context.plan.position, atol=1e-9)
    np.testing.assert_allclose(plans.velocity, core.context.plan.velocity, atol=1e-9)


def test_a_choice_takes_the_other_way():
    core = core_of(mode="throw_or_place")
    down = is_at_rest(core.context.plan)
    action = np.zeros((COUNT, 3))
    action[:, 2] = 0.4
    np.testing.assert_array_equal(is_at_rest(core.plan(action)[0]), down)
    action[:, 2] = 1.0
    plans, clipped = core.plan(action)
    np.testing.assert_array_equal(is_at_rest(plans), down ^ ~clipped)
    assert (~clipped).mean() > 0.8
    info = core.step(action).info
    np.testing.assert_array_equal(info["placed"], is_at_rest(plans))
    light = down & ~clipped
    assert np.nanmean(info["landing_error"][light]) > 0.1  # thrown, the air takes them


def test_a_choice_shifts_where_it_lands_too():
    core = core_of(mode="throw_or_place")
    shift = np.tile([0.1, -0.2, 1.0], (COUNT, 1))
    moved, clipped = core.plan(shift)
    plain, other = core.plan(np.tile([0.0, 0.0, 1.0], (COUNT, 1)))
    rows = is_at_rest(moved) & is_at_rest(plain) & ~clipped & ~other
    scale = np.array([core.config.action.along, core.config.action.across])
    along, across = core.context.to_throw_frame(moved.position - plain.position)
    np.testing.assert_allclose(np.stack([along, across], axis=1)[rows], np.tile([0.1, -0.2] * scale, (rows.sum(), 1)))


def test_what_cannot_be_reached_by_the_hand_is_thrown_all_the_same():
    core = core_of(mode="throw_or_place", bins=HARD_TO_REACH, throwable={"drag_area": None})
    action = np.zeros((COUNT, 3))
    action[:, 2] = 1.0
    plans, clipped = core.plan(action)
    assert clipped.all()
    assert not is_at_rest(plans).any()
    assert plans.feasible.all()


def test_only_auto_has_the_choice():
    assert "throw_or_place" in modes_of(ConveyorConfig.load("light").planner)
    with pytest.raises(ConfigError, match="unknown action_mode 'throw_or_place'; known are release_point"):
        gym.make("PnTRelease-v0", action_mode="throw_or_place")
