"""Unit meshes of boxes, balls and cylinders, and lines of outlines."""

from __future__ import annotations

from functools import lru_cache
from typing import Final

import numpy as np

from pnt_gym.arrays import Floats, Ints
from pnt_gym.cells.conveyor.robot import Reach

SIDES: Final = 20
"""Sides of a cylinder."""
RINGS: Final = 8
"""Rings of a ball."""
CORNERS: Final = 64
"""Corners of an ellipse."""


@lru_cache
def mesh(shape: str) -> tuple[Floats, Ints]:
    """Vertices (V, 3) and triangles (F, 3) of a shape whose half extents are 1."""
    return {"box": _box, "ball": _ball, "cylinder": _cylinder}[shape]()


def _box() -> tuple[Floats, Ints]:
    vertices = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
    squares = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return vertices, np.array([triangle for a, b, c, d in squares for triangle in ((a, b, c), (a, c, d))])


def _cylinder() -> tuple[Floats, Ints]:
    angle = 2.0 * np.pi * np.arange(SIDES) / SIDES
    ring = np.stack([np.cos(angle), np.sin(angle), np.zeros(SIDES)], axis=1)
    up = np.array([0.0, 0.0, 1.0])
    vertices = np.concatenate([ring - up, ring + up, [-up, up]])
    this, other = np.arange(SIDES), (np.arange(SIDES) + 1) % SIDES
    low, high = np.full(SIDES, 2 * SIDES), np.full(SIDES, 2 * SIDES + 1)
    parts = [(this, other, other + SIDES), (this, other + SIDES, this + SIDES), (other, this, low)]
    faces = [np.stack(part, axis=1) for part in [*parts, (this + SIDES, other + SIDES, high)]]
    return vertices, np.concatenate(faces)


def _ball() -> tuple[Floats, Ints]:
    polar, around = np.pi * np.arange(RINGS + 1) / RINGS, 2.0 * np.pi * np.arange(SIDES) / SIDES
    p, a = (values.ravel() for values in np.meshgrid(polar, around, indexing="ij"))
    vertices = np.stack([np.sin(p) * np.cos(a), np.sin(p) * np.sin(a), np.cos(p)], axis=1)
    ring, side = (values.ravel() for values in np.meshgrid(np.arange(RINGS), np.arange(SIDES), indexing="ij"))
    corner = [(ring + i) * SIDES + (side + j) % SIDES for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))]
    faces = [np.stack([corner[0], corner[i], corner[j]], axis=1) for i, j in ((1, 2), (2, 3))]
    return vertices, np.concatenate(faces)


def segments(points: Floats) -> Floats:
    """Segments (K, 2, 3) along points (K, 3), back to the first one."""
    return np.stack([points, np.roll(points, -1, axis=0)], axis=1)


def outlines(reach: Reach, x: float, z: float) -> Floats:
    """Segments (K, 2, 3) of the border of a robot's reach at a height, and of its hole; the robot stands at x."""
    angle = 2.0 * np.pi * np.arange(CORNERS) / CORNERS
    parts = list[Floats]()
    for along, across in (reach.semi_axes, *([(reach.hole, reach.hole)] if reach.hole else [])):
        points = [x + reach.x + along * np.cos(angle), reach.y + across * np.sin(angle), np.full(CORNERS, z)]
        parts.append(segments(np.stack(points, axis=1)))
    return np.concatenate(parts)
