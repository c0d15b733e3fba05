"""The true outlines of objects: what they cover of the belt, turned by their yaw, and how far they reach in space."""

from __future__ import annotations

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.items import BOX, CYLINDER, ELLIPSOID
from pnt_gym.cells.conveyor.objects.records import Objects


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


def inside_outline(objects: Objects, place: Floats) -> Floats:
    """How far inside the outlines of objects, seen from above, places are (N,) [m]; negative outside.

    Of an ellipse the outline through the place is taken, by the ellipse's smaller half axis: exact for a circle.

    Args:
        objects: N.
        place: from the middle of each, along world x, y (N, 2) [m].
    """
    cos, sin = np.cos(objects.yaw), np.sin(objects.yaw)
    x, y = place.T
    own = np.abs(np.stack([cos * x + sin * y, cos * y - sin * x], axis=-1))
    half = objects.size[:, :2] / 2.0
    over = own - half
    beyond = np.maximum(over, 0.0)
    rectangle: Floats = (-over).min(axis=1).clip(min=0.0) - np.hypot(beyond[:, 0], beyond[:, 1])
    round_: Floats = (1.0 - np.hypot(*(own / half).T)) * half.min(axis=1)
    return np.where(objects.shape == ELLIPSOID, round_, rectangle)


def reach(objects: Objects, half: Floats, up: Floats) -> Floats:
    """How far objects with half extents (N, 3) reach from their middle along directions (N, K, 3) (N, K) [m]."""
    x, y, z = (np.abs(up[..., k]) * half[:, k, None] for k in range(3))
    shape = objects.shape[:, None]
    return np.select(
        [shape == BOX, shape == CYLINDER], [x + y + z, x + np.sqrt(y * y + z * z)], np.sqrt(x * x + y * y + z * z)
    )
