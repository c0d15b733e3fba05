"""The single files of PPO and SAC learn on the vector forms, and the submissions act as what they saved."""

import importlib.util
import sys
from pathlib import Path
from types import SimpleNamespace

import gymnasium as gym
import numpy as np
import pytest
import torch

import pnt_gym
from tests.tools.nightly import with_nightly

ROOT = Path(__file__).resolve().parents[1]


def module_of(path):
    spec = importlib.util.spec_from_file_location(f"file_{path.stem}", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


ppo, sac, cnn = (module_of(ROOT / "examples" / f"{name}.py") for name in ("10_ppo", "11_sac", "12_cnn_grasp"))


def options_of(module, monkeypatch, *words):
    monkeypatch.setattr(sys, "argv", ["example", *map(str, words)])
    return module.arguments()


@pytest.mark.parametrize("env_id", with_nightly(pnt_gym.ENV_IDS, ["PnTConveyor-v0", "PnTLine-v0", "PnTGrasp-v0"]))
def test_ppo_learns_in_every_environment(env_id, monkeypatch):
    options = options_of(ppo, monkeypatch, env_id, "--steps", 32, "--cells", 4, "--rollout", 4)
    torch.manual_seed(options.seed)
    env = ppo.make(options)
    first = ppo.Agent(env.single_observation_space, env.single_action_space).state_dict()
    agent = ppo.train(options)
    moved = {name for name, part in agent.state_dict().items() if not torch.equal(part, first[name])}
    assert {"policy.4.weight", "value.0.weight"} <= moved
    assert ("eye.0.weight" in moved) is agent.sees
    assert all(bool(part.isfinite().all()) for part in agent.state_dict().values())
    action = agent.best(ppo.seen(*env.reset(seed=1)))
    assert env.action_space.contains(action)
    if agent.chooses:
        assert env.unwrapped.core.masks()[np.arange(4), action].all()


@pytest.mark.parametrize("env_id", with_nightly(sac.ENVS, sac.ENVS[::2]))
def test_sac_learns_where_actions_are_numbers(env_id, monkeypatch):
    options = options_of(sac, monkeypatch, env_id, "--steps", 24, "--cells", 4, "--start", 8, "--gamma", 0.5)
    actor = sac.train(options)
    assert bool((actor.net[4].weight != 0.0).any())
    assert all(bool(part.isfinite().all()) for part in actor.state_dict().values())


def test_advantages_are_sums_of_what_comes():
    ones, zeros = torch.ones(3, 1), torch.zeros(3, 1)
    ends = torch.tensor([[0.0], [1.0], [0.0]])
    gain = ppo.advantages(ones, zeros, ends, torch.tensor([10.0]), 1.0)
    later = 1.0 + 10.0  # the value of what is seen last
    assert gain[:, 0].tolist() == pytest.approx([1.0 + ppo.LAMBDA * 1.0, 1.0, later])
    assert ppo.advantages(ones, zeros, ends, torch.tensor([10.0]), 0.0)[:, 0].tolist() == [1.0, 1.0, 1.0]


def test_a_network_learns_to_grasp_from_what_was_tried():
    options = SimpleNamespace(picks=32, updates=4, cells=8, seed=0)
    torch.manual_seed(0)
    first = cnn.Grasper().state()
    grasper = cnn.train(options)
    assert all((part != first[name]).any() and np.isfinite(part).all() for name, part in grasper.state().items())
    env = gym.make_vec("PnTGrasp-v0", num_envs=8)
    assert env.action_space.contains(grasper.act(env.reset(seed=1)[0])[0])


def test_the_places_of_pictures_are_those_of_the_environment():
    env = gym.make("PnTGrasp-v0").unwrapped
    for row, column in ((10, 20), (24, 24), (30, 8)):
        (place,) = np.flatnonzero(np.arange(cnn.SIDE**2) == row // 2 * cnn.SIDE + column // 2)
        np.testing.assert_allclose(cnn.PLACES[place] / cnn.REACH, env.pixel_action(row, column)[:2], atol=1e-6)
    images = torch.rand(1, 5, 48, 48)
    patch = cnn.padded(images).unfold(2, 17, 2).unfold(3, 17, 2)[0, :, 7, 9]
    assert torch.equal(patch[:, 8, 8], images[0, :, 14, 18])
    places, vectors = cnn.Places(), torch.rand(1, 32)
    with torch.no_grad():
        whole, alone = places(cnn.padded(images), vectors), places(patch[None], vectors)
    assert whole.shape == (1, cnn.SIDE, cnn.SIDE)
    assert float(whole[0, 7, 9]) == pytest.approx(float(alone[0, 0, 0]), abs=1e-5)


@pytest.mark.parametrize("name", ["ppo_single_file", "sac_single_file", "cnn_grasp"])
def test_a_submission_acts_as_the_network_that_learned(name):
    theirs = module_of(ROOT / "results" / "submissions" / f"{name}.py")
    (kind,) = [value for value in vars(theirs).values() if isinstance(value, type) and hasattr(value, "act")]
    env = gym.make_vec("PnTGrasp-v0" if name == "cnn_grasp" else "PnTRelease-v0", num_envs=8)
    observation, info = env.reset(seed=0)
    with np.load(ROOT / "results" / "submissions" / f"{name}.npz") as file:
        numbers = {key: torch.as_tensor(file[key]) for key in file.files}
    given = SimpleNamespace(features=observation, image=None)
    if name == "sac_single_file":
        network = sac.Actor(env.single_observation_space.shape[0], 2)
        network.load_state_dict(numbers)
        mine = network.best(torch.as_tensor(observation))
    elif name == "ppo_single_file":
        network = ppo.Agent(env.single_observation_space, env.single_action_space)
        network.load_state_dict(numbers)
        mine = network.best(ppo.seen(observation, info))
    else:
        network = cnn.Grasper()
        for part in ("places", "throws"):
            named = {key.partition(".")[2]: value for key, value in numbers.items() if key.startswith(part)}
            getattr(network, part).load_state_dict(named)
        mine = network.act(observation)[0]
        given = SimpleNamespace(features=observation["vector"], image=observation["image"])
    np.testing.assert_allclose(kind().act(given), mine, atol=1e-5)
    assert np.abs(mine).max() > 0.05
