"""Vector environments whose cells step in parts: the bits of one thread, the rows' own errors, no thread left over."""

import pickle
import threading
import warnings
from copy import deepcopy

import gymnasium as gym
import numpy as np
import pytest

from pnt_gym.cells.base import parallel
from pnt_gym.cells.base.core import Core
from pnt_gym.cells.base.parallel import LEAST_ROWS, ParallelCore, split_cells
from pnt_gym.errors import ActionError, ConfigError, OrderError, PhysicsError
from tests.tools.nightly import with_nightly
from tests.tools.throws import THROWS, same_bits, zeros
from tests.tools.vectors import LEVELS, actions

COUNT = 7
BANDIT = "PnTRelease-v0"

pytestmark = pytest.mark.filterwarnings("ignore:threads is")


@pytest.fixture(autouse=True)
def small_parts(monkeypatch):
    """Parts of a single row, too, so that seven cells are split."""
    monkeypatch.setattr(parallel, "LEAST_ROWS", 1)


def opened(env_id, threads, count=COUNT, **settings):
    return gym.make_vec(env_id, num_envs=count, threads=threads, **{"level": LEVELS[env_id], **settings})


def assert_same(first, second):
    """Two infos have the same keys and the same bits, whatever their masks say."""
    assert first.keys() == second.keys()
    for name, value in first.items():
        if isinstance(value, dict):
            assert_same(value, second[name])
        elif value.dtype == object:
            assert [one is None for one in value] == [one is None for one in second[name]]
            pairs = zip(value, second[name], strict=True)
            assert all(same_bits(one, other) for one, other in pairs if one is not None)
        else:
            assert same_bits(value, second[name]), name


def break_part(env, number, error):
    """Let the throws of a part of the environment's core end with an error; returns a function that mends the part."""
    cell = env.unwrapped.core.parts[number].cell

    def throw(plans):
        raise error

    cell.throw = throw
    return lambda: vars(cell).pop("throw")


@pytest.mark.parametrize("env_id", with_nightly(THROWS, ("PnTAdapt-v0", "OneJointAssembly-v0", "GripperToss-v0")))
@pytest.mark.parametrize("threads", [2, 3, 5])
def test_parts_give_the_bits_of_one_thread(env_id, threads):
    alone, split = opened(env_id, 1), opened(env_id, threads)
    assert isinstance(alone.unwrapped.core, Core)
    assert len(split.unwrapped.core.parts) == threads
    (first, info), (second, info2) = (env.reset(seed=3) for env in (alone, split))
    assert same_bits(first, second)
    assert_same(info, info2)
    for action in actions(env_id, 4):
        (*results, info), (*results2, info2) = (env.step(action[:COUNT]) for env in (alone, split))
        assert all(same_bits(one, two) for one, two in zip(results, results2, strict=True))
        assert_same(info, info2)


@pytest.mark.parametrize("mode", ["SameStep", "NextStep", "Disabled"])
@pytest.mark.parametrize("env_id", ["PnTConveyor-v0", BANDIT])
def test_parts_reset_as_one_thread_does(env_id, mode):
    alone, split = (opened(env_id, threads, autoreset_mode=mode, max_episode_steps=2) for threads in (1, 3))
    assert same_bits(*(env.reset(seed=8)[0] for env in (alone, split)))
    for number, action in enumerate(actions(env_id, 5)):
        (*results, info), (*results2, info2) = (env.step(action[:COUNT]) for env in (alone, split))
        assert all(same_bits(one, two) for one, two in zip(results, results2, strict=True))
        assert_same(info, info2)
        mask = (results[2] | results[3]) & (mode == "Disabled") | (np.arange(COUNT) == number)
        (first, info), (second, info2) = (env.reset(options={"reset_mask": mask}) for env in (alone, split))
        assert same_bits(first, second)
        assert_same(info, info2)


@pytest.mark.parametrize("jitter", [False, True])
def test_parts_preview_plan_and_hide_as_one_thread_does(jitter):
    alone, split = (opened("PnTConveyor-v0", threads) for threads in (1, 3))
    for env in (alone, split):
        env.reset(seed=1)
    one, three = alone.unwrapped.core, split.unwrapped.core
    action = actions("PnTConveyor-v0", 1)[0, :COUNT]
    assert same_bits(one.preview(action, jitter).landing, three.preview(action, jitter).landing)
    assert same_bits(one.plan(action)[0].velocity, three.plan(action)[0].velocity)
    assert same_bits(one.plan(action)[1], three.plan(action)[1])
    assert same_bits(one.context.pick, three.context.pick)
    assert one.hidden().keys() == three.hidden().keys()
    assert all(same_bits(values, three.hidden()[name]) for name, values in one.hidden().items())
    assert (three.cell.target_names, three.cell.episode) == (one.cell.target_names, one.cell.episode)
    assert [quantity.name for quantity in three.cell.hidden] == [quantity.name for quantity in one.cell.hidden]


def test_a_request_is_met_in_all_parts():
    alone, split = opened(BANDIT, 1, level="waste"), opened(BANDIT, 3, level="waste")
    item = alone.unwrapped.core.item_names[1]
    mask = np.arange(COUNT) % 2 == 0
    for env in (alone, split):
        env.reset(seed=2)
    (first, info), (second, info2) = (env.reset(options={"item": item, "reset_mask": mask}) for env in (alone, split))
    assert (info2["kind"][mask] == 1).all()
    assert same_bits(first, second)
    assert_same(info, info2)


def test_a_request_that_one_row_never_draws_changes_no_part():
    """Only an assembly's second throw has this item."""
    hurt, unhurt = (opened("OneJointAssembly-v0", 3) for _ in range(2))
    for env in (hurt, unhurt):
        env.reset(seed=1)
    with pytest.raises(ConfigError, match="item 'tee' did not come"):
        hurt.reset(options={"item": "tee"})
    for action in actions("OneJointAssembly-v0", 2):
        assert all(same_bits(*pair) for pair in zip(*(e.step(action[:COUNT])[:4] for e in (hurt, unhurt)), strict=True))


@pytest.mark.parametrize("number", [0, 1, 2])
def test_an_error_of_a_part_is_told_and_a_reset_heals_all(number):
    env, fresh = opened("PnTConveyor-v0", 3), opened("PnTConveyor-v0", 1)
    env.reset(seed=1)
    mend = break_part(env, number, PhysicsError("MuJoCo warned in simulation 1"))
    cells = ["0 to 2", "3 to 4", "5 to 6"][number]
    with pytest.raises(PhysicsError, match=f"cells {cells}: MuJoCo warned in simulation 1"):
        env.step(zeros("PnTConveyor-v0", COUNT))
    mend()
    with pytest.raises(OrderError, match="the last step failed; reset all cells"):
        env.step(zeros("PnTConveyor-v0", COUNT))
    with pytest.raises(OrderError, match="the last step failed; reset all cells"):
        env.reset(options={"reset_mask": np.arange(COUNT) == 0})
    assert same_bits(env.reset(seed=4)[0], fresh.reset(seed=4)[0])
    for action in actions("PnTConveyor-v0", 3):
        assert same_bits(env.step(action[:COUNT])[0], fresh.step(action[:COUNT])[0])


def test_an_interrupt_waits_for_the_other_parts():
    env = opened(BANDIT, 3)
    env.reset(seed=1)
    break_part(env, 0, KeyboardInterrupt())
    with pytest.raises(KeyboardInterrupt):
        env.step(zeros(BANDIT, COUNT))
    assert not any("pnt_gym part" in thread.name for thread in threading.enumerate())
    with pytest.raises(OrderError, match="the last step failed"):
        env.step(zeros(BANDIT, COUNT))


@pytest.mark.parametrize("wrong", [np.zeros((COUNT, 3)), np.full((COUNT, 2), np.nan)])
def test_an_action_is_refused_before_any_part_throws(wrong):
    env, fresh = opened(BANDIT, 3), opened(BANDIT, 3)
    for one in (env, fresh):
        one.reset(seed=1)
    with pytest.raises(ActionError, match="action"):
        env.step(wrong)
    action = actions(BANDIT, 1)[0, :COUNT]
    assert same_bits(env.step(action)[0], fresh.step(action)[0])


def test_no_thread_is_left_after_a_step():
    before = set(threading.enumerate())
    env = opened(BANDIT, 5)
    env.reset(seed=0)
    env.step(zeros(BANDIT, COUNT))
    assert set(threading.enumerate()) == before
    env.close()
    with pytest.raises(OrderError, match="closed"):
        env.step(zeros(BANDIT, COUNT))


@pytest.mark.parametrize("copied", [deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
def test_a_copy_goes_on_as_the_original_does(copied):
    env = opened("PnTAdapt-v0", 3).unwrapped
    env.reset(seed=0)
    env.step(zeros("PnTAdapt-v0", COUNT))
    again = copied(env)
    for action in actions("PnTAdapt-v0", 3):
        assert same_bits(env.step(action[:COUNT])[0], again.step(action[:COUNT])[0])


def test_settings_of_numpy_hold_in_all_parts():
    core = opened(BANDIT, 3).unwrapped.core
    with np.errstate(over="raise", under="warn"):
        told = core._run(lambda part, rows: np.geterr())
        assert told == [np.geterr()] * 3


@pytest.mark.parametrize(
    ("count", "threads", "parts"),
    [(64, 1, [(64, 1)]), (64, 2, [(32, 1), (32, 1)]), (2 * 16 - 1, 2, [(31, 2)]), (50, 8, [(17, 3), (17, 3), (16, 2)])],
)
def test_cells_and_threads_are_split_evenly(count, threads, parts, monkeypatch):
    monkeypatch.setattr(parallel, "LEAST_ROWS", 16)
    assert split_cells(count, threads) == parts


def test_small_vectors_are_not_split(monkeypatch):
    monkeypatch.setattr(parallel, "LEAST_ROWS", LEAST_ROWS)
    assert isinstance(opened(BANDIT, 2).unwrapped.core, Core)


def test_cells_with_pictures_are_not_split():
    assert isinstance(opened(BANDIT, 2, render_mode="rgb_array").unwrapped.core, Core)
    core = opened(BANDIT, 2).unwrapped.core
    assert isinstance(core, ParallelCore)
    with pytest.raises(ConfigError, match="give a render_mode, or threads=1"):
        core.view()


def test_a_level_that_is_warned_of_is_warned_of_once():
    level = {"bins": {"fixed": [{"name": "near", "x": 0.1, "y": 0.4}, {"name": "far", "x": 0.0, "y": 3.5}]}}
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        opened(BANDIT, 3, level=level)
    assert len([warning for warning in seen if "'far'" in str(warning.message)]) == 1


@pytest.mark.parametrize("form", [gym.make, gym.make_vec])
def test_more_threads_than_cores_are_warned_of(form, monkeypatch):
    monkeypatch.setattr("os.sched_getaffinity", lambda _: {0, 1, 2}, raising=False)
    monkeypatch.setattr("os.cpu_count", lambda: 3)
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        form(BANDIT, threads=3)
        assert not seen
        form(BANDIT, threads=4)
    assert [str(warning.message) for warning in seen] == [
        "threads is 4, more than this process has cores (3); results are the same, and steps take longer"
    ]


def test_two_threads_are_never_warned_of(monkeypatch):
    monkeypatch.setattr("os.sched_getaffinity", lambda _: {0}, raising=False)
    monkeypatch.setattr("os.cpu_count", lambda: 1)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        gym.make_vec(BANDIT)
