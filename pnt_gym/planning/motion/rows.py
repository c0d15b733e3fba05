"""Rows of motions: segments and borders of paths, strokes, a hand and the object that the hand is to meet."""

from __future__ import annotations

from typing import NamedTuple, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, length
from pnt_gym.planning.motion.limits import LimitRows
from pnt_gym.rows import Bools1, Columns, Floats1, Floats2, Floats3, Row, Triple, field


@final
class Segments(NamedTuple):
    """Consecutive pieces of constant jerk.

    Attributes:
        durations: (N, K) [s].
        jerks: (N, K, 3) [m/s3].
    """

    durations: Floats2
    jerks: Floats3

    def pad(self, columns: int) -> Segments:
        """Return the same motions, filled up to ``columns`` segments with segments of no duration."""
        rows, count = self.durations.shape
        durations, jerks = np.zeros((rows, columns)), np.zeros((rows, columns, 3))
        durations[:, :count], jerks[:, :count] = self.durations, self.jerks
        return Segments(durations, jerks)

    def delay(self, time: Floats) -> Segments:
        """Return the same motions after a time (N,) [s] without jerk."""
        durations = np.concatenate([time[:, None], self.durations], axis=1)
        jerks = np.zeros((*durations.shape, 3))
        jerks[:, 1:] = self.jerks
        return Segments(durations, jerks)

    def greatest_acceleration(self) -> Floats:
        """Return the greatest acceleration (N,) [m/s2] of motions that start without acceleration."""
        return length(np.cumsum(self.durations[..., None] * self.jerks, axis=1)).max(axis=1)


class Start(NamedTuple):
    """Where N paths begin: position [m], velocity [m/s] and acceleration [m/s2], each (N, 3)."""

    position: Floats2
    velocity: Floats2
    acceleration: Floats2


class Borders(NamedTuple):
    """Borders of the K segments of N paths: times (N, K + 1) [s], and the motion there, each (N, K + 1, 3)."""

    time: Floats2
    position: Floats3
    velocity: Floats3
    acceleration: Floats3


class Fading(NamedTuple):
    """Fadings of a belt's velocity from N hands, or its growths on them."""

    time: Floats1
    """Durations T (N,) [s]."""
    lead: Floats2
    """Virtual starts relative to the true starts (N, 3): the ways s T / 2 of the fading velocities [m]."""
    is_possible: Bools1
    """Whether the fadings take no more than their share of the limits (N,)."""
    left: LimitRows
    """Limits that the fadings leave to the planned motions; placeholders where a fading is not possible."""


class Hunt(Row):
    """A hand at rest and an object that the hand is to meet."""

    hand: Triple = field("m", "position of the hand")
    place: Triple = field("m", "position of the hand that would pick the object at time 0")
    belt: Triple = field("m/s", "velocity of the object")
    clearance: float = field("m", "height above the pick at which the vertical descent starts")
    velocity: float = field("m/s", "limit of the hand's speed")
    acceleration: float = field("m/s2", "limit of the hand's acceleration")
    jerk: float = field("m/s3", "limit of the hand's jerk")
    low: float = field("m", "least coordinate at which the object may be picked")
    high: float = field("m", "greatest coordinate at which the object may be picked")
    earliest: float = field("s", "time before which the object may not be picked")


class Intercept(Columns):
    """N meetings of hand and object; NaN in rows without a meeting."""

    time: Floats = field("s", "time at which the hand touches the object")
    position: Triple = field("m", "position of the hand at that time")
    wait: Floats = field("s", "time of waiting above the object's path because the object may not be picked yet")
    travel: Floats = field("s", "time of the move to the point above; travel + wait + descent = time")
    descent: Floats = field("s", "time of the move down")
    feasible: Bools = field("-", "whether the object can be picked")
    reason: Ints = field("-", "`InterceptReason` code, 0 where feasible")


class Knot(Row):
    """The motion of a path from a border of two segments on; the first row of a path holds before its first border."""

    position: Triple = field("m", "position at the border")
    velocity: Triple = field("m/s", "velocity at the border")
    acceleration: Triple = field("m/s2", "acceleration at the border")
    jerk: Triple = field("m/s3", "jerk from the border on")
    time: float = field("s", "time of the border; the first border's for the row before it")


class Stroke(Row):
    """The quickest motion over a distance, from rest to rest."""

    speed: float = field("m/s", "greatest speed")
    acceleration: float = field("m/s2", "greatest acceleration")
    ramp: float = field("s", "duration of each phase of jerk")
    plateau: float = field("s", "duration of each phase of greatest acceleration")
    cruise: float = field("s", "duration of the phase at the greatest speed")
    time: float = field("s", "duration of the motion")
