"""The vertical approach to a pick, entered in motion: the last part of a minimum-time stop.

A hand that already brakes at the top of the approach may be faster there than a hand that begins to brake there. The
approach is the part of a full stop after its deceleration has grown to a share of the limit; the time of the whole
return depends little on this share around `ENTRY`.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.planning.motion.limits import LimitRows, Limits
from pnt_gym.planning.motion.roots import bisect
from pnt_gym.planning.motion.rows import Segments
from pnt_gym.planning.motion.scurve import brake, brake_distance

SPEEDING: Final = 0.998
"""Greatest speed where two motions meet, as a share of the limit: at the limit itself a motion cannot turn."""
ENTRY: Final = 0.37
"""Deceleration at the entry as a share of the limit."""
_HALVINGS: Final = 60


class Entry(NamedTuple):
    """State of the hand at the top of N approaches, and the approaches.

    Attributes:
        velocity: (N, 3) [m/s], downward.
        acceleration: (N, 3) [m/s2], upward.
        down: motions from the top to rest.
    """

    velocity: Floats
    acceleration: Floats
    down: Segments

    @classmethod
    def of(cls, limits: Limits, count: int, height: float) -> Entry:
        """Return the quickest approaches over ``height`` [m] that are entered in motion, for ``count`` rows.

        Where the entry would be too fast for the speed limit, the hand enters near that limit and brakes as late as it
        can.
        """
        velocity, acceleration, jerk = rows = limits.arrays(count)
        elapsed = ENTRY * acceleration / jerk
        stop = _initial_speed(rows, elapsed, height)
        braking = (np.sqrt(jerk * stop) >= jerk * elapsed) & (stop <= SPEEDING * velocity)
        elapsed = np.where(braking, elapsed, 0.0)
        stop = np.where(braking, stop, np.minimum(_initial_speed(rows, elapsed, height), SPEEDING * velocity))
        speed = stop - 0.5 * jerk * elapsed**2
        coasting = np.where(braking, 0.0, np.maximum(height - brake_distance(stop, rows), 0.0) / speed)
        down = brake(np.tile([0.0, 0.0, -1.0], (count, 1)), stop, rows).delay(coasting)
        down.durations[:, 1] = np.maximum(down.durations[:, 1] - elapsed, 0.0)
        zero = np.zeros(count)
        return cls(
            velocity=np.stack([zero, zero, -speed], axis=1),
            acceleration=np.stack([zero, zero, jerk * elapsed], axis=1),
            down=down,
        )


def _initial_speed(limits: LimitRows, elapsed: Floats, height: float) -> Floats:
    """Initial speed (N,) [m/s] of stops that still need ``height`` [m] after their first ``elapsed`` (N,) [s]."""
    _, acceleration, jerk = limits
    low = 0.5 * jerk * elapsed**2
    high = low + np.sqrt(2.0 * acceleration * height) + 2.0 * acceleration**2 / jerk
    return bisect(
        lambda speed: brake_distance(speed, limits) - (speed * elapsed - jerk * elapsed**3 / 6.0) < height,
        low,
        high,
        _HALVINGS,
    )[0]
