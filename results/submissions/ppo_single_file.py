"""The policy that `python examples/10_ppo.py PnTRelease-v0 --level waste --flight --steps 100000 --save FILE` saves."""

from pathlib import Path

import numpy as np


class SingleFile:
    """The mean action of a network of two hidden layers, whose numbers lie beside this file."""

    name = "ppo_single_file"

    def __init__(self):
        with np.load(Path(__file__).with_suffix(".npz"), allow_pickle=False) as file:
            self.layers = [(file[f"policy.{k}.weight"].T, file[f"policy.{k}.bias"]) for k in (0, 2, 4)]

    def reset(self, seed):
        """Nothing to forget."""

    def learn(self, outcome):
        """Nothing: it has learned before."""

    def act(self, observation):
        """One correction (N, 2) for each throw: along, across."""
        value = observation.features.astype(float)
        for weight, bias in self.layers[:2]:
            value = np.tanh(value @ weight + bias)
        weight, bias = self.layers[2]
        return np.clip(value @ weight + bias, -1.0, 1.0)
