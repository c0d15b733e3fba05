"""The adapter keeps the conventions of stable-baselines3."""

from typing import Any

import numpy as np
import pytest
from gymnasium.vector import AutoresetMode
from stable_baselines3.common.vec_env import VecMonitor

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
