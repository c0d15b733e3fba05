"""Which throws a planner accepts: the kernels against the motions that the hand would make."""

import numpy as np
import pytest

from pnt_gym.arrays import take
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.planning.motion.kernel import fade
from tests.tools.throws import same_bits

LEVELS = [
    {"base": "nominal"},
    {"base": "waste"},
    {"base": "waste", "motion": {"follow_through": {"window": 0.06, "gravity_share": 0.8}}},
    {"base": "waste_plain"},
    {"base": "nominal_plain", "planner": "horizontal"},
]
COUNT = 400


def plans(level):
    """Many picks of a level with their nominal plans, of which some leave the workspace."""
    planner = PickPlanner(ConveyorConfig.load(level))
    random = np.random.default_rng(0)
    objects, pick = planner.draw_picks([random], np.zeros(COUNT, dtype=np.int64))
    pick[:, :2] += random.uniform(-0.25, 0.25, (COUNT, 2))
    return planner, planner.plan(objects, pick)[0]


def stays_inside(planner, context, release):
    """Whether picks and ends of the motions that `Mover.throw` plans lie in the workspace; virtual picks as well."""
    rows = np.flatnonzero(release.feasible)
    throws, release = take(context, rows), take(release, rows)
    path = planner.mover.throw(throws.pick, release, throws.throw_limits, throws.ceiling).path
    stop = path.sample(path.duration[:, None]).position[:, 0]
    inside = np.zeros(COUNT, dtype=np.bool_)
    inside[rows] = planner.workspace.contains(throws.pick) & planner.workspace.contains(stop)
    belt = planner.config.belt
    if belt.tracking:
        virtual, limits = throws.pick.copy(), throws.throw_limits
        virtual += fade(limits, belt.speed, 0.0).lead
        inside[rows] &= planner.workspace.contains(virtual)
    return inside


@pytest.mark.parametrize("level", LEVELS, ids=lambda level: "-".join(map(str, level.values())))
def test_accepted_are_the_throws_whose_motions_stay_inside_also_to_moved_targets(level):
    planner, context = plans(level)
    shift = np.zeros((COUNT, 3))
    shift[:, :2] = np.random.default_rng(1).uniform(-0.15, 0.15, (COUNT, 2))
    expected = stays_inside(planner, context, context.plan)
    np.testing.assert_array_equal(planner.mover.accepts(context, None), expected)
    for goal in (context.target - shift, context.target + shift):
        expected &= stays_inside(planner, context, planner.mover.aim_at(context, goal, np.inf))
    np.testing.assert_array_equal(planner.mover.accepts(context, shift), expected)
    assert 0.05 < expected.mean() < 0.95


@pytest.mark.parametrize("level", LEVELS[:4], ids=lambda level: "-".join(map(str, level.values())))
def test_the_compiled_choice_among_bins_is_that_of_one_bin_after_the_other(monkeypatch, level):
    planner, context = plans(level)
    chosen, good = planner.plan(context.objects, context.pick)
    monkeypatch.setattr(planner.mover, "choose_targets", lambda *_: None)
    in_turn, accepted = planner.plan(context.objects, context.pick)
    np.testing.assert_array_equal(good, accepted)
    for name in ("target", "opening", "bin", "depth"):
        assert same_bits(getattr(chosen, name), getattr(in_turn, name)), name
    for name in ("position", "velocity", "angle", "feasible", "time"):
        assert same_bits(getattr(chosen.plan, name), getattr(in_turn.plan, name)), name
    assert 0.05 < good.mean() < 1.0
