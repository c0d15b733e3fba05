"""One throw at a time in plain floats: the same equations as the batch, without the cost of arrays.

``_crossing``, ``_optimum`` and ``_bounded`` hold the derivations; names and order of operations follow them.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

from pnt_gym.constants import GRAVITY
from pnt_gym.planning.motion.roots import GOLDEN
from pnt_gym.planning.straight.optimum import (
    BRACKET_STEPS,
    BRACKET_WIDTH,
    CROSSING_STEPS,
    CUBIC_STEPS,
    GOLDEN_STEPS,
    GRID,
    NEWTON_STEPS,
    SLOPE_PRECISION,
    TINY,
)

Slack = Callable[[float], float]
_SHARES = [k / GRID for k in range(GRID + 1)]
_DENSE_SHARES = [(1.0 - share) ** 2 for share in _SHARES]


class PlaneThrow(NamedTuple):
    """One throw in its vertical plane: reach X [m], rise Z [m] and the limits of the S-curve."""

    reach: float
    rise: float
    velocity: float
    acceleration: float
    jerk: float


class Box(NamedTuple):
    """Bounds of the release point seen from the pick [m]."""

    near: float
    far: float
    low: float
    high: float


def ramp_distance(speed: float, acceleration: float, jerk: float) -> float:
    """Return P_S(V) [m]."""
    if jerk * speed <= acceleration * acceleration:
        return speed * math.sqrt(speed / jerk)
    return 0.5 * speed * (speed / acceleration + acceleration / jerk)


def crossing(throw: PlaneThrow, slope: float) -> tuple[float, float]:
    """Return release distance [m] and speed [m/s] at the tangent ``slope`` of the elevation."""
    reach, rise, velocity, acceleration, jerk = throw
    length = reach * math.sqrt(1.0 + slope * slope)
    flight = math.sqrt(2.0 * max(reach * slope - rise, 0.0) / GRAVITY)
    cruising = length - velocity * flight
    if ramp_distance(velocity, acceleration, jerk) <= cruising:
        return cruising, velocity
    knee = min(acceleration * acceleration / jerk, velocity)
    if knee * math.sqrt(knee / jerk) + knee * flight <= length:
        linear = acceleration * (acceleration + 2.0 * jerk * flight)
        root = math.sqrt(linear * linear + 8.0 * jerk * jerk * acceleration * length)
        speed = 4.0 * jerk * acceleration * length / (linear + root)
    else:
        speed = _jerk_speed(length, flight, jerk)
    speed = min(speed, velocity)
    return ramp_distance(speed, acceleration, jerk), speed


def _jerk_speed(length: float, flight: float, jerk: float) -> float:
    scale = 1.0 / math.sqrt(jerk)
    w = min(math.cbrt(length / scale), math.sqrt(length / max(flight, TINY)))
    for _ in range(CROSSING_STEPS):
        w -= (w * w * (scale * w + flight) - length) / (w * (3.0 * scale * w + 2.0 * flight))
    return w * w


def best_slope(throw: PlaneThrow) -> float:
    """Return the tangent of the elevation of the quickest throw without bounds."""
    cap = _saturation_slope(throw)
    if _optimality(throw, cap)[0] <= 0.0:
        return cap
    reach, rise = throw.reach, throw.rise
    slant = math.sqrt(reach * reach + rise * rise)
    low = max(rise / reach, 0.0)
    u = high = min(cap, reach / (slant - rise) if rise < 0.0 else (rise + slant) / reach)
    for _ in range(NEWTON_STEPS):
        value, slope = _optimality(throw, u)
        if value < 0.0:
            low = u
        else:
            high = u
        before, u = u, u - value / slope
        if not low < u < high:
            u = 0.5 * (low + high)
        if abs(u - before) <= SLOPE_PRECISION * before:
            break
    return u


def _saturation_slope(throw: PlaneThrow) -> float:
    d = throw.velocity * throw.velocity / (2.0 * GRAVITY * throw.reach)
    b = throw.rise / throw.reach + d
    u = max(b, 0.0) + math.cbrt(d)
    if b < 0.0:
        u = min(u, math.sqrt(d / -b))
    for _ in range(CUBIC_STEPS):
        u -= (u * u * (u - b) - d) / (u * (3.0 * u - 2.0 * b))
    return u


def _optimality(throw: PlaneThrow, u: float) -> tuple[float, float]:
    reach, rise, _, acceleration, jerk = throw
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
    speed_slope = 0.5 * energy_slope / (speed if speed > 0.0 else 1.0)
    value = secant * way + reach * (u * u - 1.0) - 2.0 * rise * u
    return value, secant * way_slope * speed_slope + way * u / secant + 2.0 * (reach * u - rise)


def _slack_of(throw: PlaneThrow, box: Box) -> Slack:
    """Return the slack of the bounds as a function of the slope; a closure, because it is asked often."""
    reach, rise, velocity, acceleration, jerk = throw
    near, far, low, high = box
    level_roof = math.inf if low <= 0.0 <= high else -math.inf
    sqrt = math.sqrt

    def room(length: float, flight: float, distance: float) -> float:
        speed = (length - distance) / (flight or TINY)
        if speed <= 0.0:
            return min(distance, flight * velocity - (length - distance))
        way = ramp_distance(min(speed, velocity), acceleration, jerk)
        return min(distance - way, flight * velocity - (length - distance))

    def slack(slope: float) -> float:
        secant = sqrt(1.0 + slope * slope)
        length = reach * secant
        drop = reach * slope - rise
        flight = sqrt(2.0 * drop / GRAVITY) if drop > 0.0 else 0.0
        if slope > 0.0:
            roof, floor = high * (secant / slope), low * (secant / slope)
        elif slope < 0.0:
            roof, floor = low * (secant / slope), high * (secant / slope)
        else:
            roof, floor = level_roof, -math.inf
        longest = min(far * secant, roof)
        margin = math.inf if longest >= length else room(length, flight, longest)
        shortest = max(near * secant, floor)
        return margin if shortest <= 0.0 else min(margin, -room(length, flight, shortest))

    return slack


def bounded_slope(throw: PlaneThrow, box: Box, best: float, *, upward: bool) -> float | None:
    """Return the tangent of the quickest throw within bounds, None where there is none."""
    slack = _slack_of(throw, box)
    if slack(best) >= 0.0:
        return best
    foot = throw.rise / throw.reach
    if not upward and box.high >= 0.0:
        foot = max(foot, 0.0)
    answers = [_nearest(slack, [best * share + foot * (1.0 - share) for share in _DENSE_SHARES])]
    if upward:
        answers.append(_nearest(slack, [best + (1.0 + best) * (s / (1.0 - s)) for s in _SHARES[:-1]]))
    answers = [u for u in answers if u is not None and throw.reach * u - throw.rise > 0.0]
    return min(answers, key=lambda u: crossing(throw, u)[0], default=None)


def _nearest(slack: Slack, grid: list[float]) -> float | None:
    older, old = -math.inf, slack(grid[0])
    for k in range(1, len(grid)):
        value = slack(grid[k])
        climb = max(old - older, old - value)
        # The grid point before this one is a peak below zero: look between its neighbours.
        if older < old < 0.0 and value <= old and old + 2.0 * climb >= 0.0:
            near = grid[max(k - 2, 0)]
            peak, height = _golden(slack, near, grid[k])
            if height >= 0.0:
                return _border(slack, peak, near)
        if value >= 0.0:
            return _border(slack, grid[k], grid[k - 1])
        older, old = old, value
    return None


def _golden(slack: Slack, a: float, b: float) -> tuple[float, float]:
    c, d = b - GOLDEN * (b - a), a + GOLDEN * (b - a)
    fc, fd = slack(c), slack(d)
    for _ in range(GOLDEN_STEPS):
        if fc >= fd:
            b, d, fd = d, c, fc
            c = b - GOLDEN * (b - a)
            fc = slack(c)
        else:
            a, c, fc = c, d, fd
            d = a + GOLDEN * (b - a)
            fd = slack(d)
    return (c, fc) if fc >= fd else (d, fd)


def _border(slack: Slack, inside: float, outside: float) -> float:
    weight_in, weight_out = slack(inside), slack(outside)
    for step in range(BRACKET_STEPS):
        if abs(inside - outside) <= BRACKET_WIDTH * (1.0 + abs(inside)):
            break
        probe = 0.5 * (inside + outside)
        if step % 3 < 2 and math.isfinite(weight_in) and math.isfinite(weight_out):
            secant = (outside * weight_in - inside * weight_out) / (weight_in - weight_out)
            if (secant - inside) * (secant - outside) < 0.0:
                probe = secant
        value = slack(probe)
        if value >= 0.0:
            inside, weight_in, weight_out = probe, value, 0.5 * weight_out
        else:
            outside, weight_out, weight_in = probe, value, 0.5 * weight_in
    return inside
