"""Step cells at random as often as standard input asks, and print the seconds of each time: of any code state."""

import json
import sys
import time
from typing import Any

import gymnasium as gym
import numpy as np

import pnt_gym  # noqa: F401 - registers the environments


def main(env_id: str, level: Any, cells: int, threads: int) -> None:
    """Take random actions, or random choices of a line; a line of standard input says for how many steps."""
    env: Any = (
        gym.make(env_id, level=level)
        if cells == 1
        else gym.make_vec(env_id, num_envs=cells, level=level, threads=threads)
    )
    random, info = np.random.default_rng(0), env.reset(seed=0)[1]
    for line in sys.stdin:
        began = time.perf_counter()
        for _ in range(int(line)):
            mask = info.get("action_mask")
            drawn = random.random(env.action_space.shape if mask is None else mask.shape)
            *_, terminated, truncated, info = env.step(2.0 * drawn - 1.0 if mask is None else (drawn + mask).argmax(-1))
            if cells == 1 and (terminated or truncated):
                info = env.reset()[1]
        print(time.perf_counter() - began, flush=True)


if __name__ == "__main__":
    main(sys.argv[1], json.loads(sys.argv[2]), int(sys.argv[3]), int(sys.argv[4]))
