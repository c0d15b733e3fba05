"""Pictures of the coming objects, as the camera above the belt sees them."""

from __future__ import annotations

from typing import final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Floats, take
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.cells.grasp.config import GraspConfig
from pnt_gym.cells.grasp.images import draw_images
from pnt_gym.cells.grasp.surfaces import IMAGE, SurfaceTable, later_keys, normal_draw, object_keys


@final
class PictureMaker:
    """Draws pictures of objects; a picture is a function of its objects alone.

    Args:
        config: the cell.
        table: surfaces of the items.
    """

    def __init__(self, config: GraspConfig, table: SurfaceTable) -> None:
        self._error, self._table = config.camera.outline, table

    def pictures(self, objects: Objects, middles: Floats) -> NDArray[np.uint8]:
        """Pictures (N, 5, 48, 48) of objects (N, M) whose outlines lie at middles (N, M, 2) [m] from the first's.

        The camera takes the picture's middle for that of the first outline, with an error.
        """
        first = take(objects, np.s_[:, 0])
        places = middles + self.errors(first)[:, None]
        return draw_images(self._table, objects, places, object_keys(first, IMAGE))

    def errors(self, objects: Objects) -> Floats:
        """True middles of objects' outlines from the places at which the camera sees them (N, 2) [m]."""
        keys = object_keys(objects, IMAGE)
        draws = np.stack([normal_draw(later_keys(keys, axis + 1)) for axis in range(2)], axis=-1)
        return self._error * draws
