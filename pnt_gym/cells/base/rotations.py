"""Rotations of N bodies: about the vertical by a yaw, and in general by unit quaternions with w first."""

from __future__ import annotations

import numpy as np

from pnt_gym.arrays import Floats, join_columns


def turn_back(vector: Floats, cos: Floats, sin: Floats) -> Floats:
    """World vectors (..., 3) in the axes of bodies turned about z, by cosines and sines (...,) of their yaws."""
    x, y = vector[..., 0], vector[..., 1]
    return join_columns(cos * x + sin * y, cos * y - sin * x, vector[..., 2])


def yaw_attitude(yaw: Floats) -> Floats:
    """Attitudes (N, 4) of bodies that are only turned by yaw (N,) about z."""
    return join_columns(np.cos(yaw / 2.0), 0.0, 0.0, np.sin(yaw / 2.0))


def level_axes(attitude: Floats) -> tuple[Floats, Floats]:
    """World x and y in the axes of bodies with attitude (..., 4): (..., 3) each."""
    w, x, y, z = np.moveaxis(attitude, -1, 0)
    # The first two rows of the rotation matrix from body axes to the world's.
    along = np.stack([1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)], axis=-1)
    across = np.stack([2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)], axis=-1)
    return along, across


def vertical(attitude: Floats) -> Floats:
    """The vertical in the axes of bodies with attitude (..., 4): (..., 3)."""
    w, x, y, z = np.moveaxis(attitude, -1, 0)
    # The third row of the same matrix.
    return np.stack([2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)], axis=-1)
