"""Drag-free flight of a released object, in closed form (Hassan et al. 2022, Eqs. 8 and 9)."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats, numbers, tuples
from pnt_gym.constants import AIR_DENSITY, GRAVITY
from pnt_gym.planning.motion import kernel

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)
_SHARES: Final[Floats] = (_NODES + 1.0) / 2.0
"""Gauss-Legendre nodes of the drag's time integral, as shares of the flight time."""


def flight_time(position: ArrayLike, velocity: ArrayLike, plane_z: ArrayLike) -> Floats:
    """Return the time [s] until the object comes down through the plane z = ``plane_z`` (Eq. 9).

    Args:
        position: release points (..., 3) [m].
        velocity: release velocities (..., 3) [m/s].
        plane_z: height of the plane [m], one number or (...,).

    Returns:
        Times (...,); NaN where the object never comes down through the plane after its release; 0 for a release
        on the plane with no upward speed.
    """
    drop = tuples(position, "position")[..., 2] - numbers(plane_z, "plane_z")
    rise = tuples(velocity, "velocity")[..., 2]
    shape = np.broadcast_shapes(drop.shape, rise.shape)
    values = np.empty((2, *shape))
    values[0], values[1] = drop, rise
    return kernel.times_to_fall(*values.reshape(2, -1)).reshape(shape)


def flight_state(position: ArrayLike, velocity: ArrayLike, time: ArrayLike) -> tuple[Floats, Floats]:
    """Return position and velocity (..., 3) at ``time`` (...,) [s] after the release (Eq. 8)."""
    t, start = numbers(time, "time")[..., None], tuples(velocity, "velocity")
    gravity = np.array([0.0, 0.0, -GRAVITY])
    return tuples(position, "position") + t * (start + 0.5 * t * gravity), start + t * gravity


def landing_point(position: ArrayLike, velocity: ArrayLike, plane_z: ArrayLike) -> Floats:
    """Return the points (..., 3) [m] where objects come down through the plane; NaN for an object that never does."""
    landing, _ = flight_state(position, velocity, flight_time(position, velocity, plane_z))
    landing[..., 2] = np.where(np.isnan(landing[..., 2]), np.nan, plane_z)
    return landing


def apex(position: ArrayLike, velocity: ArrayLike) -> tuple[Floats, Floats]:
    """Return the time (...,) [s] and the point (..., 3) [m] where the flight is highest.

    A flight that is released downward is highest at its release: time 0.
    """
    time = np.maximum(tuples(velocity, "velocity")[..., 2], 0.0) / GRAVITY
    return time, flight_state(position, velocity, time)[0]


def drag_shift(position: Floats, velocity: Floats, plane_z: ArrayLike, drag_area: Floats) -> Floats:
    """Return the offset (..., 3) [m] of the landing by drag, to first order in the drag; NaN without a landing.

    Along the drag-free flight of time T the drag a = -rho/2 (Cd A/m) |v| v moves the object by the integral of
    (T - t) a dt. The vertical part of this offset also changes the time of the landing.

    Args:
        position: release points (..., 3) [m].
        velocity: release velocities (..., 3) [m/s].
        plane_z: height of the landing [m], one number or (...,).
        drag_area: Cd A / m of the objects (...,) [m2/kg].
    """
    time = flight_time(position, velocity, plane_z)
    offset, last = np.zeros_like(velocity), flight_state(position, velocity, time)[1]
    for share, weight in zip(_SHARES, _WEIGHTS / 2.0, strict=True):
        passing = flight_state(position, velocity, share * time)[1]
        factor = AIR_DENSITY / 2.0 * drag_area * np.linalg.norm(passing, axis=-1)
        offset -= (weight * (1.0 - share) * time**2 * factor)[..., None] * passing
    falling = np.where(last[..., 2] < 0.0, last[..., 2], np.nan)
    return offset - (offset[..., 2] / falling)[..., None] * last
