"""Pictures of objects on the belt: depth and colours from above, as a depth camera over the belt sees them."""

from __future__ import annotations

from typing import final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Floats, take
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.cells.grasp import image_kernel
from pnt_gym.cells.grasp.config import PIXEL, PIXELS, GraspConfig
from pnt_gym.cells.grasp.rows import SurfaceTable
from pnt_gym.cells.grasp.surfaces import IMAGE, Keys, draw_surfaces, object_keys, outline_errors

Bytes = NDArray[np.uint8]


@final
class PictureMaker:
    """Draws pictures of objects; a picture is a function of its objects alone.

    Args:
        config: the cell.
        table: surfaces of the items.
    """

    def __init__(self, config: GraspConfig, table: SurfaceTable) -> None:
        self._config, self._table = config, table

    def draw(self, objects: Objects, middles: Floats) -> Bytes:
        """Pictures (N, 5, 48, 48) of objects (N, M) whose outlines lie at middles (N, M, 2) [m] from the first's.

        The camera takes the picture's middle for that of the first outline, with an error.
        """
        first = take(objects, np.s_[:, 0])
        places = middles + outline_errors(first, self._config)[:, None]
        return draw_images(self._table, objects, places, object_keys(first, IMAGE))


def draw_images(table: SurfaceTable, objects: Objects, middles: Floats, noise_keys: Keys | None = None) -> Bytes:
    """Pictures of objects, with the noise of the camera or without it.

    Glossy surfaces have noisier depths and more pixels without a depth.

    Args:
        table: the surfaces of the items.
        objects: M objects in each of N pictures (N, M).
        middles: true middles of their outlines from the middle of the picture, along the world's axes (N, M, 2) [m];
            NaN for an object that is absent.
        noise_keys: keys of the noise (N,), see `object_keys`; None for pictures without noise.

    Returns:
        (N, 5, 48, 48): height above the belt [mm], 255 where the depth is valid, else 0, red, green, blue. The columns
        go along the belt, the rows from larger to smaller y.
    """
    surfaces = draw_surfaces(table, objects).flat()
    keys = np.zeros(len(middles), dtype=np.uint64) if noise_keys is None else np.ascontiguousarray(noise_keys)
    return image_kernel.draw_images(surfaces, np.ascontiguousarray(middles), keys, noise_keys is not None)


def pixel_places() -> Floats:
    """Middles of the pixels from the middle of a picture, along the world's axes (48, 48, 2) [m]."""
    line = PIXEL * (np.arange(PIXELS) - (PIXELS - 1) / 2.0)
    return np.stack(np.broadcast_arrays(line[None, :], -line[:, None]), axis=-1)
