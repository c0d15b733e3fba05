"""A training loop of your own in one file: a Gaussian policy and its gradient on the vector environment."""

import sys

import gymnasium as gym
import torch
from torch import nn

import pnt_gym  # noqa: F401

updates, cells = int(sys.argv[1]) if len(sys.argv) > 1 else 40, 32
env = gym.make_vec("PnTRelease-v0", num_envs=cells, level="waste")
torch.manual_seed(0)
mean = nn.Sequential(nn.Linear(env.single_observation_space.shape[0], 64), nn.Tanh(), nn.Linear(64, 2), nn.Tanh())
nn.init.zeros_(mean[2].weight)  # begin with the planner's own throw
nn.init.zeros_(mean[2].bias)
optimizer = torch.optim.Adam(mean.parameters(), lr=3e-3)
baseline, observations = None, torch.as_tensor(env.reset(seed=0)[0])

for update in range(updates):
    policy = torch.distributions.Normal(mean(observations), 0.2)
    action = policy.sample()
    following, reward, _, _, info = env.step(action.clamp(-1, 1).numpy())
    reward = torch.as_tensor(reward, dtype=torch.float32)
    baseline = reward.mean() if baseline is None else 0.9 * baseline + 0.1 * reward.mean()
    loss = -((reward - baseline) * policy.log_prob(action).sum(axis=1)).mean()
    optimizer.zero_grad()
    loss.backward()
    optimizer.step()
    observations = torch.as_tensor(following)
    if update % 5 == 4:
        print(f"after {(update + 1) * cells} throws: reward {baseline:.2f}, {info['is_success'].mean():.0%} succeed")
