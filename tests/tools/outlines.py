"""Outlines of objects as polygons, and whether two overlap: nothing of the suite but their sizes and yaws."""

import numpy as np

from pnt_gym.cells.base.items import ELLIPSOID
from pnt_gym.cells.conveyor.objects.records import Objects

CORNERS = 24


def outlines(objects: Objects, centre: np.ndarray) -> np.ndarray:
    """Corners (N, CORNERS, 2) of objects (N,) at centres (N, 2), anticlockwise; a box repeats its last corner."""
    angle = 2.0 * np.pi * np.arange(CORNERS) / CORNERS
    ellipse = 0.5 * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    box = 0.5 * np.array([(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), *[(1.0, -1.0)] * (CORNERS - 3)])
    unit = np.where((objects.shape == ELLIPSOID)[:, None, None], ellipse, box)
    lying = unit * objects.size[:, None, :2]
    turn = np.exp(1j * objects.yaw)[:, None]
    turned = (lying[..., 0] + 1j * lying[..., 1]) * turn
    return np.stack([turned.real, turned.imag], axis=-1) + centre[:, None]


def overlap(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Which pairs of convex polygons (N, K, 2) overlap: no edge of either has the other wholly on its outer side."""
    return ~(_separated(one, other) | _separated(other, one))


def _separated(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    edges = np.roll(one, -1, axis=1) - one
    outward = np.stack([edges[..., 1], -edges[..., 0]], axis=-1)
    real = np.any(edges != 0.0, axis=-1)
    beyond = np.einsum("nek,npk->nep", outward, other) - np.einsum("nek,nek->ne", outward, one)[..., None]
    return ((beyond > 0.0).all(axis=2) & real).any(axis=1)
