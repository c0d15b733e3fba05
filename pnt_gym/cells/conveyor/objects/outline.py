"""True outlines of objects: footprints on the belt, turned by the objects' yaw."""

from __future__ import annotations

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.items import ELLIPSOID
from pnt_gym.cells.conveyor.objects.records import Objects


def half_extent(objects: Objects, heading: float | Floats = 0.0) -> Floats:
    """Half extents of footprints along a horizontal direction, from their centres, S [m].

    In top view a box and a lying cylinder are rectangles, an ellipsoid is an ellipse.

    Args:
        objects: objects of any leading shape S.
        heading: angle of the direction, from the belt's travel towards the bins: one number, or S [rad].
    """
    # Support function: a |cos| + b |sin| of a rectangle, sqrt((a cos)^2 + (b sin)^2) of an ellipse.
    turned = heading - objects.yaw
    along = 0.5 * objects.size[..., 0] * np.abs(np.cos(turned))
    across = 0.5 * objects.size[..., 1] * np.abs(np.sin(turned))
    return np.where(objects.shape == ELLIPSOID, np.sqrt(along * along + across * across), along + across)


def inside_outline(objects: Objects, place: Floats) -> Floats:
    """Distance of points from the outlines of objects in top view (N,) [m]; positive inside, negative outside.

    The distance from an ellipse is scaled by the ellipse's smaller half axis: exact for a circle.

    Args:
        objects: N objects.
        place: one point per object, relative to the object's middle, along world x, y (N, 2) [m].
    """
    from pnt_gym.cells.conveyor.objects.kernel import find_inside  # noqa: PLC0415 - numba takes a while

    inside = np.empty(len(place))
    find_inside(objects.shape == ELLIPSOID, objects.size, objects.yaw, place, inside)
    return inside
