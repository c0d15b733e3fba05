"""A committee of small networks: the expected worth of a try from the features of its place."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final, Self, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Floats, Ints
from pnt_gym.reading import arrays_of

from ..ground.archives import save_arrays
from ..ground.cli import UsageError
from ..ground.fitting import fit_from
from ..policies import networks
from ..policies.networks import Dense, Layers, sigmoid
from .features import NAMES

MEMBERS: Final = 4
WIDTH: Final = 32
BATCH: Final = 256
ARRAY: Final = re.compile(r"(?:weight|bias)_\d_of_\d|columns|centre|scale")
"""Pattern of the names of the arrays in a file."""


@final
class PlaceNetwork:
    """Networks with two hidden layers, fitted together by the same tries in different orders.

    Torch fits the networks; NumPy computes them.

    Args:
        columns: features that the networks see, as indices into `features.NAMES`; None for all.
        inputs: number of features; None for those of `features.NAMES`.
        width: width of the hidden layers.
    """

    libraries: tuple[str, ...] = ("torch",)
    """Optional libraries by which it fits."""

    def __init__(self, columns: Sequence[int] | None = None, inputs: int | None = None, width: int = WIDTH) -> None:
        self._inputs, self._width = len(NAMES) if inputs is None else inputs, width
        self._columns: Ints = np.arange(self._inputs) if columns is None else np.array(columns, dtype=np.int64)
        self._members: tuple[Layers, ...] = ()
        self._centre, self._scale = np.zeros(0), np.ones(0)

    @property
    def is_fitted(self) -> bool:
        """Whether there is anything to predict with."""
        return len(self._members) > 0

    def fit(self, features: Floats, worth: Floats, seed: int, steps: int) -> None:
        """Fit the networks to features (N, D) and worths of tries (N,), each 0 to 1."""
        import torch  # noqa: PLC0415 - a second to import, needed for fitting only

        features = features[:, self._columns]
        self._centre, self._scale = features.mean(axis=0), features.std(axis=0) + 1e-3
        x = torch.as_tensor((features - self._centre) / self._scale, dtype=torch.float32)
        y = torch.as_tensor(worth, dtype=torch.float32)
        with fit_from(seed):
            parameters = _train(torch, _parameters(torch, features.shape[1], self._width), x, y, steps)
        arrays = [parameter.detach().numpy().astype(np.float64) for parameter in parameters]
        self._members = tuple(
            tuple(Dense(arrays[k][member].T, arrays[k + 1][member, 0]) for k in (0, 2, 4)) for member in range(MEMBERS)
        )

    def predict(self, features: Floats) -> Floats:
        """Expected worths (T,) of tries at places with features (T, D)."""
        values = (features[:, self._columns] - self._centre) / self._scale
        total = np.zeros(len(features))
        for layers in self._members:
            total += sigmoid(networks.run(layers, "SiLU", values)[:, 0])
        return total / len(self._members)

    def state(self) -> dict[str, Any]:
        """Arrays by name, for a file."""
        arrays = {
            f"{name}_of_{k}": a for k, one in enumerate(self._members) for name, a in networks.arrays(one).items()
        }
        return {**arrays, "columns": self._columns, "centre": self._centre, "scale": self._scale}

    def restore(self, state: Mapping[str, NDArray[Any]]) -> None:
        """Load a fit; without the array `columns`, the networks see all features.

        Raises:
            ValueError: arrays that do not fit together.
            KeyError: an array is missing.
        """
        members: list[Layers] = []
        for k in range(MEMBERS):
            ending = f"_of_{k}"
            members.append(
                networks.layers({n.removesuffix(ending): a for n, a in state.items() if n.endswith(ending)}, np.float64)
            )
        columns = networks.numbers(state.get("columns", np.arange(self._inputs)), 1, np.int64).astype(np.int64)
        fits = all(layers[0].weight.shape[1] == len(columns) for layers in members)
        if not fits or not set(columns) <= set(range(self._inputs)):
            raise ValueError("features that do not fit to the layers")
        centre, scale = (networks.numbers(state[name], 1, np.float64) for name in ("centre", "scale"))
        if not centre.shape == scale.shape == columns.shape or not (scale > 0.0).all():
            raise ValueError("units that do not fit to the features")
        self._members, self._columns, self._centre, self._scale = tuple(members), columns, centre, scale

    def save(self, path: Path) -> None:
        """Write the arrays to a file."""
        save_arrays(path, self.state())

    @classmethod
    def load(cls, path: Path) -> Self:
        """The networks in a file.

        Raises:
            UsageError: the file is missing, damaged, or of something else.
        """
        network = cls()
        try:
            network.restore(arrays_of(path, ARRAY))
        except Exception:  # a damaged or foreign file may raise anything
            raise UsageError(f"{str(path)!r} holds no networks that choose places") from None
        return network


def _parameters(torch: Any, inputs: int, width: int) -> list[Any]:
    """Weights (members, in, out) and biases (members, 1, out) of three layers, drawn as torch.nn.Linear draws them."""
    parameters: list[Any] = []
    for before, after in ((inputs, width), (width, width), (width, 1)):
        bound = before**-0.5
        for shape in ((MEMBERS, before, after), (MEMBERS, 1, after)):
            parameters.append(torch.empty(shape).uniform_(-bound, bound).requires_grad_())
    return parameters


def _train(torch: Any, parameters: list[Any], x: Any, y: Any, steps: int) -> list[Any]:
    """Minimise the cross entropy of the worths, with AdamW and a cosine schedule; every member has its own batches."""
    optimiser = torch.optim.AdamW(parameters, lr=5e-3, weight_decay=0.05)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, steps)
    loss_of, silu = torch.nn.BCEWithLogitsLoss(), torch.nn.SiLU()
    for _ in range(steps):
        rows = torch.randint(len(x), (MEMBERS, BATCH))
        value = x[rows]
        for k in (0, 2, 4):
            value = torch.baddbmm(parameters[k + 1], value, parameters[k])
            value = silu(value) if k < 4 else value
        optimiser.zero_grad()
        loss_of(value[:, :, 0], y[rows]).backward()
        optimiser.step()
        schedule.step()
    return parameters
