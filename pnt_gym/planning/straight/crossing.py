"""Release of a throw along a line, and the quickest line without bounds. Compiled; see `pnt_gym.compiled`.

**Crossing.** In the vertical plane of a throw let X be the horizontal distance from the pick to the target, Z the
height of the target above the pick and u the tangent of the elevation. A release at distance P with speed V on that
line hits the target when P + V c = L, where L = X sqrt(1 + u^2) is the length of the line up to above the target and
c = sqrt(2 (X u - Z) / g) is the time of flight (Hassan et al. 2022, Eq. 20). The S-curve adds V = V_S(P); with its
inverse P = P_S(V) the condition is P_S(V) + V c = L, whose left side grows with V, so there is exactly one crossing.

**Optimum.** Where nothing bounds the release point, the object of the quickest throw lands at right angles to its
release direction: V = g c sin(theta). In the crossing this speed leaves one equation in u = tan(theta), with no inner
solve and one root:

    H(u) = sqrt(1 + u^2) P_S(V(u)) + X u^2 - 2 Z u - X = 0,   V(u)^2 = 2 g (X u - Z) u^2 / (1 + u^2).

Where that speed exceeds Vmax the release happens at Vmax, and V(u) = Vmax is a cubic with one positive root. The
optimum is the smaller of the two roots. H is not negative at u = (Z + sqrt(X^2 + Z^2)) / X, the elevation of least
speed for a release at the pick, so the root of H lies below this elevation.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pnt_gym.compiled import kernel_part
from pnt_gym.constants import GRAVITY
from pnt_gym.planning.motion.strokes import ramp_distance
from pnt_gym.planning.straight.rows import Throw

# Newton steps for the cubic of the jerk-only crossing: its start is within a factor sqrt(2) of the root, from
# where five steps reach rounding.
CROSSING_STEPS = 7
# Replaces a flight time of zero, at the foot of the elevation range.
TINY = 1e-300
CUBIC_STEPS = 9
NEWTON_STEPS = 80
# Newton's error squares with every step: after a step this small the next step is below rounding.
SLOPE_PRECISION = 1e-9


class PlaneThrow(NamedTuple):
    """One throw in its vertical plane: reach X [m], rise Z [m] and the limits of the S-curve."""

    reach: float
    rise: float
    velocity: float
    acceleration: float
    jerk: float


class Line(NamedTuple):
    """Line of a throw: distance to the release [m], speed at the release [m/s], and unit vector."""

    distance: float
    speed: float
    x: float
    y: float
    z: float


@kernel_part
def lay_out(throw: Throw) -> tuple[PlaneThrow, float, float]:
    """Throw in its plane, cosine and sine of its azimuth; reach is shortened by the tolerance and may be negative."""
    x, y = throw.target[0] - throw.pick[0], throw.target[1] - throw.pick[1]
    full = math.sqrt(x * x + y * y)
    cosine, sine = (x / full, y / full) if full > 0.0 else (1.0, 0.0)
    reach = full - throw.tolerance / max(abs(cosine), abs(sine))
    rise = throw.target[2] - throw.pick[2]
    return PlaneThrow(reach, rise, throw.velocity, throw.acceleration, throw.jerk), cosine, sine


@kernel_part
def flight_time(throw: PlaneThrow, slope: float) -> float:
    """Time of flight c [s] at the tangent ``slope`` of the elevation."""
    drop = throw.reach * slope - throw.rise
    return math.sqrt(2.0 * (drop if drop > 0.0 else 0.0) / GRAVITY)


@kernel_part
def crossing(throw: PlaneThrow, slope: float) -> tuple[float, float]:
    """Release distance P [m] and speed V [m/s] at the tangent ``slope`` of the elevation."""
    velocity, acceleration, jerk = throw.velocity, throw.acceleration, throw.jerk
    length, flight = throw.reach * math.sqrt(1.0 + slope * slope), flight_time(throw, slope)
    cruising = length - velocity * flight
    if ramp_distance(velocity, acceleration, jerk) <= cruising:
        return cruising, velocity
    knee = min(acceleration * acceleration / jerk, velocity)
    if knee * math.sqrt(knee / jerk) + knee * flight <= length:
        speed = _plateau_speed(length, flight, acceleration, jerk)
    else:
        speed = _jerk_speed(length, flight, jerk)
    speed = min(speed, velocity)
    return ramp_distance(speed, acceleration, jerk), speed


@kernel_part
def _plateau_speed(length: float, flight: float, acceleration: float, jerk: float) -> float:
    """Root of J V^2 + (A^2 + 2 J A c) V = 2 J A L: segment 2 of V_S, free of cancellation."""
    linear = acceleration * (acceleration + 2.0 * jerk * flight)
    root = math.sqrt(linear * linear + 8.0 * jerk * jerk * acceleration * length)
    return 4.0 * jerk * acceleration * length / (linear + root)


@kernel_part
def _jerk_speed(length: float, flight: float, jerk: float) -> float:
    """Square of the root of w^3 / sqrt(J) + c w^2 = L: segment 1 of V_S, V = w^2."""
    scale = 1.0 / math.sqrt(jerk)
    w = min(np.cbrt(length / scale), math.sqrt(length / max(flight, TINY)))
    for _ in range(CROSSING_STEPS):
        value = w * w * (scale * w + flight) - length
        w -= value / (w * (3.0 * scale * w + 2.0 * flight))
    return w * w


@kernel_part
def best_slope(throw: PlaneThrow) -> float:
    """Tangent of the elevation of the quickest throw without bounds, by Newton's method inside a shrinking bracket."""
    cap = _saturation_slope(throw)
    if _optimality(throw, cap)[0] <= 0.0:
        return cap
    # The elevation of least speed, (Z + sqrt(X^2 + Z^2)) / X, without cancellation for Z < 0.
    reach, rise = throw.reach, throw.rise
    slant = math.sqrt(reach * reach + rise * rise)
    steepest = reach / (slant - rise) if rise < 0.0 else (rise + slant) / reach
    low = max(rise / reach, 0.0)
    u = high = min(cap, steepest)
    for _ in range(NEWTON_STEPS):
        value, slope = _optimality(throw, u)
        low, high = (u, high) if value < 0.0 else (low, u)
        before = u
        u -= value / slope
        if not low < u < high:
            u = 0.5 * (low + high)
        if abs(u - before) <= SLOPE_PRECISION * before:
            break
    return u


@kernel_part
def _saturation_slope(throw: PlaneThrow) -> float:
    """Tangent of the elevation at which the optimal speed reaches Vmax: root of u^3 - b u^2 - d = 0.

    Newton's method starts above the root, where the cubic is convex, and comes down monotonically.
    """
    d = throw.velocity * throw.velocity / (2.0 * GRAVITY * throw.reach)
    b = throw.rise / throw.reach + d
    u = max(b, 0.0) + np.cbrt(d)
    if b < 0.0:
        u = min(u, math.sqrt(d / -b))
    for _ in range(CUBIC_STEPS):
        before = u
        u -= (u * u * (u - b) - d) / (u * (3.0 * u - 2.0 * b))
        if u == before:
            break
    return u


@kernel_part
def _optimality(throw: PlaneThrow, u: float) -> tuple[float, float]:
    """H(u) of the module's docstring and its derivative by u."""
    reach, rise, acceleration, jerk = throw.reach, throw.rise, throw.acceleration, throw.jerk
    square = 1.0 + u * u
    secant = math.sqrt(square)
    drop = max(reach * u - rise, 0.0)
    share = u * u / square
    energy_slope = 2.0 * GRAVITY * (reach * share + 2.0 * drop * u / (square * square))
    speed = math.sqrt(2.0 * GRAVITY * drop * share)
    root = math.sqrt(speed * jerk)
    if root <= acceleration:
        way, way_slope = speed * root / jerk, 1.5 * root / jerk
    else:
        way = 0.5 * speed * (speed / acceleration + acceleration / jerk)
        way_slope = speed / acceleration + 0.5 * acceleration / jerk
    # dP/dV, then dV/du = (dE/du) / (2 V); the two branches share 1 / (2 V).
    speed_slope = 0.5 * energy_slope / (speed if speed > 0.0 else 1.0)
    value = secant * way + reach * (u * u - 1.0) - 2.0 * rise * u
    return value, secant * way_slope * speed_slope + way * u / secant + 2.0 * (reach * u - rise)
