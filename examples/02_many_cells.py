"""Many cells in one batch of simulations: random corrections spoil the planner's throws, and this shows how much."""

import gymnasium as gym
import numpy as np

import pnt_gym  # noqa: F401

STEPS, CELLS = 8, 16
for size in (0.0, 1.0):
    env = gym.make_vec("PnTRelease-v0", num_envs=CELLS, level="waste")
    env.action_space.seed(0)
    env.reset(seed=0)
    hits = [env.step(size * env.action_space.sample())[4]["is_success"] for _ in range(STEPS)]
    print(f"corrections of {size:.0f} times a random one: {100 * np.mean(hits):.0f} % of {STEPS * CELLS} succeed")
    env.close()
