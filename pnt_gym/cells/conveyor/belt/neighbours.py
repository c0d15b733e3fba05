"""Collisions of a carried object with other objects on the belt: footprints along the hand's path.

In top view each object is its footprint on the belt, turned by its yaw. In the belt's frame the other objects rest and
the carried object moves, held or in flight. The carried object meets an object whose top is higher than the carried
object's underside while the footprints overlap.
"""

from __future__ import annotations

from typing import Final, TypeAlias

import numpy as np

from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.base.items import ELLIPSOID
from pnt_gym.cells.conveyor.movers.straight import ThrowMotion
from pnt_gym.cells.conveyor.objects.records import Measured, Objects

CHECK_INTERVAL: Final = 0.004
"""Interval between two checks for collisions [s]; a hand moves 10 mm in this time."""
CHECK_AFTER_RELEASE: Final = 0.30
"""Time after the release in which collisions are checked, while objects may still be over the belt [s]."""
Footprints: TypeAlias = Objects | Measured
"""Objects with true or with measured shapes, sizes and yaws."""


def course(motion: ThrowMotion, free_at: Floats, speed: float) -> Floats:
    """Displacements of carried objects from their places on the belt, in the belt's frame (N, M, 3) [m].

    Args:
        motion: motion of the hands.
        free_at: times of the releases, after which the objects fly without air (N,) [s].
        speed: speed of the belt [m/s].
    """
    from pnt_gym.cells.conveyor.belt.sweep import move_objects  # noqa: PLC0415 - numba takes a while

    times = np.arange(0.0, float(free_at.max(initial=0.0)) + CHECK_AFTER_RELEASE, CHECK_INTERVAL)
    way, velocity, _ = motion.path.sample(np.minimum(times, free_at[:, None]))
    pick, free_at = np.ascontiguousarray(motion.pick), np.ascontiguousarray(free_at)
    move_objects(way, velocity, pick, free_at, times, CHECK_AFTER_RELEASE, speed)
    return way


def sweeps_through(carried: Footprints, start: Floats, way: Floats, neighbours: Footprints, place: Floats) -> Bools:
    """Whether each of N carried objects sweeps through each of K others (N, K).

    Args:
        carried: the N carried objects.
        start: middles of the carried objects on the belt (N, 2) [m].
        way: displacements of the carried objects in the belt's frame (N, M, 3) [m].
        neighbours: the other objects (N, K).
        place: middles of the other objects at the lift (N, K, 2) [m].
    """
    from pnt_gym.cells.conveyor.belt.sweep import find_sweeps  # noqa: PLC0415 - numba takes a while

    collides = np.empty(place.shape[:2], dtype=np.bool_)
    start, way, place = (np.ascontiguousarray(values) for values in (start, way, place))
    find_sweeps(*_outlines(carried), start, way, *_outlines(neighbours), place, collides)
    return collides


def _outlines(objects: Footprints) -> tuple[Bools, Floats, Floats]:
    """Which objects are ellipses in top view, their sizes and yaws, in flat arrays."""
    return (
        objects.shape == ELLIPSOID,
        np.ascontiguousarray(objects.size),
        np.ascontiguousarray(objects.yaw),
    )
