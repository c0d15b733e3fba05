"""Importing the package registers the environments, costs neither MuJoCo nor torch, and can be repeated."""

import importlib

import gymnasium as gym
import pytest

import pnt_gym
from tests.tools.commands import run_python
from tests.tools.nightly import with_nightly

HEAVY = ("mujoco", "torch", "stable_baselines3", "scipy", "matplotlib", "imageio", "numba")


def run(code):
    done = run_python("-c", code)
    assert done.returncode == 0, done.stderr
    return done


def test_importing_package_and_planner_is_cheap():
    script = f"import sys, pnt_gym, pnt_gym.planning; print([name for name in {HEAVY} if name in sys.modules])"
    assert run(script).stdout.strip() == "[]"


@pytest.mark.parametrize("env_id", with_nightly(pnt_gym.ENV_IDS, ["PnTLine-v0"]))
def test_an_id_with_its_module_needs_no_import(env_id):
    script = f"""
import warnings
warnings.simplefilter("error")
import gymnasium as gym
env = gym.make("pnt_gym:{env_id}")
env.reset(seed=0)
print(env.spec.id)
"""
    assert run(script).stdout.strip() == env_id


def test_registering_again_changes_nothing_and_warns_of_nothing(recwarn):
    before = {env_id: gym.registry[env_id] for env_id in pnt_gym.ENV_IDS}
    pnt_gym.register_envs()
    importlib.reload(pnt_gym)
    for env_id, spec in before.items():
        assert gym.registry[env_id] is spec
    assert not list(recwarn)
