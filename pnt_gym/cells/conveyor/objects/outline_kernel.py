"""Distances from outlines of objects, one row each. Compiled; see `pnt_gym.compiled`."""

from __future__ import annotations

import math

from pnt_gym.arrays import Bools, Floats
from pnt_gym.compiled import compile_for


@compile_for("void(b1[::1], f8[:, :], f8[:], f8[:, :], f8[::1])")
def find_inside(is_ellipse: Bools, size: Floats, yaw: Floats, place: Floats, inside: Floats) -> None:
    """Write the distances of points from outlines, as `outline.inside_outline` (N,).

    Args:
        is_ellipse: whether an outline is an ellipse, else a rectangle (N,).
        size: extents of the objects (N, 3) [m].
        yaw: yaws of the objects (N,) [rad].
        place: points relative to the objects' middles (N, 2) [m].
        inside: written (N,) [m].
    """
    for row in range(len(inside)):
        cos, sin, x, y = math.cos(yaw[row]), math.sin(yaw[row]), place[row, 0], place[row, 1]
        along, across = abs(cos * x + sin * y), abs(cos * y - sin * x)
        length, width = size[row, 0] / 2.0, size[row, 1] / 2.0
        if is_ellipse[row]:
            inside[row] = (1.0 - math.hypot(along / length, across / width)) * min(length, width)
        else:
            beyond, aside = along - length, across - width
            outside = math.hypot(max(beyond, 0.0), max(aside, 0.0))
            inside[row] = max(min(-beyond, -aside), 0.0) - outside
