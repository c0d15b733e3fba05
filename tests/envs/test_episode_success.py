"""Episodes of several throws end with the share of them that succeeded, in every form of the environments."""

from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from stable_baselines3.common.monitor import Monitor

import pnt_gym  # noqa: F401
from agents.learning.vec_env import SameStepVecEnv

SHIFT = {"base": "waste", "picks_per_shift": 3}
LEVELS: dict[str, dict[str, Any]] = {
    "PnTConveyor-v0": SHIFT,
    "PnTAdapt-v0": {"base": "day", "picks_per_shift": 3},
    "PnTLine-v0": {"base": "skills3", "duration": 6.0},
}
KEY = "episode_success"


def still(env: gym.Env[Any, Any]) -> Any:
    return 0 if isinstance(env.action_space, gym.spaces.Discrete) else np.zeros(env.action_space.shape or ())


@pytest.mark.parametrize("env_id", LEVELS)
def test_the_share_stands_at_the_end_and_only_there(env_id):
    env = Monitor(gym.make(env_id, level=LEVELS[env_id]), info_keywords=(KEY,))
    for seed in (0, 1):
        env.reset(seed=seed)
        successes, over = list[bool](), False
        while not over:
            _, _, terminated, truncated, info = env.step(still(env))
            over = terminated or truncated
            successes.append(info["is_success"])
            assert (KEY in info) == over
        assert info[KEY] == pytest.approx(np.mean(successes))
        assert info["episode"][KEY] == info[KEY]
    env.close()


def test_every_row_has_its_own_share_and_the_adapter_hands_it_on():
    env = gym.make_vec("PnTConveyor-v0", num_envs=4, level=SHIFT)
    adapter = SameStepVecEnv(env)
    adapter.seed(0)
    adapter.reset()
    for _ in range(2):
        steps = [adapter.step(np.zeros((4, 2), dtype=np.float32)) for _ in range(3)]
        assert not any(KEY in info for step in steps[:2] for info in step[3])
        for row, info in enumerate(steps[2][3]):
            assert info[KEY] == pytest.approx(np.mean([step[3][row]["is_success"] for step in steps]))
    adapter.close()


@pytest.mark.parametrize("env_id", ["PnTRelease-v0", "GripperToss-v0"])
def test_an_episode_of_one_throw_has_none(env_id):
    env = gym.make(env_id)
    env.reset(seed=0)
    assert KEY not in env.step(still(env))[4]
