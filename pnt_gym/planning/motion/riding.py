"""Motions that begin or end at the speed of a belt, made of motions between rests.

A hand that rides with a belt need not stop before it throws. The hand's motion is the sum of a planned motion, which
begins at rest at a virtual start, and a fading: the belt's velocity s, which falls to zero within a time T. The fade's
deceleration is a triangle over time, with the peak a = 2 s / T and the jerk j = 4 s / T2; the fade's way is s T / 2.
So the hand starts by s T / 2 upstream of the virtual start, and from T on the sum *is* the planned motion. Reversed in
time, the same sum brings a hand from rest to the belt's speed.

Planned motions may use the acceleration and jerk that the fading leaves, A - a and J - j; then the sum keeps A and J,
whatever the directions are. The speed limit V need not be reduced: no motion from rest under A - a, J - j and V is
faster at any time t than V less the fading's speed at t, if

    T <= (V + s) / A + A / J,    a <= A / 2,    A2 <= J V.

Reason: the quickest motion reaches V, without acceleration, at V / (A - a) + (A - a) / (J - j), which is not before T:
with w = V / A + A / J - s / A this condition is (s / A) (w - 2 V / A)2 >= 0. Backwards in time from V, the quickest
motion has at every time at least the fading's acceleration, so its speed is below V by at least the fading's speed.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Final

import numpy as np

from pnt_gym.arrays import Bools, Floats
from pnt_gym.planning.motion.kernel import fade, strokes
from pnt_gym.planning.motion.limits import LimitRows
from pnt_gym.planning.motion.roots import bisect

DOWNSTREAM: Final = np.array([1.0, 0.0, 0.0])
"""Direction in which belts move."""
_HALVINGS: Final = 60


def arrival_time(limits: LimitRows, speed: float, drop: float) -> float:
    """Longest time [s] over which the belt's velocity may grow at the end of returns, under each of N limits.

    The hand is at rest before a descent of duration D, so the growth may take D plus the time of a stop from the hand's
    greatest speed. This longer time is used only where the descent is so slow that descent and belt speed together keep
    the speed limit.

    Args:
        limits: limits of N hands.
        speed: speed of the belt [m/s].
        drop: height of a descent from rest to rest that ends every return [m]; 0 where there may be none.
    """
    velocity, acceleration, jerk = limits
    usual = fade(limits, speed, 0.0).time.min()
    descent = strokes(np.full(len(velocity), drop), limits)
    slow = np.maximum(descent["speed"], 0.5 * acceleration**2 / jerk) + speed <= velocity
    stopping = descent["time"] + velocity / acceleration + acceleration / jerk
    return float(max(usual, stopping.min()) if slow.all() else usual)


def fastest_belt(limits: LimitRows) -> float:
    """The fastest belt [m/s] with which N hands can ride, if all hands take the shortest of their fading times."""
    return _fastest_belt(*(tuple(column.tolist()) for column in limits))


@lru_cache(maxsize=256)
def _fastest_belt(*columns: tuple[float, ...]) -> float:
    """`fastest_belt` by the columns of the limits: every level that is read asks, mostly for the same hands."""
    limits = LimitRows(*map(np.array, columns))

    def rides(speed: Floats) -> Bools:
        time = fade(limits, speed.item(), 0.0).time.min()
        return np.array([fade(limits, speed.item(), time).is_possible.all()])

    return float(bisect(rides, np.zeros(1), limits.velocity.max(keepdims=True), _HALVINGS)[0][0])
