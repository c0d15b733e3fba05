"""Maps of pictures: values at places, blurred by the error of the cup, and the best places in them."""

from __future__ import annotations

from typing import Final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.grasp.images import pixel_places

BLUR: Final = 0.0045
"""Standard deviation of the blur of a map: about the error of the cup's place [m]."""


def blur_maps(maps: Floats, deviation: float | tuple[float, float] = BLUR) -> Floats:
    """Maps (N, 48, 48) averaged over errors with a standard deviation [m], across and along the belt; 0 outside."""
    across, along = deviation if isinstance(deviation, tuple) else (deviation, deviation)
    return _blur_axis(_blur_axis(maps, along, 2), across, 1)


def _blur_axis(maps: Floats, deviation: float, axis: int) -> Floats:
    """Maps averaged along an axis by a normal distribution's weights."""
    pixel = pixel_places()[0, 1, 0] - pixel_places()[0, 0, 0]
    reach = int(np.ceil(3.0 * deviation / pixel))
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) * pixel / deviation) ** 2)
    padded = np.pad(maps, [(reach, reach) if axis == k else (0, 0) for k in range(3)])
    size = maps.shape[axis]
    parts = (weight * np.take(padded, np.arange(k, k + size), axis) for k, weight in enumerate(weights / weights.sum()))
    return np.asarray(sum(parts))


def best_places(maps: Floats) -> Floats:
    """Places (N, 2) [m] of the highest values of maps (N, 48, 48), from the middles of the pictures."""
    pixel = maps.reshape(len(maps), -1).argmax(axis=1)
    return pixel_places().reshape(-1, 2)[pixel]
