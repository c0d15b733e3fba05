"""Gradient steps of SAC without what a discount of 0 makes superfluous: the same bits, and nothing else changes."""

import gymnasium as gym
import numpy as np
import pytest
import torch
from gymnasium.spaces import Box
from stable_baselines3 import SAC
from stable_baselines3.common.logger import KVWriter, Logger
from stable_baselines3.common.vec_env import DummyVecEnv, VecNormalize

from agents.learning.bandit_sac import LOSSES, BanditSAC
from agents.learning.sb3 import ThrownBuffer

ROWS = 4


class Bandit(gym.Env):
    """One throw of two numbers: the nearer to 0.3, the better."""

    observation_space, action_space = Box(-5.0, 5.0, (3,)), Box(-1.0, 1.0, (2,))

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        return self.np_random.normal(size=3).astype(np.float32), {}

    def step(self, action):
        observation = self.np_random.normal(size=3).astype(np.float32)
        return observation, -float(np.abs(action - 0.3).sum()), True, False, {}


class Seen(KVWriter):
    """Keeps what is logged."""

    def __init__(self):
        self.values = []

    def write(self, key_values, key_excluded, step=0):
        self.values.append(key_values)


def trained(kind, steps=96, normalised=False, **settings):
    """A model after a short training, and what it logged."""
    env = DummyVecEnv([Bandit] * ROWS)
    if normalised:
        env = VecNormalize(env, gamma=0.0)
    settings = {"gamma": 0.0, "policy_kwargs": {"net_arch": [8, 8]}, **settings}
    model = kind(
        "MlpPolicy", env, seed=3, batch_size=16, learning_starts=16, gradient_steps=3, device="cpu", **settings
    )
    seen = Seen()
    model.set_logger(Logger(None, [seen]))
    model.learn(steps, log_interval=1)
    return model, seen.values


def weights(model, target=False):
    names = ("actor", "critic", "critic_target") if target else ("actor", "critic")
    return [weight.detach().numpy() for name in names for weight in getattr(model, name).parameters()]


@pytest.mark.parametrize(
    "settings", [{}, {"replay_buffer_class": ThrownBuffer}, {"normalised": True}, {"policy_kwargs": {"n_critics": 3}}]
)
def test_weights_and_losses_are_those_of_sac(settings):
    (lean, logged), (full, logged2) = (trained(kind, **settings) for kind in (BanditSAC, SAC))
    assert all(np.array_equal(one, other) for one, other in zip(weights(lean), weights(full), strict=True))
    assert torch.equal(lean.log_ent_coef, full.log_ent_coef)
    assert lean.num_timesteps == full.num_timesteps
    assert lean._n_updates == full._n_updates > 0
    pairs = [(one, other) for one, other in zip(logged, logged2, strict=True) if "train/actor_loss" in other]
    assert pairs
    for one, other in pairs:
        np.testing.assert_allclose(*([values[f"train/{name}"] for name in LOSSES] for values in (one, other)), 1e-6)


def test_it_learns_and_leaves_target_critics_alone():
    begun, later = trained(BanditSAC, 16)[0], trained(BanditSAC, 600, learning_rate=0.01)[0]
    begin, end = (model.predict(np.zeros((1, 3), dtype=np.float32), deterministic=True)[0] for model in (begun, later))
    assert np.abs(end - 0.3).max() < 0.15 < np.abs(begin - 0.3).max()
    untouched = BanditSAC("MlpPolicy", DummyVecEnv([Bandit] * ROWS), seed=3, policy_kwargs={"net_arch": [8, 8]})
    pairs = zip(later.critic_target.parameters(), untouched.critic_target.parameters(), strict=True)
    assert all(torch.equal(one, other) for one, other in pairs)


@pytest.mark.parametrize("settings", [{"gamma": 0.9}, {"ent_coef": 0.1}, {"use_sde": True}])
def test_other_settings_are_those_of_sac_throughout(settings):
    (lean, _), (full, _) = (trained(kind, **settings) for kind in (BanditSAC, SAC))
    assert all(np.array_equal(one, other) for one, other in zip(weights(lean, True), weights(full, True), strict=True))
