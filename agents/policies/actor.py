"""A trained policy as arrays of numbers, which acts without the libraries that trained it.

stable-baselines3 puts the features of a picture before the vector beside it (`CombinedExtractor`).

`policy.npz` is a NumPy archive of numbers and two names:

    lstm_in, lstm_kept, lstm_bias     of a recurrent policy: the layer before them, see `Lstm`
    weight_0, bias_0, weight_1, ...   full layers from the observation, or what the former gives, to the action, weights
                                      (outputs, inputs), float32
    activation                        after every layer but the last, a name of `ACTIVATIONS`
    output                            "squashed": tanh, then scaled from [-1, 1] to low and high (SAC, TD3, TQC);
                                      "clipped" to low and high (PPO, RecurrentPPO); "scores" of choices, as they are,
                                      of which the greatest is taken (MaskablePPO)
    bound                             the last layer's numbers are clipped to it on either side before; mostly inf
    low, high                         of the actions
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, NamedTuple, Self, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Floats
from pnt_gym.cells.grasp.config import CHANNELS, PIXELS
from pnt_gym.reading import arrays_of

from ..ground.archives import save_arrays
from ..ground.cli import UsageError
from . import networks
from .networks import ACTIVATIONS, LAYER, LSTM, Array, Convolution, Dense, Layers, Lstm, activate, lstm_of

STRIDES: Final = (4, 2, 1)
"""Steps between the windows of the convolutions, in points."""
ACTIVATION: Final = "ReLU"
"""After every layer."""
PIECES: Final = r"eye_(?:weight|bias)_\d"
"""Names of the arrays of an eye in a file: the convolutions, then the full layer."""


@final
class Eye(NamedTuple):
    """Convolutions of pictures, and a full layer of all points of their maps."""

    convolutions: tuple[Convolution, ...]
    dense: Dense

    @property
    def size(self) -> int:
        """Number of features of a picture."""
        return len(self.dense.bias)

    def __call__(self, images: NDArray[np.uint8]) -> Floats:
        """Features (N, size) of pictures (N, 5, 48, 48)."""
        value: Floats = images / 255.0
        for convolution, stride in zip(self.convolutions, STRIDES, strict=True):
            value = activate(ACTIVATION, convolution(value, stride))
        return activate(ACTIVATION, self.dense(value.reshape(len(images), -1)))

    def arrays(self) -> dict[str, NDArray[np.floating]]:
        """Arrays by name, for a file."""
        parts = enumerate((*self.convolutions, self.dense))
        return {f"eye_{part}_{k}": array for k, layer in parts for part, array in layer._asdict().items()}

    @classmethod
    def of(cls, arrays: Mapping[str, NDArray[Any]]) -> Self | None:
        """The eye among the arrays of a file, if there is one.

        Raises:
            ValueError: the layers do not fit together or to pictures, or are no finite numbers.
            KeyError: an array is missing.
        """
        if not any(name.startswith("eye_") for name in arrays):
            return None
        convolutions = tuple(
            Convolution(networks.numbers(arrays[f"eye_weight_{k}"], 4), networks.numbers(arrays[f"eye_bias_{k}"], 1))
            for k in range(len(STRIDES))
        )
        eye = cls(convolutions, networks.dense(arrays, f"eye_weight_{len(STRIDES)}", f"eye_bias_{len(STRIDES)}"))
        if any(layer.bias.shape != layer.weight.shape[:1] for layer in (*convolutions, eye.dense)):
            raise ValueError("layers that do not fit together")
        eye(np.zeros((1, CHANNELS, PIXELS, PIXELS), np.uint8))  # other misfits raise here
        return eye


OUTPUTS: Final = ("squashed", "clipped", "scores")
PARTS: Final = re.compile(rf"{LAYER}|{PIECES}|{'|'.join(LSTM)}|activation|output|bound|low|high")
"""Names of the arrays in a policy's file."""


@final
@dataclass(frozen=True)
class Actor:
    """The deterministic policy of a training; `policy.npz` holds its attributes."""

    layers: Layers
    activation: str
    output: str
    """One of `OUTPUTS`."""
    bound: float
    low: Array
    high: Array
    lstm: Lstm | None = None
    """LSTM of a recurrent policy; else None."""
    eye: Eye | None = None
    """Convolutions of a policy that sees pictures; else None."""

    def __call__(self, observations: NDArray[Any], images: NDArray[np.uint8] | None = None) -> Array:
        """Actions (N, A) for observations (N, D), or for pictures (N, 5, H, W) with such vectors.

        A recurrent policy starts with an empty memory in every row. The computation has 64 bits, so actions rounded to
        32 bits do not depend on the number of rows.
        """
        if self.eye is not None:
            assert images is not None  # as of an environment with pictures
            observations = np.concatenate([self.eye(images), observations], axis=1)
        return self.act_with_memory(observations, self.initial_memory(len(observations)))[0]

    def initial_memory(self, rows: int) -> Floats:
        """Memory of rows at the beginning of a shift (N, 2, H); H is 0 without an LSTM."""
        return np.zeros((rows, 2, 0 if self.lstm is None else self.lstm.size))

    def act_with_memory(self, observations: NDArray[Any], memory: Floats) -> tuple[Array, Floats]:
        """Actions (N, A) for observations (N, D) and a memory (N, 2, H), and the next memory (N, 2, H)."""
        value = np.asarray(observations, dtype=np.float64)
        if self.lstm is not None:
            memory = self.lstm(value, memory)
            value = memory[:, 0]
        return self._actions(value), memory

    def _actions(self, value: Floats) -> Array:
        """Actions (N, A) from the inputs of the full layers."""
        value = np.clip(networks.run(self.layers, self.activation, value), -self.bound, self.bound)
        if self.output == "scores":
            return value.astype(np.float32)
        if self.output == "squashed":
            value = self.low + 0.5 * (np.tanh(value) + 1.0) * (self.high - self.low)
        return np.clip(value, self.low, self.high).astype(np.float32)

    @property
    def sizes(self) -> tuple[int, int]:
        """Lengths of an observation, of one with a picture of its vector, and of an action."""
        first = self.layers[0].weight if self.lstm is None else self.lstm.input_weights
        return first.shape[1] - (0 if self.eye is None else self.eye.size), len(self.low)

    @property
    def numbers(self) -> dict[str, Array]:
        """Weights and biases by their names in a file."""
        seeing = {} if self.eye is None else self.eye.arrays()
        return dict(zip(LSTM, self.lstm or (), strict=False)) | seeing | networks.arrays(self.layers)

    def save(self, file: Path) -> None:
        """Write the policy to a file."""
        header: dict[str, Any] = {"activation": self.activation, "output": self.output, "bound": np.float32(self.bound)}
        save_arrays(file, {**self.numbers, **header, "low": self.low, "high": self.high})

    @classmethod
    def load(cls, file: Path) -> Self:
        """Read a policy from a file; no code in the file is run.

        Raises:
            UsageError: the file is damaged, or holds no policy.
        """
        try:
            arrays = arrays_of(file, PARTS)
            actor = cls(
                networks.layers(arrays),
                str(arrays["activation"]),
                str(arrays["output"]),
                float(arrays["bound"]),
                networks.numbers(arrays["low"], 1),
                networks.numbers(arrays["high"], 1),
                lstm_of(arrays),
                Eye.of(arrays),
            )
            _check(actor)
        except Exception as error:
            # A truncated or foreign file may raise anything.
            raise UsageError(f"{str(file)!r} is damaged: {file.name} is truncated or holds no policy") from error
        return actor


def _check(actor: Actor) -> None:
    """Make sure that the arrays and names of a policy fit together."""
    first, last = actor.layers[0].weight, actor.layers[-1].weight
    fits = [actor.low.shape == actor.high.shape == last.shape[:1], bool((actor.low < actor.high).all())]
    fits += [actor.activation in ACTIVATIONS, actor.output in OUTPUTS, actor.bound > 0.0]
    fits += [actor.lstm is None or first.shape[1] == actor.lstm.size > 0, actor.sizes[0] > 0]
    if not all(fits):
        raise ValueError("parts that do not fit together")
