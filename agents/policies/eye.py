"""The part of a policy that looks at pictures: the network `NatureCNN` of stable-baselines3, computed by NumPy.

stable-baselines3 puts the features of a picture before the vector beside it (`CombinedExtractor`).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final, NamedTuple, Self, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Floats
from pnt_gym.cells.grasp.config import CHANNELS, PIXELS

from .networks import Convolution, Dense, activate, dense_of, numbers_of

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
            Convolution(numbers_of(arrays[f"eye_weight_{k}"], 4), numbers_of(arrays[f"eye_bias_{k}"], 1))
            for k in range(len(STRIDES))
        )
        eye = cls(convolutions, dense_of(arrays, f"eye_weight_{len(STRIDES)}", f"eye_bias_{len(STRIDES)}"))
        if any(layer.bias.shape != layer.weight.shape[:1] for layer in (*convolutions, eye.dense)):
            raise ValueError("layers that do not fit together")
        eye(np.zeros((1, CHANNELS, PIXELS, PIXELS), np.uint8))  # other misfits raise here
        return eye
