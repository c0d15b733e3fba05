"""Importing the package registers the environments, costs neither MuJoCo nor torch, and can be repeated."""

import importlib
import subprocess
import sys

import gymnasium as gym
import numpy as np
import pytest

import pnt_gym
from tests.tools.nightly import with_nightly

HEAVY = ("mujoco", "torch", "stable_baselines3", "scipy", "matplotlib", "imageio")


def run(code):
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0, done.stderr
    return done


def test_importing_the_package_is_cheap():
    script = f"import sys, pnt_gym; print([m for m in {HEAVY} if m in sys.modules])"
    assert run(script).stdout.strip() == "[]"


def test_the_contract_of_the_planner_needs_no_simulator():
    script = "import sys, pnt_gym.planning; print([m for m in ('mujoco', 'torch') if m in sys.modules])"
    assert run(script).stdout.strip() == "[]"


def test_the_ids_are_those_of_the_suite():
    assert set(pnt_gym.ENV_IDS) >= {"PnTConveyor-v0", "PnTAdapt-v0", "PnTRelease-v0"}
    assert len(set(pnt_gym.ENV_IDS)) == len(pnt_gym.ENV_IDS)


@pytest.mark.parametrize("env_id", pnt_gym.ENV_IDS)
def test_entry_points_are_strings(env_id):
    spec = gym.spec(env_id)
    assert isinstance(spec.entry_point, str)
    assert isinstance(spec.vector_entry_point, str)
    assert spec.entry_point.startswith("pnt_gym.envs.")


@pytest.mark.parametrize("env_id", pnt_gym.ENV_IDS)
def test_every_id_can_be_made_single_and_vector(env_id):
    env = gym.make(env_id)
    observation, _ = env.reset(seed=0)
    assert env.observation_space.contains(observation)
    vector = gym.make_vec(env_id, num_envs=2)
    observations, _ = vector.reset(seed=0)
    assert vector.observation_space.contains(observations)
    np.testing.assert_array_equal(observations[0], observation)


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


def test_a_version_is_named():
    assert pnt_gym.__version__.count(".") >= 1


def test_an_environment_can_be_made_from_its_spec():
    env = gym.make("PnTRelease-v0", level="waste", action_mode="virtual_goal")
    again = gym.make(env.spec)
    assert again.unwrapped.core.config.name == "waste"
    assert again.unwrapped.core.action_mode == "virtual_goal"
