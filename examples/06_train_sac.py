"""A standard agent on a standard environment: SAC of stable-baselines3, then its worth on held-out throws.

One throw is one episode (a contextual bandit), so gamma is 0. More throws train a better policy: try 3000.
"""

import sys

import gymnasium as gym
from stable_baselines3 import SAC

import pnt_gym

throws = int(sys.argv[1]) if len(sys.argv) > 1 else 300
env = gym.make("PnTRelease-v0", level="waste")
model = SAC("MlpPolicy", env, gamma=0.0, learning_starts=100, policy_kwargs={"net_arch": [64, 64]}, seed=0)
model.learn(throws)

for policy in ("analytic", model):
    figures = pnt_gym.evaluate(policy, "PnTRelease-v0", picks=32, level="waste")
    print(f"{figures['controller']}: {1000 * figures['landing_error_mean_m']:.0f} mm from the target on average")
