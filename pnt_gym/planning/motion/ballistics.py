"""Drag-free flight of a released object, in closed form (Hassan et al. 2022, Eqs. 8 and 9)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats
from pnt_gym.constants import GRAVITY


def flight_time(position: Floats, velocity: Floats, plane_z: ArrayLike) -> Floats:
    """Return the time [s] until the object comes down through the plane z = ``plane_z`` (Eq. 9).

    Args:
        position: release points (..., 3) [m].
        velocity: release velocities (..., 3) [m/s].
        plane_z: height of the plane [m], one number or (...,).

    Returns:
        Times (...,); NaN where the object never comes down through the plane after its release. A release
        on the plane with no upward speed lands at once: 0.
    """
    drop = position[..., 2] - np.asarray(plane_z, dtype=np.float64)
    rise = velocity[..., 2]
    square = rise * rise + 2.0 * GRAVITY * drop
    root = np.sqrt(np.maximum(square, 0.0))
    # For a downward release the printed sum cancels; the conjugate form does not.
    falling = (rise < 0.0) & (square >= 0.0)
    denominator = np.where(falling, root - rise, 1.0)
    time = np.where(falling, 2.0 * drop / denominator, (rise + root) / GRAVITY)
    reached = (square >= 0.0) & (time >= 0.0)
    return np.where(reached, time, np.nan)


def flight_state(position: Floats, velocity: Floats, time: ArrayLike) -> tuple[Floats, Floats]:
    """Return position and velocity (..., 3) at ``time`` (...,) [s] after the release (Eq. 8)."""
    t = np.asarray(time, dtype=np.float64)[..., None]
    gravity = np.array([0.0, 0.0, -GRAVITY])
    return position + t * (velocity + 0.5 * t * gravity), velocity + t * gravity


def landing_point(position: Floats, velocity: Floats, plane_z: ArrayLike) -> Floats:
    """Return where the object comes down through the plane (..., 3) [m]; NaN where it never does."""
    landing, _ = flight_state(position, velocity, flight_time(position, velocity, plane_z))
    plane = np.broadcast_to(np.asarray(plane_z, dtype=np.float64), landing.shape[:-1])
    landing[..., 2] = np.where(np.isnan(landing[..., 2]), np.nan, plane)
    return landing


def apex(position: Floats, velocity: Floats) -> tuple[Floats, Floats]:
    """Return the time (...,) [s] and the point (..., 3) [m] where the flight is highest.

    A downward release is highest where it starts: time 0.
    """
    time = np.maximum(velocity[..., 2], 0.0) / GRAVITY
    return time, flight_state(position, velocity, time)[0]
