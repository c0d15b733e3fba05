"""Pictures of the coming objects, as the camera above the belt sees them."""

from __future__ import annotations

from typing import final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Floats, take
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.cells.grasp.config import GraspConfig
from pnt_gym.cells.grasp.images import draw_images
from pnt_gym.cells.grasp.surfaces import IMAGE, SurfaceTable, later_keys, normal_draw, object_keys


@final
class Camera:
    """Draws pictures of objects; a picture is a function of its objects alone.

    Args:
        config: the cell.
        table: surfaces of the items.
    """

    def __init__(self, config: GraspConfig, table: SurfaceTable) -> None:
        self._error, self._table = config.camera.outline, table

    def pictures(self, picks: Context) -> NDArray[np.uint8]:
        """Pictures (N, 5, 48, 48) of the objects of N picks."""
        objects = picks.objects
        return draw_images(
            self._table, take(objects, np.s_[:, None]), self.middles(objects)[:, None], object_keys(objects, IMAGE)
        )

    def middles(self, objects: Objects) -> Floats:
        """True middles of objects' outlines from the pictures' middles, which the camera takes for them (N, 2) [m]."""
        keys = object_keys(objects, IMAGE)
        draws = np.stack([normal_draw(later_keys(keys, axis + 1)) for axis in range(2)], axis=-1)
        return self._error * draws
