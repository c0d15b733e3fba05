"""New policies start at the analytic planner, and hyperparameters that do not fit are explained."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

import pnt_gym
from agents.ground.cli import UsageError
from agents.learning.hyperparameters import hyperparameters, policy_arguments
from agents.learning.progress import MANY, ShiftProgress, Stop
from agents.learning.runs import ALGORITHMS
from agents.learning.sb3 import build
from agents.learning.vec_env import SameStepVecEnv
from tests.tools.toy_cell import ToyVectorEnv

torch.set_num_threads(1)


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


@pytest.mark.parametrize("lines", [1, MANY, MANY + 1])
def test_progress_is_told_however_many_lines_decide_at_once(tmp_path: Path, lines: int) -> None:
    told = ShiftProgress(tmp_path / "progress.csv", 0, Stop(), lambda *_: None)
    told._on_training_start()
    infos = [{"is_success": True, "value": 0.5, "dt": 2.0}] * lines
    for _ in range(3):
        assert told._told(infos, [1.0] * lines) == (1.0, 15.0, 1.0)
