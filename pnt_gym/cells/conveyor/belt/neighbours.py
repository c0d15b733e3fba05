"""Whether a carried object sweeps through others on the belt: footprints along the hand's path, in arrays.

Seen from above objects are what they cover of the belt, turned by their yaw; the others ride with it, and the carried
one moves against it, held or flying. It meets those that are higher than its underside is at that moment.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from pnt_gym.arrays import Bools, Floats, take
from pnt_gym.cells.conveyor.movers.straight import ThrowMotion
from pnt_gym.cells.conveyor.objects.outline import half_extent
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.constants import GRAVITY

INTERVAL: Final = 0.004
"""Objects are looked at this often [s]: a hand moves 10 mm meanwhile."""
AFTERWARDS: Final = 0.30
"""And this long after they are let go, while they may still be over the belt [s]."""
SUNK: Final = 0.02
"""An object this far below where it lay on the belt is beside it [m]."""
_HEADINGS: Final = np.arange(16) * np.pi / 16
"""Directions in which round outlines are told apart [rad]; no other lies farther from one than 6 degrees."""


def course(motion: ThrowMotion, free_at: Floats, speed: float) -> Floats:
    """Ways of carried objects from where they lay on a belt of a speed [m/s], against it (N, M, 3) [m].

    Args:
        motion: of the hands.
        free_at: when they let go of the objects, which then fly without air (N,) [s].
        speed: of the belt [m/s].
    """
    last = free_at[:, None] + AFTERWARDS
    times = np.minimum(np.arange(0.0, float(last.max(initial=0.0)), INTERVAL), last)
    held = np.minimum(times, free_at[:, None])
    hand, since = motion.path.sample(held), times - held
    way = hand.position - motion.pick[:, None] + since[..., None] * hand.velocity
    way[..., 2] -= 0.5 * GRAVITY * since**2
    way[..., 0] -= speed * times
    return way


def swept(carried: Objects, start: Floats, way: Floats, others: Objects, place: Floats) -> Bools:
    """Which of K other objects N carried ones sweep through (N, K).

    Args:
        carried: N.
        start: where their middles lay on the belt (N, 2) [m].
        way: from there, against the belt (N, M, 3) [m].
        others: (N, K).
        place: their middles when the first are lifted (N, K, 2) [m].
    """
    height, tall = way[..., 2], others.size[..., 2]
    # Most of the time a hand is above all of them.
    row, moment = np.nonzero((height < tall.max(axis=1, initial=0.0)[:, None]) & (height > -SUNK))
    x, y = (place[row, :, k] - start[row, k, None] - way[row, moment, k, None] for k in range(2))
    reach = _radius(carried)[:, None] + _radius(others)
    near = x**2 + y**2 < reach[row] ** 2
    looked, other = np.nonzero(near & (height[row, moment, None] < tall[row]))
    row = row[looked]
    apart = np.stack([x[looked, other], y[looked, other]], axis=1)
    met = _overlap(take(carried, row), take(others, (row, other)), apart)
    found = np.zeros(tall.shape, dtype=np.bool_)
    found[row[met], other[met]] = True
    return found


def as_measured(objects: Objects) -> Objects:
    """Objects as the sensors see them lie."""
    return replace(objects, size=objects.measured.size, yaw=objects.measured.yaw)


def _overlap(one: Objects, other: Objects, apart: Floats) -> Bools:
    """Whether P pairs of outlines overlap whose middles lie apart (P, 2) [m], (P,).

    Convex outlines are apart if they are in some direction; of rectangles the directions of their sides are enough.
    """
    sides = np.stack([one.yaw, one.yaw + np.pi / 2, other.yaw, other.yaw + np.pi / 2], axis=1)
    heading = np.concatenate([sides, np.broadcast_to(_HEADINGS, (len(sides), len(_HEADINGS)))], axis=1)
    reach = half_extent(take(one, np.s_[:, None]), heading) + half_extent(take(other, np.s_[:, None]), heading)
    along = apart[:, :1] * np.cos(heading) + apart[:, 1:] * np.sin(heading)
    return np.asarray((np.abs(along) < reach).all(axis=1))


def _radius(objects: Objects) -> Floats:
    """Of circles around outlines, S [m]."""
    return 0.5 * np.hypot(objects.size[..., 0], objects.size[..., 1])
