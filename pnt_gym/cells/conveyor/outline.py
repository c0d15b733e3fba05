"""What objects cover of the belt they lie on: their true footprints, turned by their yaw."""

from __future__ import annotations

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.items import ELLIPSOID
from pnt_gym.cells.conveyor.objects import Objects


def half_extent(objects: Objects, heading: float | Floats = 0.0) -> Floats:
    """How far footprints reach from their centres along a level direction, and as far the other way, S [m].

    Seen from above a box and a lying cylinder are rectangles, an ellipsoid is an ellipse.

    Args:
        objects: of any leading shape S.
        heading: the direction, from the belt's travel towards the bins: one, or one for each S [rad].
    """
    turned = heading - objects.yaw
    along = 0.5 * objects.size[..., 0] * np.abs(np.cos(turned))
    across = 0.5 * objects.size[..., 1] * np.abs(np.sin(turned))
    return np.where(objects.shape == ELLIPSOID, np.sqrt(along * along + across * across), along + across)
