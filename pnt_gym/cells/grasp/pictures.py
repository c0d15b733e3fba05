"""Pictures of the coming objects, as the camera above the belt sees them."""

from __future__ import annotations

from typing import final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Floats, take
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.cells.grasp.config import GraspConfig
from pnt_gym.cells.grasp.images import draw_images
from pnt_gym.cells.grasp.rows import SurfaceTable
from pnt_gym.cells.grasp.surfaces import IMAGE, object_keys, outline_errors


@final
class PictureMaker:
    """Draws pictures of objects; a picture is a function of its objects alone.

    Args:
        config: the cell.
        table: surfaces of the items.
    """

    def __init__(self, config: GraspConfig, table: SurfaceTable) -> None:
        self._config, self._table = config, table

    def draw(self, objects: Objects, middles: Floats) -> NDArray[np.uint8]:
        """Pictures (N, 5, 48, 48) of objects (N, M) whose outlines lie at middles (N, M, 2) [m] from the first's.

        The camera takes the picture's middle for that of the first outline, with an error.
        """
        first = take(objects, np.s_[:, 0])
        places = middles + outline_errors(first, self._config)[:, None]
        return draw_images(self._table, objects, places, object_keys(first, IMAGE))
