"""The adapter keeps the conventions of stable-baselines3."""

from itertools import product
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode
from sb3_contrib import MaskablePPO
from stable_baselines3 import PPO, SAC
from stable_baselines3.common.vec_env import VecEnv, VecMonitor, VecNormalize

import pnt_gym
from agents.ground.cli import UsageError
from agents.learning.vec_env import SameStepVecEnv
from tests.tools.toy_cell import ToyVectorEnv


def steps(env: SameStepVecEnv, count: int, action: float = 0.0) -> list[tuple[Any, ...]]:
    return [env.step(np.full((env.num_envs, 2), action, dtype=np.float32)) for _ in range(count)]


def test_one_throw_episodes_terminate() -> None:
    env = SameStepVecEnv(ToyVectorEnv(4))
    assert env.reset().shape == (4, 26)
    observation, reward, done, infos = steps(env, 1)[0]
    assert (observation.shape, observation.dtype) == ((4, 26), np.float32)
    assert (reward.shape, reward.dtype) == ((4,), np.float32)
    assert done.dtype == bool
    assert done.all()
    assert len(infos) == 4
    for i, info in enumerate(infos):
        assert isinstance(info["is_success"], bool)
        assert not info["TimeLimit.truncated"]
        assert info["episode"]["r"] == pytest.approx(reward[i], abs=1e-6)
        assert info["episode"]["l"] == 1
        assert info["terminal_observation"].shape == (26,)


def test_shifts_are_truncated_and_their_returns_summed() -> None:
    env = SameStepVecEnv(ToyVectorEnv(3, steps=5))
    env.reset()
    done_steps = steps(env, 10)
    for start in (0, 5):
        episode = done_steps[start : start + 5]
        assert [bool(step[2].all()) for step in episode] == [False] * 4 + [True]
        assert not any(
            key in info for step in episode[:4] for info in step[3] for key in ("episode", "terminal_observation")
        )
        for i, info in enumerate(episode[-1][3]):
            assert info["TimeLimit.truncated"]
            assert info["episode"]["l"] == 5
            assert info["episode"]["r"] == pytest.approx(sum(step[1][i] for step in episode), abs=1e-5)


def test_seeds_name_the_stream() -> None:
    env = SameStepVecEnv(ToyVectorEnv(3))
    env.seed(7)
    first = env.reset()
    later = env.reset()
    env.seed(7)
    assert np.array_equal(env.reset(), first)
    assert not np.array_equal(first, later)
    assert np.array_equal(first, ToyVectorEnv(3).reset(seed=7)[0])


def test_attributes_and_methods_reach_the_environment() -> None:
    env = SameStepVecEnv(ToyVectorEnv(3))
    assert env.get_attr("steps") == [1, 1, 1]
    env.set_attr("steps", 4)
    assert env.get_attr("steps", [0]) == [4]
    assert env.env_is_wrapped(VecMonitor) == [False] * 3
    assert len(env.get_images()) == 3


def test_other_reset_modes_are_refused() -> None:
    class NextStep(ToyVectorEnv):
        metadata = {"autoreset_mode": AutoresetMode.NEXT_STEP}  # noqa: RUF012 - Gymnasium's own form

    with pytest.raises(UsageError, match="SAME_STEP"):
        SameStepVecEnv(NextStep(2))


@pytest.mark.parametrize("env_id", pnt_gym.ENV_IDS)
def test_cells_keep_to_their_spaces(env_id: str) -> None:
    cells = pnt_gym.sb3_vec_env(env_id, num_envs=3)
    assert isinstance(cells, VecEnv)
    space: Any = cells.observation_space
    seen: list[Any] = [cells.reset()]
    seen += [cells.step(np.stack([_valid(cells, row) for row in range(3)]))[0] for _ in range(3)]
    for observation, row in product(seen, range(3)):
        one = {k: v[row] for k, v in observation.items()} if isinstance(observation, dict) else observation[row]
        assert space.contains(one)


def _valid(cells: Any, row: int) -> Any:
    """A random action that may be chosen."""
    space = cells.action_space
    if isinstance(space, gym.spaces.Discrete):
        return space.sample(cells.env_method("action_masks")[row].astype(np.int8))
    return space.sample()


@pytest.mark.parametrize(
    ("model", "policy", "env_id"),
    [
        (SAC, "MlpPolicy", "PnTConveyor-v0"),
        (PPO, "MultiInputPolicy", "PnTGrasp-v0"),
        (MaskablePPO, "MlpPolicy", "PnTLine-v0"),
    ],
)
def test_models_learn_on_cells(model: Any, policy: str, env_id: str) -> None:
    cells: Any = pnt_gym.sb3_vec_env(env_id, num_envs=2)
    if model is SAC:
        cells = VecNormalize(VecMonitor(cells))
        model(policy, cells, learning_starts=4, batch_size=4).learn(16)
    else:
        model(policy, cells, n_steps=8, batch_size=8).learn(16)


def test_the_door_says_what_is_wrong() -> None:
    with pytest.raises(UsageError, match="did you mean 'level'"):
        pnt_gym.sb3_vec_env("PnTRelease-v0", levle="waste")
    with pytest.raises(UsageError, match="made already"):
        pnt_gym.sb3_vec_env(ToyVectorEnv(2), level="waste")
    with pytest.raises(UsageError, match="an id or a vector environment"):
        pnt_gym.sb3_vec_env(gym.make("PnTRelease-v0"))
    assert pnt_gym.sb3_vec_env(ToyVectorEnv(2)).num_envs == 2
