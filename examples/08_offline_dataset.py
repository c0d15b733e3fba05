"""A dataset of random throws, and what plain regression makes of it: the yardstick for anything that learns."""

import sys

import gymnasium as gym
import numpy as np

import pnt_gym

steps, cells = int(sys.argv[1]) if len(sys.argv) > 1 else 32, 32
env = gym.make_vec("PnTRelease-v0", num_envs=cells, level="waste")
env.action_space.seed(0)
observations, misses = [], []
seen, _ = env.reset(seed=0)
scale = env.core.correction.scale  # what an action of 1 moves the landing by (2,) [m]
for _ in range(steps):
    action = 0.5 * env.action_space.sample()
    following, _, _, _, info = env.step(action)
    observations.append(seen)
    misses.append(np.stack([info["landing_along"], info["landing_across"]], axis=1) - action * scale)
    seen = following

x, y = np.concatenate(observations), np.concatenate(misses)  # the error that the planner alone would have made
design = np.c_[np.ones(len(x)), x]
weights = np.linalg.solve(design.T @ design + np.eye(design.shape[1]), design.T @ y)


def regression(features):
    """The opposite of the error to expect."""
    return np.clip(-np.c_[np.ones(len(features)), features] @ weights / scale, -1.0, 1.0)


print(f"learned from {len(x)} throws")
for policy in ("analytic", regression):
    found = pnt_gym.evaluate(policy, "PnTRelease-v0", picks=32, level="waste")
    print(f"{found['controller']}: {1000 * found['landing_error_mean_m']:.0f} mm from the target on average")
