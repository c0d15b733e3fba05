"""The part of a policy that looks at pictures: convolutions, and where in the picture each of their maps is high.

Each map of the last convolution gives three features: the mean row and column of its softmax, and its highest value.
So the features can say where something is, which a place of the cup needs.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final, NamedTuple, Self, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Floats
from pnt_gym.cells.grasp.config import CHANNELS, PIXELS

from .networks import Convolution, activate, convolutions_of, join_squares

SQUARE: Final = 4
"""Side of the squares of pixels that the first convolution sees as one."""
SIDE: Final = PIXELS // SQUARE
ACTIVATION: Final = "SiLU"
PIECES: Final = r"eye_(?:weight|bias)_\d"
"""Names of the arrays of an eye in a file."""
FEATURES: Final = 3
"""Features of each map."""


@final
class Eye(NamedTuple):
    """Convolutions of pictures."""

    convolutions: tuple[Convolution, ...]

    @property
    def size(self) -> int:
        """Number of features of a picture."""
        return FEATURES * len(self.convolutions[-1].bias)

    def __call__(self, images: NDArray[np.uint8]) -> Floats:
        """Features (N, size) of pictures (N, 5, 48, 48)."""
        value = join_squares(images / 255.0, SQUARE)
        for convolution in self.convolutions[:-1]:
            value = activate(ACTIVATION, convolution(value))
        maps = self.convolutions[-1](value).reshape(len(images), -1, SIDE * SIDE)
        highest = maps.max(axis=2)
        weights = np.exp(maps - highest[:, :, None])
        weights /= weights.sum(axis=2, keepdims=True)
        where = weights @ grid()
        return np.concatenate([where[..., 0], where[..., 1], highest], axis=1)

    def arrays(self) -> dict[str, NDArray[np.floating]]:
        """Arrays by name, for a file."""
        parts = enumerate(self.convolutions)
        return {f"eye_{part}_{k}": array for k, layer in parts for part, array in layer._asdict().items()}

    @classmethod
    def of(cls, arrays: Mapping[str, NDArray[Any]]) -> Self | None:
        """The eye among the arrays of a file, if there is one.

        Raises:
            ValueError: the convolutions do not fit together or to pictures, or are no finite numbers.
            KeyError: an array is missing.
        """
        if not any(name.startswith("eye_") for name in arrays):
            return None
        return cls(convolutions_of(arrays, "eye_", CHANNELS * SQUARE**2))


def grid() -> Floats:
    """Column and row (SIDE * SIDE, 2) of the points of a map, from -1 to 1."""
    line = np.linspace(-1.0, 1.0, SIDE)
    return np.stack(np.broadcast_arrays(line[None, :], line[:, None]), axis=-1).reshape(-1, 2)
