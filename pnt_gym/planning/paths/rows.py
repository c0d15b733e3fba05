"""Rows of motions along ellipses: the arc, and the phases of a law of the speed along the arc."""

from __future__ import annotations

from pnt_gym.rows import Row, field


class Arc(Row):
    """The upper half of an ellipse that runs vertically at both ends, with the limits of the hand."""

    width: float = field("m", "half of the width")
    rise: float = field("m", "half of the rise from start to end")
    chord: float = field("m", "half of the vertical chord through the middle")
    velocity: float = field("m/s", "limit of the speed")
    acceleration: float = field("m/s2", "limit of the acceleration")
    jerk: float = field("m/s3", "limit of the jerk")


class Phase(Row):
    """A phase of constant jerk along an arc, at its start."""

    start: float = field("s", "time")
    way: float = field("m", "arc length up to the phase")
    speed: float = field("m/s", "speed along the arc")
    acceleration: float = field("m/s2", "acceleration along the arc")
    jerk: float = field("m/s3", "jerk along the arc")
