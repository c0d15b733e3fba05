"""The elevation of the quickest throw when nothing bounds the release point.

At the optimum the object lands at right angles to its release direction: V = g c sin(theta). Put into the
crossing P_S(V) + V c = L this leaves one equation in u = tan(theta), with no inner solve and one root:

    H(u) = sqrt(1 + u^2) P_S(V(u)) + X u^2 - 2 Z u - X = 0,   V(u)^2 = 2 g (X u - Z) u^2 / (1 + u^2).

Where that speed exceeds Vmax the release happens at Vmax, and V(u) = Vmax is a cubic with one positive root.
The optimum is the smaller of the two roots. H is not negative at u = (Z + sqrt(X^2 + Z^2)) / X, the elevation
of least speed for a release at the pick, so its root lies below that.
"""

from __future__ import annotations

import numpy as np

from pnt_gym.arrays import Floats, take
from pnt_gym.constants import GRAVITY
from pnt_gym.planning.straight.crossing import ThrowPlane

CUBIC_STEPS = 9
NEWTON_STEPS = 80
# Newton's error squares with every step: the step after one this small is below rounding.
SLOPE_PRECISION = 1e-9


def best_slope(plane: ThrowPlane) -> Floats:
    """Return the tangent (N,) of the elevation of the quickest throw."""
    cap = saturation_slope(plane)
    low = np.maximum(plane.rise / plane.reach, 0.0)
    top = np.minimum(cap, _steepest(plane))
    return np.where(_optimality(plane, cap)[0] <= 0.0, cap, _root(plane, low, top))


def saturation_slope(plane: ThrowPlane) -> Floats:
    """Return the tangent (N,) at which the optimal speed reaches Vmax: root of u^3 - b u^2 - d = 0.

    Newton's method starts above the root, where the cubic is convex, and comes down monotonically.
    """
    d = plane.velocity * plane.velocity / (2.0 * GRAVITY * plane.reach)
    b = plane.rise / plane.reach + d
    u = np.maximum(b, 0.0) + np.cbrt(d)
    u = np.where(b < 0.0, np.minimum(u, np.sqrt(d / np.where(b < 0.0, -b, 1.0))), u)
    for _ in range(CUBIC_STEPS):
        u = u - (u * u * (u - b) - d) / (u * (3.0 * u - 2.0 * b))
    return u


def _steepest(plane: ThrowPlane) -> Floats:
    """(Z + sqrt(X^2 + Z^2)) / X without cancellation for Z < 0."""
    slant = np.sqrt(plane.reach * plane.reach + plane.rise * plane.rise)
    below = plane.rise < 0.0
    return np.where(below, plane.reach / (slant - np.minimum(plane.rise, 0.0)), (plane.rise + slant) / plane.reach)


def _optimality(plane: ThrowPlane, u: Floats) -> tuple[Floats, Floats]:
    """H(u) and its derivative."""
    reach, rise, acceleration, jerk = plane.reach, plane.rise, plane.acceleration, plane.jerk
    square = 1.0 + u * u
    secant = np.sqrt(square)
    drop = np.maximum(reach * u - rise, 0.0)
    share = u * u / square
    energy = 2.0 * GRAVITY * drop * share
    energy_slope = 2.0 * GRAVITY * (reach * share + 2.0 * drop * u / (square * square))
    speed = np.sqrt(energy)
    root = np.sqrt(speed * jerk)
    jerk_only = root <= acceleration
    way = np.where(jerk_only, speed * root / jerk, 0.5 * speed * (speed / acceleration + acceleration / jerk))
    # dP/dV, then dV/du = (dE/du) / (2 V); the two branches share 1 / (2 V).
    way_slope = np.where(jerk_only, 1.5 * root / jerk, speed / acceleration + 0.5 * acceleration / jerk)
    speed_slope = 0.5 * energy_slope / np.where(speed > 0.0, speed, 1.0)
    value = secant * way + reach * (u * u - 1.0) - 2.0 * rise * u
    slope = secant * way_slope * speed_slope + way * u / secant + 2.0 * (reach * u - rise)
    return value, slope


def _root(plane: ThrowPlane, low: Floats, high: Floats) -> Floats:
    """Root of H in (low, high) by Newton's method kept inside a shrinking bracket; finished rows drop out."""
    u, answer = high, high.copy()
    live = np.arange(u.shape[0], dtype=np.int64)
    for _ in range(NEWTON_STEPS):
        value, slope = _optimality(plane, u)
        low = np.where(value < 0.0, u, low)
        high = np.where(value < 0.0, high, u)
        step = u - value / slope
        following = np.where((step > low) & (step < high), step, 0.5 * (low + high))
        answer[live] = following
        going = np.abs(following - u) > SLOPE_PRECISION * u
        if not going.any():
            break
        if not going.all():
            live, plane, following = live[going], take(plane, going), following[going]
            low, high = low[going], high[going]
        u = following
    return answer
