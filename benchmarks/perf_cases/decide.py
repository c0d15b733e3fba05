"""Decide in lines by table as often as standard input asks, and print the seconds of each time: of any code state."""

import sys
import time

import gymnasium as gym
import numpy as np

import pnt_gym  # noqa: F401 - registers the environments


def main(level: str, cells: int, threads: int) -> None:
    """Take random choices in `cells` lines; a line of standard input says for how many steps."""
    env = gym.make_vec("PnTLine-v0", num_envs=cells, level=level, threads=threads)
    random, mask = np.random.default_rng(0), env.reset(seed=0)[1]["action_mask"]
    for line in sys.stdin:
        began = time.perf_counter()
        for _ in range(int(line)):
            mask = env.step((random.random(mask.shape) + mask).argmax(axis=1))[-1]["action_mask"]
        print(time.perf_counter() - began, flush=True)


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
