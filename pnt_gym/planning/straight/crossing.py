"""Where the S-curve meets the target: release distance and speed at a given elevation, in closed form.

In the vertical plane of a throw let X be the horizontal distance from the pick to the target, Z the height of
the target above the pick and u the tangent of the elevation. A release at distance P with speed V on that
line hits the target when P + V c = L, where L = X sqrt(1 + u^2) is the length of the line up to above the
target and c = sqrt(2 (X u - Z) / g) is the time of flight (Hassan et al. 2022, Eq. 20). The S-curve adds V =
V_S(P); written as P = P_S(V) that makes P_S(V) + V c = L, whose left side grows with V, so there is exactly
one crossing.

Every operation is elementwise, so that a row never depends on its neighbours.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.constants import GRAVITY

# Newton steps for the cubic of the jerk-only crossing: its start is within a factor sqrt(2) of the root, from
# where five steps reach rounding.
CROSSING_STEPS = 7
# Stands in for a flight time of zero, at the very foot of the elevation range.
TINY = 1e-300


class ThrowPlane(NamedTuple):
    """N throws, each in its vertical plane: reach X [m], rise Z [m] and the limits of the S-curve."""

    reach: Floats
    rise: Floats
    velocity: Floats
    acceleration: Floats
    jerk: Floats

    def line(self, slope: Floats) -> tuple[Floats, Floats]:
        """Return length L [m] and flight time c [s] at the tangent ``slope`` of the elevation."""
        drop = np.maximum(self.reach * slope - self.rise, 0.0)
        return self.reach * np.sqrt(1.0 + slope * slope), np.sqrt(2.0 * drop / GRAVITY)


def ramp_distance(speed: Floats, acceleration: Floats, jerk: Floats) -> Floats:
    """Return P_S(V) [m], the shortest way from rest to ``speed`` without acceleration left: V_S inverted."""
    jerk_only = jerk * speed <= acceleration * acceleration
    plateau = 0.5 * speed * (speed / acceleration + acceleration / jerk)
    return np.where(jerk_only, speed * np.sqrt(speed / jerk), plateau)


def crossing(plane: ThrowPlane, slope: Floats) -> tuple[Floats, Floats]:
    """Return the release distance P [m] and speed V [m/s] at the tangent ``slope`` of the elevation."""
    length, flight = plane.line(slope)
    velocity, acceleration, jerk = plane.velocity, plane.acceleration, plane.jerk
    cruising = length - velocity * flight
    knee = np.minimum(acceleration * acceleration / jerk, velocity)
    beyond_knee = knee * np.sqrt(knee / jerk) + knee * flight <= length
    speed = np.where(beyond_knee, _plateau_speed(length, flight, acceleration, jerk), _jerk_speed(length, flight, jerk))
    saturated = ramp_distance(velocity, acceleration, jerk) <= cruising
    speed = np.where(saturated, velocity, np.minimum(speed, velocity))
    return np.where(saturated, cruising, ramp_distance(speed, acceleration, jerk)), speed


def _plateau_speed(length: Floats, flight: Floats, acceleration: Floats, jerk: Floats) -> Floats:
    """Root of J V^2 + (A^2 + 2 J A c) V = 2 J A L: segment 2 of V_S, free of cancellation."""
    linear = acceleration * (acceleration + 2.0 * jerk * flight)
    root = np.sqrt(linear * linear + 8.0 * jerk * jerk * acceleration * length)
    return 4.0 * jerk * acceleration * length / (linear + root)


def _jerk_speed(length: Floats, flight: Floats, jerk: Floats) -> Floats:
    """Square of the root of w^3 / sqrt(J) + c w^2 = L: segment 1 of V_S, V = w^2."""
    scale = 1.0 / np.sqrt(jerk)
    w = np.minimum(np.cbrt(length / scale), np.sqrt(length / np.maximum(flight, TINY)))
    for _ in range(CROSSING_STEPS):
        value = w * w * (scale * w + flight) - length
        w = w - value / (w * (3.0 * scale * w + 2.0 * flight))
    return w * w
