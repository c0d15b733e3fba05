"""The vector form: how it is made, seeded and reset, that its rows stand alone, and what wrappers make of it."""

import warnings

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv

import pnt_gym
from pnt_gym.errors import ConfigError, OrderError
from tests.tools.throws import CONVEYOR, FEATURES, GRASP, GRIPPER, LINE, MODES, THROWS, rows_of, same_bits, zeros
from tests.tools.vectors import LEVELS, N, actions

SEED = 21


@pytest.fixture(scope="module", params=pnt_gym.ENV_IDS)
def env_id(request):
    return request.param


@pytest.mark.parametrize("env_id", THROWS)
def test_what_is_hidden_of_a_row_is_hidden_of_the_single_environment(env_id):
    env, alone = gym.make_vec(env_id, num_envs=N, level=LEVELS[env_id]), gym.make(env_id, level=LEVELS[env_id])
    env.reset(seed=SEED)
    hidden, names = env.core.hidden(), [one.name for one in env.core.cell.hidden]
    assert [*hidden] == names
    assert len({*names}) == len(names) >= 2
    for row in range(N):
        alone.reset(seed=SEED + row)
        assert {name: values[row] for name, values in hidden.items()} == {
            name: float(value) for name, (value,) in alone.unwrapped.core.hidden().items()
        }
    assert any(len({*values}) == N for values in hidden.values()) or LEVELS[env_id] == "ideal"


def test_make_vec_gives_the_batched_form_without_a_warning(env_id):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env = gym.make_vec(env_id, num_envs=2, level=LEVELS[env_id])
        env.reset(seed=0)
        env.step(env.action_space.sample())
        env.close()
    assert type(env.unwrapped).__name__.endswith("VectorEnv")
    assert not isinstance(env.unwrapped, SyncVectorEnv)
    assert env.metadata["autoreset_mode"] == AutoresetMode.SAME_STEP
    assert env.num_envs == 2
    if env_id not in GRASP:  # which observes a picture too
        assert env.observation_space.shape == (2, FEATURES[env_id])
        assert env.single_observation_space.shape == (FEATURES[env_id],)
    assert env.action_space.shape == zeros(env_id, 2).shape
    assert env.spec.id == env_id


def test_without_autoreset_a_cell_that_is_over_must_be_reset():
    env = gym.make_vec("PnTRelease-v0", num_envs=2, autoreset_mode=AutoresetMode.DISABLED)
    env.reset(seed=0)
    env.step(zeros("PnTRelease-v0", 2))
    env.reset(options={"reset_mask": np.array([True, False])})
    with pytest.raises(OrderError, match=r"cells 1 are over.*reset_mask"):
        env.step(zeros("PnTRelease-v0", 2))
    env.reset(options={"reset_mask": np.array([False, True])})
    env.step(zeros("PnTRelease-v0", 2))


@pytest.mark.parametrize("mode", AutoresetMode)
def test_a_vector_environment_says_how_it_resets(mode):
    assert gym.make_vec("PnTRelease-v0", num_envs=2, autoreset_mode=mode).metadata["autoreset_mode"] is mode


@pytest.mark.parametrize("mode", ["never", None, 1, ["NextStep"]])
def test_no_autoreset_mode(mode):
    with pytest.raises(ConfigError, match=r"unknown autoreset_mode .*NextStep, SameStep, Disabled"):
        gym.make_vec("PnTRelease-v0", num_envs=2, autoreset_mode=mode)


def test_a_row_does_not_depend_on_the_number_of_rows(env_id):
    few, many = (gym.make_vec(env_id, num_envs=count, level=LEVELS[env_id]) for count in (2, 5))
    assert same_bits(few.reset(seed=SEED)[0], rows_of(many.reset(seed=SEED)[0], np.s_[:2]))
    for action in actions(env_id, 3):
        for a, b in zip(few.step(action[:2])[:4], many.step(action[:5])[:4], strict=True):
            assert same_bits(a, rows_of(b, np.s_[:2]))


def test_seeds_may_be_a_list(env_id):
    one, two = (gym.make_vec(env_id, num_envs=N, level=LEVELS[env_id]) for _ in range(2))
    assert same_bits(one.reset(seed=7)[0], two.reset(seed=[7, 8, 9])[0])
    mixed, _ = one.reset(seed=[7, None, 9])
    again, _ = two.reset(seed=7)
    assert same_bits(rows_of(mixed, [0, 2]), rows_of(again, [0, 2]))
    if env_id in (*CONVEYOR, "OneJointThrow-v0", *GRIPPER, *LINE, *GRASP):  # the others draw from two or three goals
        assert not same_bits(rows_of(mixed, 1), rows_of(again, 1))


@pytest.mark.parametrize("drawn", [*CONVEYOR, "OneJointThrow-v0", *GRIPPER, *LINE])
def test_unseeded_rows_differ(drawn):
    """Where what is thrown, or where to, is drawn from a continuum."""
    observation, _ = gym.make_vec(drawn, num_envs=4, level=LEVELS[drawn]).reset()
    assert len({row.tobytes() for row in observation}) == 4


def test_gymnasiums_statistics_wrapper_works(env_id):
    env = gym.wrappers.vector.RecordEpisodeStatistics(gym.make_vec(env_id, num_envs=N, level=LEVELS[env_id]))
    env.reset(seed=0)
    ended, length = np.zeros(N, dtype=bool), 0
    while not ended.any():
        *_, over, cut, info = env.step(actions(env_id)[length, :N])
        ended, length = over | cut, length + 1
    if env_id in THROWS:
        assert length == 2 if env_id in ("PnTConveyor-v0", "PnTAdapt-v0", "OneJointAssembly-v0") else 1
    np.testing.assert_array_equal(info["episode"]["l"][ended], length)
    env.close()


def test_the_other_action_modes_have_a_vector_form(env_id):
    for mode in list(MODES[env_id])[1:]:
        env = gym.make_vec(env_id, num_envs=2, level=LEVELS[env_id], action_mode=mode)
        env.reset(seed=0)
        _, reward, *_ = env.step(env.action_space.sample())
        assert np.isfinite(reward).all()
