"""Cells that are simulated in parts: the bits of one thread, the rows' own errors, and no part that runs on."""

import pickle
import threading
import time
import warnings
from copy import deepcopy

import gymnasium as gym
import numpy as np
import pytest

from pnt_gym.cells.base import parallel
from pnt_gym.cells.base.parallel import LEAST_ROWS, call_in_threads, split_rows
from pnt_gym.errors import ActionError, OrderError, PhysicsError
from tests.tools.throws import CONVEYOR, same_bits, zeros
from tests.tools.vectors import LEVELS, actions, assert_alike

COUNT = 7
BANDIT = "PnTRelease-v0"

pytestmark = pytest.mark.filterwarnings("ignore:threads is")


@pytest.fixture(autouse=True)
def small_parts(monkeypatch):
    """Parts of a single row, too, so that seven cells are split."""
    monkeypatch.setattr(parallel, "LEAST_ROWS", 1)


def opened(env_id, threads, count=COUNT, **settings):
    return gym.make_vec(env_id, num_envs=count, threads=threads, **{"level": LEVELS[env_id], **settings})


def break_part(env, number, error):
    """Let the throws of a part of the cells end with an error; returns a function that mends the part."""
    plant = parts_of(env)[number][1]

    def fly(context, plans):
        raise error

    plant.fly = fly
    return lambda: vars(plant).pop("fly")


def parts_of(env):
    return env.unwrapped.core.cell.plant.parts


@pytest.mark.parametrize("env_id", CONVEYOR)
@pytest.mark.parametrize("threads", [2, 5])
def test_parts_give_the_bits_of_one_thread(env_id, threads):
    alone, split = opened(env_id, 1), opened(env_id, threads)
    assert (len(parts_of(alone)), len(parts_of(split))) == (0, threads)
    assert_alike(*(env.reset(seed=3) for env in (alone, split)))
    for action in actions(env_id, 3):
        assert_alike(*(env.step(action[:COUNT]) for env in (alone, split)))


@pytest.mark.parametrize("threads", [2, 5])
def test_flights_in_parts_give_the_bits_of_one_thread(threads, monkeypatch):
    """Swings and falls in the air are split, and efforts are computed beside them."""
    parts, whole = [], parallel.call_in_threads
    monkeypatch.setattr(parallel, "call_in_threads", lambda calls: parts.append(len(calls)) or whole(calls))
    alone, split = (opened(BANDIT, n, level={"base": "waste", "fidelity": "flight"}) for n in (1, threads))
    assert_alike(*(env.reset(seed=3) for env in (alone, split)))
    for action in actions(BANDIT, 3):
        assert_alike(*(env.step(action[:COUNT]) for env in (alone, split)))
    assert max(parts) == threads


@pytest.mark.parametrize(
    ("env_id", "mode"), [("PnTConveyor-v0", "SameStep"), (BANDIT, "NextStep"), ("PnTConveyor-v0", "Disabled")]
)
def test_parts_reset_as_one_thread_does(env_id, mode):
    alone, split = (opened(env_id, threads, autoreset_mode=mode, max_episode_steps=2) for threads in (1, 3))
    assert same_bits(*(env.reset(seed=8)[0] for env in (alone, split)))
    for number, action in enumerate(actions(env_id, 3)):
        step, other = (env.step(action[:COUNT]) for env in (alone, split))
        assert_alike(step, other)
        mask = (step[2] | step[3]) & (mode == "Disabled") | (np.arange(COUNT) == number)
        assert_alike(*(env.reset(options={"reset_mask": mask}) for env in (alone, split)))


@pytest.mark.parametrize("jitter", [False, True])
def test_parts_preview_as_one_thread_does(jitter):
    alone, split = (opened("PnTConveyor-v0", threads) for threads in (1, 3))
    for env in (alone, split):
        env.reset(seed=1)
    action = actions("PnTConveyor-v0", 1)[0, :COUNT]
    one, three = (env.unwrapped.core.preview(action, jitter) for env in (alone, split))
    assert same_bits(one.landing, three.landing)
    assert same_bits(one.energy, three.energy)


def test_the_recorded_throw_is_that_of_one_thread():
    recordings = []
    for threads in (1, 3):
        env = opened("PnTConveyor-v0", threads)
        env.reset(seed=1)
        plant = env.unwrapped.core.cell.plant
        plant.record_row = 4
        env.step(zeros("PnTConveyor-v0", COUNT))
        recordings.append(plant.recording)
    one, three = recordings
    assert same_bits(one.state, three.state)
    assert same_bits(one.control, three.control)
    assert same_bits(one.model.body_mass, three.model.body_mass)


@pytest.mark.parametrize("number", [0, 1, 2])
def test_an_error_of_a_part_is_told_and_a_reset_heals_all(number):
    env, fresh = opened("PnTConveyor-v0", 3), opened("PnTConveyor-v0", 1)
    env.reset(seed=1)
    mend = break_part(env, number, PhysicsError("MuJoCo warned in simulation 1"))
    cells = ["0 to 1", "2 to 3", "4 to 6"][number]
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
    with pytest.raises(OrderError, match="the last step failed"):
        env.step(zeros(BANDIT, COUNT))
    ends = list[int]()

    def interrupt():
        raise KeyboardInterrupt

    def work():
        time.sleep(0.05)
        ends.append(0)

    with pytest.raises(KeyboardInterrupt):
        call_in_threads([interrupt, work, work])
    assert len(ends) == 2


@pytest.mark.parametrize("wrong", [np.zeros((COUNT, 3)), np.full((COUNT, 2), np.nan)])
def test_an_action_is_refused_before_any_part_throws(wrong):
    env, fresh = opened(BANDIT, 3), opened(BANDIT, 3)
    for one in (env, fresh):
        one.reset(seed=1)
    with pytest.raises(ActionError, match="action"):
        env.step(wrong)
    action = actions(BANDIT, 1)[0, :COUNT]
    assert same_bits(env.step(action)[0], fresh.step(action)[0])


def test_threads_of_one_step_work_in_the_next():
    env = opened(BANDIT, 5)
    env.reset(seed=0)
    env.step(zeros(BANDIT, COUNT))
    before = set(threading.enumerate())
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


def test_settings_of_numpy_hold_in_all_threads():
    with np.errstate(over="raise", under="warn"):
        assert call_in_threads([np.geterr] * 3) == [np.geterr()] * 3


def test_results_come_in_order_and_the_first_error_is_told():
    assert call_in_threads([lambda: 1]) == [1]
    assert call_in_threads([lambda k=k: k for k in range(5)]) == [0, 1, 2, 3, 4]
    with pytest.raises(ZeroDivisionError):
        call_in_threads([int, lambda: 1 / 0, lambda: {}["a"]])


@pytest.mark.parametrize(
    ("count", "threads", "sizes"), [(64, 1, [64]), (64, 2, [32, 32]), (31, 2, [31]), (50, 8, [16, 17, 17]), (1, 2, [1])]
)
def test_rows_are_split_evenly(count, threads, sizes, monkeypatch):
    monkeypatch.setattr(parallel, "LEAST_ROWS", 16)
    parts = split_rows(count, threads)
    assert [part.stop - part.start for part in parts] == sizes
    assert np.array_equal(np.concatenate([np.arange(count)[part] for part in parts]), np.arange(count))


def test_few_cells_and_flights_alone_are_not_split(monkeypatch):
    assert parts_of(opened(BANDIT, 2))
    assert not parts_of(opened(BANDIT, 2, level={"base": "waste", "fidelity": "flight"}))
    monkeypatch.setattr(parallel, "LEAST_ROWS", LEAST_ROWS)
    assert not parts_of(opened(BANDIT, 2, 2 * LEAST_ROWS - 1))
    assert parts_of(opened(BANDIT, 2, 2 * LEAST_ROWS))


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
