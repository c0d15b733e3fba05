"""A Minari dataset of random throws, and a plain regression on it: the yardstick for every learner."""

import os
import subprocess
import sys
from tempfile import TemporaryDirectory

import minari
import numpy as np

import pnt_gym

throws = sys.argv[1] if len(sys.argv) > 1 else "1024"
with TemporaryDirectory() as os.environ["MINARI_DATASETS_PATH"]:
    command = [sys.executable, "-m", "pnt_gym", "dataset", "--throws", throws, "--score-throws", "32"]
    subprocess.run([*command, "--expert", "oracle"], check=True)
    dataset = minari.load_dataset("pnt_gym/release/waste-random-v0")
    episodes = list(dataset.iterate_episodes())
    scale = dataset.recover_environment().unwrapped.core.correction.scale  # landing moved by an action of 1 (2,) [m]
    names = dataset.storage.metadata["columns"]["outcome"]

outcome = np.concatenate([episode.infos["outcome"][1:] for episode in episodes])  # entry 0 is of the reset
landing = outcome[:, [names.index("landing_along"), names.index("landing_across")]]
thrown = (outcome[:, names.index("picked")] == 1.0) & (outcome[:, names.index("dropped")] == 0.0)
misses = (landing - scale * np.concatenate([episode.actions for episode in episodes]))[thrown]  # of the planner alone
x = np.concatenate([episode.observations[:-1] for episode in episodes])[thrown]
design = np.c_[np.ones(len(x)), x]
weights = np.linalg.solve(design.T @ design + np.eye(design.shape[1]), design.T @ misses)


def regression(features):
    """The opposite of the error to expect."""
    return np.clip(-np.c_[np.ones(len(features)), features] @ weights / scale, -1.0, 1.0)


print(f"learned from {len(x)} of {len(thrown)} picks")
for policy in ("analytic", regression):
    figures = pnt_gym.evaluate(policy, "PnTRelease-v0", picks=32, level="waste")
    print(f"{figures['controller']}: {1000 * figures['landing_error_mean_m']:.0f} mm from the target on average")
