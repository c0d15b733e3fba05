"""New policies start at the analytic planner, and hyperparameters that do not fit are explained."""

from pathlib import Path

import numpy as np
import pytest
import torch

import pnt_gym
from agents.ground.cli import UsageError
from agents.learning.hyperparameters import RESIDUAL, hyperparameters, policy_arguments
from agents.learning.sb3 import build
from agents.learning.vec_env import SameStepVecEnv
from agents.learning.windows import DecisionWindow
from tests.tools.toy_cell import ToyVectorEnv


@pytest.mark.parametrize("algo", RESIDUAL)
def test_first_policy_is_the_analytic_planner(algo: str) -> None:
    env = SameStepVecEnv(ToyVectorEnv(4))
    model = build(algo, env, hyperparameters(algo, "PnTRelease-v0"), 0)
    action, _ = model.predict(env.reset(), deterministic=True)
    assert np.abs(action).max() < 0.02  # 4 mm of 200


@pytest.mark.parametrize("algo", RESIDUAL)
def test_shipped_hyperparameters_fit_every_environment(algo: str) -> None:
    for env_id in pnt_gym.ENV_IDS:
        # A step with pictures may be the first of two.
        usual = 1.0 if env_id == "PnTGrasp-v0" and algo in ("sac", "ppo") else 0.0
        assert hyperparameters(algo, env_id)["gamma"] == usual
    assert hyperparameters(algo, "theirs:Own-v0") == hyperparameters(algo, "OneJointThrow-v0")


def test_an_environment_in_a_module_has_the_entry_of_its_id(tmp_path: Path) -> None:
    file = tmp_path / "own.yml"
    file.write_text("default: {gamma: 0.5}\nOwn-v0: {gamma: 0.1}\n")
    assert hyperparameters("sac", "theirs:Own-v0", file) == {"gamma": 0.1}
    assert hyperparameters("sac", "theirs:Other-v0", file) == {"gamma": 0.5}


def test_policy_arguments_are_read_and_never_run():
    read = policy_arguments("dict(net_arch=[64, 32], activation_fn=nn.SiLU)")
    assert read == {"net_arch": [64, 32], "activation_fn": torch.nn.SiLU}
    for text in ("__import__('os')", "dict(a=open('x'))", "dict(", "dict(a=nn.NoSuchLayer)"):
        with pytest.raises(UsageError, match="policy_kwargs"):
            policy_arguments(text)


@pytest.mark.parametrize("lines", [1, DecisionWindow.size, DecisionWindow.size + 1])
def test_progress_is_told_however_many_lines_decide_at_once(lines: int) -> None:
    window = DecisionWindow()
    infos = [{"is_success": True, "value": 0.5, "dt": 2.0}] * lines
    for _ in range(3):
        assert window.add(infos, [1.0] * lines) == (1.0, 15.0, 1.0)
