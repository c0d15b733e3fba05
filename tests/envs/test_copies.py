"""An environment is copied with its state: the copy goes on bit for bit as the original does, whoever moves first."""

import copy
import json
import pickle
from collections.abc import Callable
from itertools import product
from pathlib import Path
from typing import Any

import cloudpickle
import gymnasium as gym
import numpy as np
import pytest

import pnt_gym
from pnt_gym.cells.conveyor.config import ConveyorConfig
from tests.tools.nightly import with_nightly
from tests.tools.throws import HARD, LINE, arrays_of, same_bits, same_step, some_actions, zeros
from tests.tools.vectors import assert_alike

STEPS = 2


def pickled(env: Any) -> Any:
    return pickle.loads(pickle.dumps(env))


def cloudpickled(env: Any) -> Any:
    return pickle.loads(cloudpickle.dumps(env))


COPIES: tuple[Callable[[Any], Any], ...] = (pickled, cloudpickled, copy.deepcopy)
LEVELS = {**HARD, "OneJointAssembly-v0": "ideal"}
"""An assembly is in mid-episode only after a first success."""
CASES = [*product(pnt_gym.ENV_IDS, COPIES)]
DAILY = [case for case in CASES if case[1] is pickled or case[0] in ("PnTConveyor-v0", *LINE)]
"""All environments pickled; where an episode has several throws or decisions, copied in all ways."""


def actions(env_id: str, *shape: int) -> np.ndarray:
    share = 0.005 if env_id == "OneJointAssembly-v0" else 0.5
    return some_actions(env_id, np.random.default_rng(0), STEPS, *shape, share=share)


def single(env_id: str) -> Any:
    """An environment in mid-episode where episodes have more than one throw."""
    env = gym.make(env_id, level=LEVELS[env_id]).unwrapped
    env.reset(seed=4)
    *_, terminated, _, _ = env.step(zeros(env_id))
    if terminated:
        env.reset()
    return env


def _bits(observation: Any) -> list[bytes]:
    """The bits of an observation: an array, or a mapping of arrays."""
    return [array.tobytes() for array in arrays_of(observation)]


def go_on(env: Any, env_id: str) -> list[Any]:
    """What an environment gives from here on, across the ends of episodes."""
    given: list[Any] = []
    for action in actions(env_id):
        observation, *rest = env.step(action)
        given.append((_bits(observation), repr(rest)))  # NaN is not equal to itself
        if rest[1] or rest[2]:
            given.append(_bits(env.reset()[0]))
    return [*given, _bits(env.reset()[0]), env.np_random.random()]


@pytest.mark.parametrize(("env_id", "copied"), with_nightly(CASES, DAILY))
def test_a_copy_goes_on_as_the_original_does(env_id, copied):
    env = single(env_id)
    other, later = copied(env), copied(env)
    expected = go_on(env, env_id)
    assert go_on(other, env_id) == expected
    assert go_on(later, env_id) == expected  # the original's throws did not touch it


@pytest.mark.parametrize(("env_id", "copied"), with_nightly(CASES, DAILY))
def test_a_copy_of_a_vector_goes_on_as_the_original_does(env_id, copied):
    env = gym.make_vec(env_id, num_envs=3, level=LEVELS[env_id]).unwrapped
    env.reset(seed=4)
    env.step(zeros(env_id, 3))
    other = copied(env)
    for action in actions(env_id, 3):
        assert_alike(env.step(action), other.step(action))
    assert_alike(env.reset(), other.reset())


def test_a_copy_of_a_copy_and_one_under_wrappers():
    env = gym.make("PnTConveyor-v0")
    env.reset(seed=1)
    env.step(zeros("PnTConveyor-v0"))
    other = pickled(copy.deepcopy(env))
    a, b = env.step(zeros("PnTConveyor-v0")), other.step(zeros("PnTConveyor-v0"))
    assert same_step(a, b)


def test_a_copy_that_is_looked_at_keeps_its_throws(opengl):
    env = gym.make("PnTRelease-v0", render_mode="rgb_array").unwrapped
    env.reset(seed=1)
    other = pickled(env)
    picture = env.render()
    assert same_bits(other.render(), picture)
    assert env.step(zeros("PnTRelease-v0"))[1] == other.step(zeros("PnTRelease-v0"))[1]
    env.close()
    assert other.render().shape == picture.shape  # the views are not shared
    other.close()


# What Gymnasium keeps of how an environment was made.


def written(tmp_path: Path) -> Path:
    path = tmp_path / "mine.yaml"
    path.write_text("mismatch: 0.25\n")
    return path


@pytest.mark.parametrize(
    "level",
    [
        lambda folder: "waste",
        lambda folder: ConveyorConfig.load("waste", mismatch=0.5),
        written,
        lambda folder: str(written(folder)),
        lambda folder: {"base": "waste", "mismatch": 0.5},
        lambda folder: {"bins": {"random": {}}, "limits": {"percent": (30, 40)}},
    ],
    ids=("name", "config", "path", "file", "mapping", "nested mapping"),
)
def test_a_spec_is_written_as_json_and_makes_the_same_environment_again(level, tmp_path):
    env = gym.make("PnTRelease-v0", level=level(tmp_path), action_mode="virtual_goal")
    text = env.spec.to_json()
    assert json.loads(text)["id"] == "PnTRelease-v0"
    again = gym.make(gym.envs.registration.EnvSpec.from_json(text))
    assert again.unwrapped.core.config == env.unwrapped.core.config
    assert again.unwrapped.core.action_mode == "virtual_goal"
    assert same_bits(env.reset(seed=2)[0], again.reset(seed=2)[0])
