"""Collisions of a carried object with other objects on the belt: footprints along the hand's path, in arrays.

In top view each object is its footprint on the belt, turned by its yaw. In the belt's frame the other objects rest and
the carried object moves, held or in flight. The carried object meets an object whose top is higher than the carried
object's underside while the footprints overlap.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from pnt_gym.arrays import Bools, Floats, take
from pnt_gym.cells.conveyor.movers.straight import ThrowMotion
from pnt_gym.cells.conveyor.objects.outline import half_extent
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.constants import GRAVITY

CHECK_INTERVAL: Final = 0.004
"""Interval between two checks for collisions [s]; a hand moves 10 mm in this time."""
CHECK_AFTER_RELEASE: Final = 0.30
"""Time after the release in which collisions are checked, while objects may still be over the belt [s]."""
BESIDE_DEPTH: Final = 0.02
"""Depth below its place on the belt at which an object is beside the belt [m]."""
_HEADINGS: Final = np.arange(16) * np.pi / 16
"""Directions in which round outlines are separated [rad]; any direction is within 6 degrees of these."""


def course(motion: ThrowMotion, free_at: Floats, speed: float) -> Floats:
    """Displacements of carried objects from their places on the belt, in the belt's frame (N, M, 3) [m].

    Args:
        motion: motion of the hands.
        free_at: times of the releases, after which the objects fly without air (N,) [s].
        speed: speed of the belt [m/s].
    """
    last = free_at[:, None] + CHECK_AFTER_RELEASE
    times = np.minimum(np.arange(0.0, float(last.max(initial=0.0)), CHECK_INTERVAL), last)
    hand_times = np.minimum(times, free_at[:, None])
    hand, since = motion.path.sample(hand_times), times - hand_times
    way = hand.position - motion.pick[:, None] + since[..., None] * hand.velocity
    way[..., 2] -= 0.5 * GRAVITY * since**2
    way[..., 0] -= speed * times
    return way


def sweeps_through(carried: Objects, start: Floats, way: Floats, neighbours: Objects, place: Floats) -> Bools:
    """Whether each of N carried objects sweeps through each of K others (N, K).

    Args:
        carried: the N carried objects.
        start: middles of the carried objects on the belt (N, 2) [m].
        way: displacements of the carried objects in the belt's frame (N, M, 3) [m].
        neighbours: the other objects (N, K).
        place: middles of the other objects at the lift (N, K, 2) [m].
    """
    height, tall = way[..., 2], neighbours.size[..., 2]
    # Most of the time a hand is above all objects.
    row, moment = np.nonzero((height < tall.max(axis=1, initial=0.0)[:, None]) & (height > -BESIDE_DEPTH))
    x, y = (place[row, :, k] - start[row, k, None] - way[row, moment, k, None] for k in range(2))
    reach = _outer_radius(carried)[:, None] + _outer_radius(neighbours)
    near = x**2 + y**2 < reach[row] ** 2
    check, neighbour = np.nonzero(near & (height[row, moment, None] < tall[row]))
    row = row[check]
    distance = np.stack([x[check, neighbour], y[check, neighbour]], axis=1)
    overlap = _overlap(take(carried, row), take(neighbours, (row, neighbour)), distance)
    collides = np.zeros(tall.shape, dtype=np.bool_)
    collides[row[overlap], neighbour[overlap]] = True
    return collides


def as_measured(objects: Objects) -> Objects:
    """Objects with the measured extents and yaw."""
    return objects.replace(size=objects.measured.size, yaw=objects.measured.yaw)


def _overlap(first: Objects, second: Objects, distance: Floats) -> Bools:
    """Whether the outlines of P pairs of objects overlap (P,), for distances between their middles (P, 2) [m].

    Separating axes: convex outlines are disjoint if their projections on some direction are; for rectangles the
    directions of their sides suffice.
    """
    sides = np.stack([first.yaw, first.yaw + np.pi / 2, second.yaw, second.yaw + np.pi / 2], axis=1)
    heading = np.concatenate([sides, np.broadcast_to(_HEADINGS, (len(sides), len(_HEADINGS)))], axis=1)
    reach = half_extent(take(first, np.s_[:, None]), heading) + half_extent(take(second, np.s_[:, None]), heading)
    along = distance[:, :1] * np.cos(heading) + distance[:, 1:] * np.sin(heading)
    return np.asarray((np.abs(along) < reach).all(axis=1))


def _outer_radius(objects: Objects) -> Floats:
    """Radii of circles around outlines, S [m]."""
    return 0.5 * np.hypot(objects.size[..., 0], objects.size[..., 1])
