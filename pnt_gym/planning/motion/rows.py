"""Rows of motions: a hand and an object that the hand is to meet, their meeting, and a border of a path's segments."""

from __future__ import annotations

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.rows import Columns, Row, Triple, field


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
