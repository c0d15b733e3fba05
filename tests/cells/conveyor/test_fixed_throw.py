"""The mode `fixed_throw`: an action is the release itself, and nothing of the planner shows."""

import gymnasium as gym
import numpy as np
import pytest

from pnt_gym.arrays import take
from pnt_gym.cells.conveyor import action
from pnt_gym.cells.conveyor.action import FIXED_THROW, FIXED_WAY, FROM_PLANNER, MODES, modes_of
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.observation import TABLE
from pnt_gym.errors import ConfigError, PlanningError
from tests.tools.throws import make_core, same_bits

COUNT, CEILING = 400, 0.10
ENVS = ("PnTConveyor-v0", "PnTAdapt-v0", "PnTRelease-v0")


@pytest.fixture(scope="module")
def core():
    return make_core("waste", COUNT, mode=FIXED_THROW, seed=3)


def action_of(core, plans):
    """The action that asks for given releases, from their places alone."""
    x, y, z = (plans.position - core.context.pick).T
    numbers = np.stack([np.arctan2(-x, y), np.log(np.hypot(x, y) / FIXED_WAY), z - CEILING / 2.0], axis=1)
    return numbers / MODES[FIXED_THROW].scale(core.config)


def test_zero_is_one_throw_for_all_picks(core):
    plans, clipped = core.plan(np.zeros((COUNT, 3)))
    assert not clipped.any()
    way = plans.position - core.context.pick
    np.testing.assert_allclose(way, np.tile([0.0, FIXED_WAY, CEILING / 2.0], (COUNT, 1)), atol=1e-12)


def test_an_action_is_bearing_way_and_rise_of_the_release(core):
    asked = np.random.default_rng(0).uniform(-1, 1, (COUNT, 3))
    plans, clipped = core.plan(asked)
    assert 0.5 < (~clipped).mean() < 1.0
    turned, far = 60.0 * asked[:, 0], 0.0125 * 64.0 ** ((asked[:, 1] + 1.0) / 2.0)
    wanted = np.stack(
        [-far * np.sin(np.radians(turned)), far * np.cos(np.radians(turned)), CEILING * (1.0 + asked[:, 2]) / 2.0],
        axis=1,
    )
    moved = plans.position - core.context.pick
    np.testing.assert_allclose(moved[~clipped], wanted[~clipped], atol=1e-12)
    share = action_of(core, plans)[clipped] / asked[clipped]
    np.testing.assert_allclose(share, np.repeat(share[:, :1], 3, axis=1), atol=1e-6)  # shortened, not turned
    assert ((share > -1e-9) & (share < 1.0)).all()
    assert plans.feasible.all()


def test_the_planners_own_throw_is_an_action(core):
    """What learns in this mode is not kept from throwing as well as the planner."""
    plan = core.context.plan
    asked = action_of(core, plan)
    inside = (np.abs(asked) <= 1.0 + 1e-9).all(axis=1)
    assert inside.mean() > 0.98
    plans, clipped = core.plan(asked)
    assert not clipped[inside].any()
    np.testing.assert_allclose(plans.velocity[inside], plan.velocity[inside], atol=1e-9)


def test_a_throw_does_not_depend_on_target_or_plan(core):
    asked = np.random.default_rng(1).uniform(-1, 1, (COUNT, 3))
    plans, clipped = core.plan(asked)
    context, shuffled = core.context, np.random.default_rng(2).permutation(COUNT)
    try:
        core.cell.context = context.replace(target=context.target[shuffled], plan=take(context.plan, shuffled))
        others, shortened = core.plan(asked)
    finally:
        core.cell.context = context
    assert not np.array_equal(context.target, context.target[shuffled])
    whole = ~(clipped | shortened)  # a bin in the way shortens a throw
    assert whole.mean() > 0.4
    for name in ("position", "velocity", "time", "flight_time"):
        assert same_bits(getattr(plans, name)[whole], getattr(others, name)[whole]), name


@pytest.mark.parametrize("env_id", ENVS)
def test_the_observation_shows_nothing_of_the_planners_throw(env_id):
    level = "day" if env_id == "PnTAdapt-v0" else "waste"
    seen = []
    for mode in ("release_point", FIXED_THROW):
        env = gym.make_vec(env_id, num_envs=4, level=level, action_mode=mode)
        first = env.reset(seed=1)[0]
        names = env.unwrapped.core.cell.table.names
        actions = np.full(env.action_space.shape, 0.1)
        seen.append((first, env.step(actions)[0]))
        env.close()
    hidden = np.isin(names, FROM_PLANNER)
    assert hidden.sum() == (6 if env_id == "PnTAdapt-v0" else 4)
    (first, _), (blank, later) = seen
    assert (first[:, hidden] != 0.0).any()
    assert not blank[:, hidden].any()
    assert not later[:, hidden].any()
    np.testing.assert_array_equal(blank[:, ~hidden], first[:, ~hidden])


def test_every_entry_that_reads_the_plan_is_hidden(core):
    """A feature of the observation that changes with the plan alone tells of it."""
    context = core.context
    mixed = context.replace(plan=take(context.plan, np.roll(np.arange(COUNT), 1)))
    changed = (TABLE.encode(context) != TABLE.encode(mixed)).any(axis=0)
    assert {name for name, column in zip(TABLE.names, changed, strict=True) if column} == {
        name for name in FROM_PLANNER if name in TABLE.names
    }


@pytest.mark.parametrize("env_id", ENVS)
def test_one_cell_gives_the_bits_of_a_row(env_id):
    level = "day" if env_id == "PnTAdapt-v0" else "waste"
    rows = gym.make_vec(env_id, num_envs=3, level=level, action_mode=FIXED_THROW)
    singles = [gym.make(env_id, level=level, action_mode=FIXED_THROW) for _ in range(3)]
    asked = np.random.default_rng(0).uniform(-1, 1, (2, 3, 3)).astype(np.float32)
    first = rows.reset(seed=5)[0]
    for row, single in enumerate(singles):
        assert same_bits(single.reset(seed=5 + row)[0], first[row])
    for actions in asked:
        seen, reward, *_ = rows.step(actions)
        for row, single in enumerate(singles):
            observation, value, terminated, _, _ = single.step(actions[row])
            assert value == reward[row]
            assert terminated or same_bits(observation, seen[row])
        if env_id == "PnTRelease-v0":
            break


def test_the_mode_is_there_where_hands_move_straight():
    for planner in ("straight", "straight_flying"):
        assert FIXED_THROW in modes_of(planner)
    for planner in ("free_direction", "horizontal", "pick_and_place", "ellipse", "auto"):
        assert FIXED_THROW not in modes_of(planner)
    with pytest.raises(ConfigError, match="unknown action_mode 'fixed_throw'; known are release_point"):
        gym.make("PnTRelease-v0", level="light", action_mode=FIXED_THROW)


@pytest.mark.parametrize(
    "level", [name for name in ConveyorConfig.level_names() if name not in ("fast", "fast_plain", "light")]
)
def test_the_fixed_throw_is_possible_in_every_level(level):
    drifts = any(word in level for word in ("day", "steps", "drift"))
    core = make_core(level, 200, mode=FIXED_THROW, picks="belt" if drifts else "independent", feedback=drifts)
    plans, clipped = core.plan(np.zeros((200, 3)))
    assert plans.feasible.all()
    assert not clipped.any()


def test_a_fixed_throw_out_of_reach_is_told_in_one_sentence(core, monkeypatch):
    monkeypatch.setattr(action, "FIXED_WAY", 2.0)
    with pytest.raises(PlanningError, match=r"the fixed throw from the pick at x .* leaves the workspace; use another"):
        core.plan(np.zeros((COUNT, 3)))


def test_no_object_is_carried_into_a_bin_below_its_rim(core):
    """Squeezed between a cup and a wall, an object leaves the range in which the engine is stable."""
    low = np.tile([0.0, 1.0, -1.0], (COUNT, 1))
    plans, clipped = core.plan(low)
    context, config = core.context, core.config
    stop = core.cell.planner.mover.throw(context.pick, plans, context.throw_limits, context.ceiling).stop
    share = np.linspace(0.0, 1.0, 200)[:, None, None]
    way = context.pick + share * (stop - context.pick)
    is_inside = (np.abs(way[..., :2] - context.target[:, :2]) < context.opening / 2.0).all(axis=-1)
    bottom = config.belt.height + (way - context.pick)[..., 2]
    assert clipped.mean() > 0.3
    assert is_inside.any()
    assert (bottom[is_inside] > config.bins.rim).all()


def test_random_throws_are_stable():
    core = make_core("waste", 64, mode=FIXED_THROW, seed=0)
    rng = np.random.default_rng(0)
    for _ in range(6):
        core.step(np.where(rng.random((64, 1)) < 0.5, 1.0, rng.random((64, 1))) * rng.uniform(-1.0, 1.0, (64, 3)))
