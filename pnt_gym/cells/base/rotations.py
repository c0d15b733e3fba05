"""Rotations of N bodies: about the vertical by a yaw, and in general by unit quaternions with w first.

Compiled functions do not use this module: a file that is compiled contains every function that its code calls.
"""

from __future__ import annotations

import numpy as np

from pnt_gym.arrays import Floats, dot


def to_body_axes(vector: Floats, yaw: Floats) -> Floats:
    """World vectors (..., 3) in the axes of bodies turned by yaw (...,) about z."""
    cos, sin = np.cos(yaw), np.sin(yaw)
    x, y = vector[..., 0], vector[..., 1]
    return np.stack([cos * x + sin * y, cos * y - sin * x, vector[..., 2]], axis=-1)


def yaw_attitude(yaw: Floats) -> Floats:
    """Attitudes (N, 4) of bodies that are only turned by yaw (N,) about z."""
    zero = np.zeros_like(yaw)
    return np.stack([np.cos(yaw / 2.0), zero, zero, np.sin(yaw / 2.0)], axis=1)


def rotate(attitude: Floats, vector: Floats) -> Floats:
    """World vectors (N, 3) of vectors (N, 3) in the axes of bodies with attitudes (N, 4)."""
    w, axis = attitude[:, :1], attitude[:, 1:]
    across = 2.0 * np.cross(axis, vector)
    return vector + w * across + np.cross(axis, across)


def quaternion_product(first: Floats, second: Floats) -> Floats:
    """Hamilton product (N, 4) of two unit quaternions: the second rotation, in the axes of the first."""
    w, v, a, u = first[:, :1], first[:, 1:], second[:, :1], second[:, 1:]
    return np.concatenate([w * a - dot(v, u)[:, None], w * u + a * v + np.cross(v, u)], axis=1)


def level_axes(attitude: Floats) -> tuple[Floats, Floats]:
    """World x and y in the axes of bodies with attitude (..., 4): (..., 3) each."""
    w, x, y, z = (attitude[..., k] for k in range(4))
    along = np.stack([1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)], axis=-1)
    across = np.stack([2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)], axis=-1)
    return along, across


def vertical(attitude: Floats) -> Floats:
    """The vertical in the axes of bodies with attitude (..., 4): (..., 3)."""
    w, x, y, z = (attitude[..., k] for k in range(4))
    return np.stack([2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)], axis=-1)


def vertical_of_spinning(attitude: Floats, spin: Floats, times: Floats) -> Floats:
    """The vertical in the axes of bodies that spin on at a constant rate (N, K, 3).

    Args:
        attitude: at time 0 (N, 4).
        spin: angular velocity in the body's axes (N, 3) [rad/s].
        times: times (K,) after time 0 [s].
    """
    first = vertical(attitude)[:, None]
    rate = np.sqrt(spin[:, 0] ** 2 + spin[:, 1] ** 2 + spin[:, 2] ** 2)[:, None]
    axis = (spin / np.where(rate > 0.0, rate, 1.0))[:, None]
    cos, sin = np.cos(rate * times)[..., None], np.sin(rate * times)[..., None]
    # Rodrigues' formula for the vertical, turned back.
    along = dot(axis, first)[..., None] * axis
    return along + cos * (first - along) - sin * np.cross(axis, first)
