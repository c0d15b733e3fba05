"""Policies learned from given throws, on a toy whose best action is known."""

import numpy as np
import pytest
import torch

from agents.learning import from_data
from agents.learning.from_data import Lesson, behaviour_cloning, iql, td3_bc


def best_action(states):
    return 0.5 * np.tanh(states[:, :2])


def toy(mean, deviation, count=3000):
    """Throws whose reward falls with the distance from the best action, by a behaviour of some mean and deviation."""
    random = np.random.default_rng(3)
    states = random.standard_normal((count, 4)).astype(np.float32)
    actions = np.clip(mean + deviation * random.standard_normal((count, 2)), -1.0, 1.0).astype(np.float32)
    rewards = 1.0 - np.linalg.norm(actions - best_action(states), axis=1) + 0.1 * random.standard_normal(count)
    return Lesson(states, actions, rewards.astype(np.float32))


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    monkeypatch.setattr(from_data, "CRITIC_STEPS", 400)
    monkeypatch.setattr(from_data, "POLICY_STEPS", 200)


def misses(learn, lesson, seed=0):
    states = toy(0.0, 1.0).observations[:500]
    return float(np.linalg.norm(learn(lesson, seed)(states) - best_action(states), axis=1).mean())


def test_imitation_is_as_good_as_what_it_imitates_and_critics_are_better():
    lesson = toy(mean=0.2, deviation=0.4)
    cloned = misses(behaviour_cloning, lesson)
    behaviour = np.linalg.norm(0.2 - best_action(lesson.observations), axis=1).mean()
    assert cloned == pytest.approx(behaviour, abs=0.1)
    assert misses(td3_bc, lesson) < 0.6 * cloned
    assert misses(iql, lesson) < 0.8 * cloned


def test_a_policy_is_the_same_again_and_leaves_the_random_stream_alone(monkeypatch):
    monkeypatch.setattr(from_data, "CRITIC_STEPS", 60)
    monkeypatch.setattr(from_data, "POLICY_STEPS", 60)
    torch.manual_seed(5)
    before = torch.random.get_rng_state()
    lesson = toy(mean=0.0, deviation=0.5, count=300)
    states = lesson.observations[:7]
    first, again, other = (td3_bc(lesson, seed)(states) for seed in (1, 1, 2))
    assert (first == again).all()
    assert not np.allclose(first, other)
    assert torch.equal(torch.random.get_rng_state(), before)
