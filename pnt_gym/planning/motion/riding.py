"""Motions that begin or end at the speed of a belt, made of motions between rests.

A hand that rides with a belt need not stop before it throws. Its motion is the sum of two: one that begins at rest at a
virtual start, planned as any other, and the belt's velocity s, which fades away within a time T. Its deceleration is a
triangle, with the peak a = 2 s / T and the jerk j = 4 s / T2, and its way is s T / 2. So the hand truly starts that way
upstream of the virtual start, and from T on the sum *is* the planned motion. Seen backwards in time the same sum brings
a hand from rest to the belt's speed.

Planned motions may use what the fading leaves of acceleration and jerk, A - a and J - j; then the sum keeps A and J,
whatever the directions are. Of the speed limit nothing need be set aside: no motion from rest under A - a, J - j and V
is faster at any time t than V less what has not faded by then, if

    T <= (V + s) / A + A / J,    a <= A / 2,    A2 <= J V.

For the quickest such motion comes to V, without acceleration, at V / (A - a) + (A - a) / (J - j), which is not before
T: with w = V / A + A / J - s / A that is (s / A) (w - 2 V / A)2 >= 0. From the end backwards it has at every time at
least the fading's acceleration, so the speed that it still lacks is at least what has not faded.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Self, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, joined
from pnt_gym.planning.motion.limits import LimitRows, Limits
from pnt_gym.planning.motion.roots import bisect
from pnt_gym.planning.motion.scurve import coast, line_segments, peaks, stroke_time
from pnt_gym.planning.motion.trajectory import Segments

DOWNSTREAM: Final = np.array([1.0, 0.0, 0.0])
"""Belts move along x."""
MOST_SHARE: Final = 0.5
"""Of the acceleration, for the fading."""
USUAL_SPEED: Final = 2.5
"""Fadings take about as long as a hand needs to this release speed [m/s]: longer ones would keep throws waiting."""
_HALVINGS: Final = 60


@final
@dataclass(frozen=True)
class Fading:
    """How the belt's velocity fades from N hands, or grows on them."""

    speed: float
    """Of the belt [m/s]."""
    time: Floats
    """How long it takes (N,) [s]."""

    @classmethod
    def under(cls, limits: Limits, count: int, speed: float) -> Self:
        """Fadings of a belt's speed [m/s] that leave ``count`` hands their speed limit."""
        velocity, acceleration, jerk = limits.arrays(count)
        longest = (velocity + speed) / acceleration + acceleration / jerk
        usual = (USUAL_SPEED + speed) / acceleration + acceleration / jerk
        return cls(speed, np.minimum(longest, np.maximum(usual, _shortest(speed, acceleration))))

    @property
    def way(self) -> Floats:
        """Covered by the fading velocity (N,) [m]."""
        return self.speed * self.time / 2.0

    def is_possible(self, limits: Limits) -> Bools:
        """Whether it takes no more than its share of the limits (N,)."""
        return self.time >= _shortest(self.speed, limits.arrays(len(self.time)).acceleration)

    def left(self, limits: Limits) -> LimitRows:
        """Limits of the motions it is added to; placeholders where it is not possible."""
        velocity, acceleration, jerk = limits.arrays(len(self.time))
        least = 1.0 - MOST_SHARE
        own = 2.0 * self.speed / self.time
        return LimitRows(
            velocity,
            np.maximum(acceleration - own, least * acceleration),
            np.maximum(jerk - 2.0 * own / self.time, least * jerk),
        )

    def out(self) -> Segments:
        """From the belt's speed to rest."""
        return self._halves(-1.0)

    def into(self, begin: Floats) -> Segments:
        """From rest to the belt's speed, from times (N,) [s] on."""
        return joined([coast(begin), self._halves(1.0)], axis=1)

    def _halves(self, sign: float) -> Segments:
        jerk = 4.0 * sign * self.speed / self.time**2
        half = 0.5 * self.time
        along = np.tile(DOWNSTREAM, (len(half), 1))
        return line_segments(along, np.stack([half, half], axis=1), np.stack([jerk, -jerk], axis=1))


def arrival_time(limits: LimitRows, speed: float, drop: float) -> float:
    """Over how long the belt's velocity may grow at the end of returns under any of N limits [s].

    Args:
        limits: N.
        speed: of the belt [m/s].
        drop: height of a descent from rest to rest that ends every return [m]; 0 where there may be none.

    What the hand does before a descent of time D is over at rest then, so the growing may begin D earlier than the
    hand can come to rest from its greatest speed; half way, where both overlap, the hand is slow enough by far, or no
    use is made of this.
    """
    velocity, acceleration, jerk = limits
    usual = Fading.under(limits, len(velocity), speed).time.min()
    height = np.full(len(velocity), drop)
    slow = np.maximum(peaks(height, *limits)[0], 0.5 * acceleration**2 / jerk) + speed <= velocity
    stopping = stroke_time(height, *limits) + velocity / acceleration + acceleration / jerk
    return float(max(usual, stopping.min()) if slow.all() else usual)


def fastest_belt(limits: LimitRows) -> float:
    """The fastest belt [m/s] that N hands can ride with, if all take the time that the quickest of them needs."""
    count = len(limits.velocity)

    def rides(speed: Floats) -> Bools:
        time = Fading.under(limits, count, float(speed[0])).time.min()
        return np.array([Fading(float(speed[0]), np.full(count, time)).is_possible(limits).all()])

    return float(bisect(rides, np.zeros(1), limits.velocity.max(keepdims=True), _HALVINGS)[0][0])


def _shortest(speed: float, acceleration: Floats) -> Floats:
    """Fadings that take their full share of limits (N,) [m/s2], (N,) [s]."""
    return 2.0 * speed / (MOST_SHARE * acceleration)
