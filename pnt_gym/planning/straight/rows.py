"""Throws along straight lines: rows of the throws to plan and of their lines, rules of the stops, ends of motions."""

from __future__ import annotations

from typing import NamedTuple

from pnt_gym.rows import Floats1, Floats2, Row, Triple, field


class Throw(Row):
    """A throw to plan."""

    pick: Triple = field("m", "start of the hand at rest")
    target: Triple = field("m", "point through which the object must pass on its way down")
    velocity: float = field("m/s", "limit of the speed")
    acceleration: float = field("m/s2", "limit of the acceleration")
    jerk: float = field("m/s3", "limit of the jerk")
    tolerance: float = field("m", "half width of the square box around the target")
    ceiling: float = field("m", "greatest height of the release point; may be infinite")
    near: float = field("m", "least horizontal distance from the pick to the release point")
    far: float = field("m", "greatest horizontal distance; may be infinite")
    low: float = field("m", "least height of the release point above the pick; may be infinite")
    high: float = field("m", "greatest height above the pick; may be infinite")


class ThrowLine(Row):
    """The line of a throw, from the pick to the release."""

    slope: float = field("-", "tangent of the elevation; NaN where there is no throw")
    moved: bool = field("-", "whether a bound moved the line")
    reason: int = field("-", "`Reason` why there is no throw")


class StopRules(NamedTuple):
    """Rules by which a hand stops after a throw."""

    window: float
    """Time between release and braking [s]."""
    gravity_share: float
    """Share of gravity with which the hand may fall while braking; 0 for full braking."""
    reserve: float
    """Displacement of the target along the throw, forth and back, with which a throw has to be possible [m]."""


class Ends(NamedTuple):
    """Ends of N throws: times of the releases and of the stops (N,) [s], and points of the stops (N, 3) [m]."""

    release_time: Floats1
    stop_time: Floats1
    stop: Floats2
