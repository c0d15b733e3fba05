"""Same seed, same bits: threads, processes and the world's own random numbers change nothing."""

import hashlib
import json
import random

import gymnasium as gym
import numpy as np
import pytest

import pnt_gym
from tests.tools.commands import run_python
from tests.tools.nightly import with_nightly
from tests.tools.throws import HARD, arrays_of, same_bits, same_step, some_actions, zeros

SCRIPT = """
import json, sys
from tests.envs.test_determinism import throws
print(json.dumps({env_id: throws(env_id, 2) for env_id in sys.argv[1:]}))
"""
NAMES = ("landing_error", "cycle_time", "peak_torque", "energy", "value", "action_mask")
"""What infos tell to many digits, each where it is told at all."""


DAILY = ("PnTAdapt-v0", "OneJointSort-v0", "GripperToss-v0", "PnTLine-v0", "PnTGrasp-v0")
"""An environment of every robot, the line of them, and the cell that grasps."""


@pytest.fixture(scope="module")
def elsewhere(request):
    """What every environment of this run gives in another process, with two threads."""
    ids = sorted({item.callspec.params["env_id"] for item in request.session.items if "elsewhere" in item.fixturenames})
    return json.loads(run_python("-c", SCRIPT, *ids, check=True).stdout)


def throws(env_id, threads, seed=4):
    env = gym.make_vec(env_id, num_envs=3, level=HARD[env_id], threads=threads)
    rng, digest = np.random.default_rng(0), hashlib.sha256()
    for array in arrays_of(env.reset(seed=seed)[0]):
        digest.update(array.tobytes())
    for _ in range(3):
        observation, reward, *_, info = env.step(some_actions(env_id, rng, 3))
        for array in (*arrays_of(observation), reward, *(info[name] for name in NAMES if name in info)):
            digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


@pytest.mark.parametrize("env_id", with_nightly(pnt_gym.ENV_IDS, DAILY))
def test_threads_processes_and_repetition_give_the_same_bits(env_id, elsewhere):
    here = throws(env_id, 1)
    assert throws(env_id, 1) == here
    assert throws(env_id, 2) == here
    assert throws(env_id, 1, seed=5) != here
    assert elsewhere[env_id] == here


@pytest.mark.parametrize("env_id", pnt_gym.ENV_IDS)
def test_a_reset_with_a_seed_forgets_everything_before(env_id):
    fresh, used = (gym.make(env_id, level=HARD[env_id]) for _ in range(2))
    used.reset(seed=1)
    for _ in range(3):
        used.step(some_actions(env_id, np.random.default_rng(0)))
        used.reset()
    a, b = fresh.reset(seed=9)[0], used.reset(seed=9)[0]
    assert same_bits(a, b)
    for _ in range(3):
        a, b = (env.step(zeros(env_id)) for env in (fresh, used))
        assert same_step(a, b)
        if a[2]:
            assert same_bits(fresh.reset()[0], used.reset()[0])


def test_global_random_states_are_neither_used_nor_touched():
    rewards = []
    for world in (0, 1):
        np.random.seed(world)  # noqa: NPY002 - the state that must not matter
        random.seed(world)
        before = np.random.get_state()[1].copy(), random.getstate()  # noqa: NPY002
        env = gym.make("PnTConveyor-v0")
        env.reset(seed=3)
        rewards.append(env.step(np.zeros(2, dtype=np.float32))[1])
        assert np.array_equal(np.random.get_state()[1], before[0])  # noqa: NPY002
        assert random.getstate() == before[1]
    assert rewards[0] == rewards[1]


def test_an_environment_draws_from_its_own_generator():
    """A third party that draws from `np_random` shifts the stream, as Gymnasium promises."""
    one, two = (gym.make("PnTRelease-v0").unwrapped for _ in range(2))
    one.reset(seed=3)
    two.reset(seed=3)
    two.np_random.random()
    one.step(np.zeros(2))
    two.step(np.zeros(2))
    assert not same_bits(one.reset()[0], two.reset()[0])
