"""A small network fitted to the same labels as the ridge regression: supervised learning from throws.

With many throws its error is the noise floor of the cell, which no observation explains.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any, final

import numpy as np

from pnt_gym.arrays import Floats

from ..ground.fitting import fit_from
from ..policies.networks import Layers, arrays_by_name, layers_from_torch, layers_of, numbers_of, run_layers
from .protocol import State

BATCH = 256


@final
class Mlp:
    """Two hidden layers, Huber loss, AdamW with a cosine schedule.

    Args:
        width: units per hidden layer.
        steps: gradient steps of one fit; None: as many as throws, but 400 to 3000, because few throws are soon
            overfitted.
        learning_rate: learning rate at the start of the schedule.
        weight_decay: weight decay of AdamW.
    """

    libraries: tuple[str, ...] = ("torch",)
    """Optional libraries by which it fits."""

    def __init__(
        self, width: int = 64, steps: int | None = None, learning_rate: float = 3e-3, weight_decay: float = 0.3
    ) -> None:
        self._width, self._steps = width, steps
        self._learning_rate, self._weight_decay = learning_rate, weight_decay
        self._layers: Layers = ()
        self._centre, self._scale = np.zeros(0), np.ones(0)

    def fit(self, features: Floats, shift: Floats, seed: int) -> None:
        """Fit the network to features (N, D) and offsets (N, E)."""
        import torch  # noqa: PLC0415 - a second to import, needed for fitting only

        self._centre, self._scale = shift.mean(axis=0), shift.std(axis=0) + 1e-6
        x = torch.as_tensor(features, dtype=torch.float32)
        y = torch.as_tensor((shift - self._centre) / self._scale, dtype=torch.float32)
        with fit_from(seed):
            network = _network(torch, features.shape[1], self._width, shift.shape[1])
            self._train(torch, network, x, y)
        self._layers = layers_from_torch(network.parameters(), np.float64)

    def predict(self, features: Floats) -> Floats:
        """Offsets (N, E) for features (N, D)."""
        return run_layers(self._layers, "SiLU", features) * self._scale + self._centre

    def state(self) -> State:
        """Weights and biases by layer, and the scale of the labels."""
        return {**arrays_by_name(self._layers), "centre": self._centre, "scale": self._scale}

    def restore(self, state: State) -> None:
        """Load a fit."""
        self._layers = layers_of(state, np.float64)
        self._centre, self._scale = (numbers_of(state[name], 1, np.float64) for name in ("centre", "scale"))

    def _train(self, torch: Any, network: Any, x: Any, y: Any) -> None:
        steps = self._steps or min(max(len(x), 400), 3000)
        optimiser = torch.optim.AdamW(network.parameters(), lr=self._learning_rate, weight_decay=self._weight_decay)
        schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, steps)
        loss_of = torch.nn.HuberLoss()
        batch = min(BATCH, len(x))
        for _ in range(steps):
            rows = torch.randint(len(x), (batch,))
            optimiser.zero_grad()
            loss_of(network(x[rows]), y[rows]).backward()
            optimiser.step()
            schedule.step()


def _network(torch: Any, inputs: int, width: int, outputs: int) -> Any:
    sizes = [inputs, width, width, outputs]
    layers: list[Any] = []
    for before, after in pairwise(sizes):
        layers += [torch.nn.Linear(before, after), torch.nn.SiLU()]
    return torch.nn.Sequential(*layers[:-1])
