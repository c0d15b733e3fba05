"""The adapter keeps the conventions of stable-baselines3, and new policies start at the analytic planner."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from gymnasium.vector import AutoresetMode
from stable_baselines3.common.vec_env import VecMonitor

import pnt_gym
from agents.cli import UsageError
from agents.hyperparameters import hyperparameters, policy_arguments
from agents.runs import ALGORITHMS
from agents.sb3 import SameStepVecEnv, build
from tests.tools.toy_cell import ToyVectorEnv

torch.set_num_threads(1)


def steps(env: SameStepVecEnv, count: int, action: float = 0.0) -> list[tuple[Any, ...]]:
    return [env.step(np.full((env.num_envs, 2), action, dtype=np.float32)) for _ in range(count)]


def test_shapes_and_types() -> None:
    env = SameStepVecEnv(ToyVectorEnv(4))
    assert env.reset().shape == (4, 26)
    observation, reward, done, infos = steps(env, 1)[0]
    assert (observation.shape, observation.dtype) == ((4, 26), np.float32)
    assert (reward.shape, reward.dtype) == ((4,), np.float32)
    assert done.dtype == bool
    assert len(infos) == 4
    assert all(isinstance(info["is_success"], bool) for info in infos)


def test_one_throw_episodes_terminate() -> None:
    env = SameStepVecEnv(ToyVectorEnv(4))
    env.reset()
    _, reward, done, infos = steps(env, 1)[0]
    assert done.all()
    for i, info in enumerate(infos):
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


def test_works_under_sb3s_own_monitor(tmp_path: Path) -> None:
    env = VecMonitor(SameStepVecEnv(ToyVectorEnv(3)), str(tmp_path / "log"), info_keywords=("is_success",))
    env.reset()
    env.step(np.zeros((3, 2), dtype=np.float32))
    assert len((tmp_path / "log.monitor.csv").read_text().splitlines()) == 2 + 3


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


@pytest.mark.parametrize("algo", ALGORITHMS)
def test_first_policy_is_the_analytic_planner(algo: str) -> None:
    env = SameStepVecEnv(ToyVectorEnv(4))
    model = build(algo, env, hyperparameters(algo, "PnTRelease-v0"), 0)
    action, _ = model.predict(env.reset(), deterministic=True)
    assert np.abs(action).max() < 0.02  # 4 mm of 200


@pytest.mark.parametrize("algo", ALGORITHMS)
def test_shipped_hyperparameters_fit_every_environment(algo: str) -> None:
    for env_id in pnt_gym.ENV_IDS:
        assert hyperparameters(algo, env_id)["gamma"] == 0.0
    assert hyperparameters(algo, "theirs:Own-v0") == hyperparameters(algo, "OneJointThrow-v0")


def test_an_environment_in_a_module_has_the_entry_of_its_id(tmp_path: Path) -> None:
    file = tmp_path / "own.yml"
    file.write_text("default: {gamma: 0.5}\nOwn-v0: {gamma: 0.1}\n")
    assert hyperparameters("sac", "theirs:Own-v0", file) == {"gamma": 0.1}
    assert hyperparameters("sac", "theirs:Other-v0", file) == {"gamma": 0.5}


def test_bad_hyperparameters_are_explained(tmp_path: Path) -> None:
    env = SameStepVecEnv(ToyVectorEnv(4))
    with pytest.raises(UsageError, match=r"do not fit sac.*no_such_setting"):
        build("sac", env, {"policy": "MlpPolicy", "no_such_setting": 1}, 0)
    (tmp_path / "one.yml").write_text("PnTRelease-v0: {gamma: 0.0}")
    with pytest.raises(UsageError, match="have no entry for 'Nowhere-v0'; entries are PnTRelease-v0"):
        hyperparameters("sac", "Nowhere-v0", tmp_path / "one.yml")
    with pytest.raises(UsageError, match="cannot read hyperparameters"):
        hyperparameters("sac", "PnTRelease-v0", tmp_path / "none.yml")
    (tmp_path / "bad.yml").write_text("a: [1,")
    with pytest.raises(UsageError, match="not valid YAML"):
        hyperparameters("sac", "PnTRelease-v0", tmp_path / "bad.yml")


def test_policy_arguments_are_read_and_never_run():
    read = policy_arguments("dict(net_arch=[64, 32], activation_fn=nn.SiLU)")
    assert read == {"net_arch": [64, 32], "activation_fn": torch.nn.SiLU}
    for text in ("__import__('os')", "dict(a=open('x'))", "dict(", "dict(a=nn.NoSuchLayer)"):
        with pytest.raises(UsageError, match="policy_kwargs"):
            policy_arguments(text)
