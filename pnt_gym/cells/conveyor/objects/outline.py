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
    cos, sin = np.cos(objects.yaw), np.sin(objects.yaw)
    x, y = place.T
    along, across = np.abs(cos * x + sin * y), np.abs(cos * y - sin * x)
    length, width = (objects.size[:, k] / 2.0 for k in range(2))
    beyond, aside = along - length, across - width
    outside = np.hypot(np.maximum(beyond, 0.0), np.maximum(aside, 0.0))
    rectangle: Floats = np.maximum(np.minimum(-beyond, -aside), 0.0) - outside
    ellipse: Floats = (1.0 - np.hypot(along / length, across / width)) * np.minimum(length, width)
    return np.where(objects.shape == ELLIPSOID, ellipse, rectangle)
