"""Where and how fast a throw along a line releases, and which line is the quickest: closed forms and root finding.

**Crossing.** In the vertical plane of a throw let X be the horizontal distance from the pick to the target, Z the
height of the target above the pick and u the tangent of the elevation. A release at distance P with speed V on that
line hits the target when P + V c = L, where L = X sqrt(1 + u^2) is the length of the line up to above the target and
c = sqrt(2 (X u - Z) / g) is the time of flight (Hassan et al. 2022, Eq. 20). The S-curve adds V = V_S(P); written as
P = P_S(V) that makes P_S(V) + V c = L, whose left side grows with V, so there is exactly one crossing.

**Optimum.** Where nothing bounds the release point, the object of the quickest throw lands at right angles to its
release direction: V = g c sin(theta). Put into the crossing this leaves one equation in u = tan(theta), with no inner
solve and one root:

    H(u) = sqrt(1 + u^2) P_S(V(u)) + X u^2 - 2 Z u - X = 0,   V(u)^2 = 2 g (X u - Z) u^2 / (1 + u^2).

Where that speed exceeds Vmax the release happens at Vmax, and V(u) = Vmax is a cubic with one positive root. The
optimum is the smaller of the two roots. H is not negative at u = (Z + sqrt(X^2 + Z^2)) / X, the elevation of least
speed for a release at the pick, so its root lies below that.

**Bounds.** Seen from the pick, the release point may lie between ``near`` and ``far`` horizontally and between ``low``
and ``high`` vertically: a ceiling, a workspace. The release distance grows on either side of the free optimum, so the
bounded optimum is the feasible elevation next to it: the greatest one below, or with a workspace perhaps the least one
above. The feasible set can fall apart into intervals (a flat and a steep way to throw), so it is searched on a grid
from the free optimum outwards, and a peak of the slack between two grid points that might reach zero is looked at
closely. Bounds translate to bounds on the distance, and P*(u) <= p can be asked without solving for P*: it holds when
the speed that a release at p would need, (L - p) / c, is allowed and is reached within p.

Every operation is elementwise, so that a row never depends on its neighbours.
"""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np

from pnt_gym.arrays import Floats, Ints, take
from pnt_gym.constants import GRAVITY
from pnt_gym.planning.motion.limits import LineBounds
from pnt_gym.planning.motion.roots import highest

# Newton steps for the cubic of the jerk-only crossing: its start is within a factor sqrt(2) of the root, from
# where five steps reach rounding.
CROSSING_STEPS = 7
# Stands in for a flight time of zero, at the very foot of the elevation range.
TINY = 1e-300
CUBIC_STEPS = 9
NEWTON_STEPS = 80
# Newton's error squares with every step: the step after one this small is below rounding.
SLOPE_PRECISION = 1e-9
GRID = 96
GOLDEN_STEPS = 40
BRACKET_STEPS = 100
# A bracket this narrow, relative to the slope plus one, is an answer.
BRACKET_WIDTH = 2e-16
# Rows whose grid is evaluated together; few enough for it to stay in cache.
ROWS_AT_ONCE = 256


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


def slack(plane: ThrowPlane, bounds: LineBounds, slope: Floats) -> Floats:
    """Return a margin [m], continuous in ``slope``, that is negative exactly where a bound is broken."""
    secant = np.sqrt(1.0 + slope * slope)
    length, flight = plane.line(slope)
    rising, level = slope > 0.0, slope == 0.0
    per_height = secant / np.where(level, 1.0, slope)
    roof = np.where(rising, bounds.high, bounds.low) * per_height
    floor = np.where(rising, bounds.low, bounds.high) * per_height
    level_open = (bounds.low <= 0.0) & (bounds.high >= 0.0)
    roof = np.where(level, np.where(level_open, np.inf, -np.inf), roof)
    floor = np.where(level, -np.inf, floor)
    longest = np.minimum(np.minimum(length, bounds.far * secant), roof)
    shortest = np.maximum(bounds.near * secant, floor)
    # The crossing never lies beyond the full line, so a bound that leaves the line whole cannot bind.
    margin = np.where(longest < length, _room(plane, length, flight, longest), np.inf)
    held = shortest > 0.0
    if not held.any():
        return margin
    return np.where(held, np.minimum(margin, -_room(plane, length, flight, shortest)), margin)


def _room(plane: ThrowPlane, length: Floats, flight: Floats, distance: Floats) -> Floats:
    """Negative exactly where the crossing lies beyond ``distance``."""
    with np.errstate(over="ignore"):
        speed = np.maximum((length - distance) / np.maximum(flight, TINY), 0.0)
    way = ramp_distance(np.minimum(speed, plane.velocity), plane.acceleration, plane.jerk)
    return np.minimum(distance - way, flight * plane.velocity - (length - distance))


def bounded_slope(plane: ThrowPlane, bounds: LineBounds, best: Floats, *, upward: bool) -> Floats:
    """Return the tangent (N,) of the quickest throw within bounds, NaN where there is none.

    Args:
        plane: the throws.
        bounds: bounds of the release point.
        best: tangents of the free optimum.
        upward: search elevations above the free optimum too (needed for bounds other than a ceiling).
    """
    answer = best.copy()
    rows = np.flatnonzero(slack(plane, bounds, best) < 0.0)
    own, held, free = take(plane, rows), take(bounds, rows), best[rows]
    foot = own.rise / own.reach
    if not upward:
        # A level throw keeps any ceiling not below the pick, so the answer lies above it.
        foot = np.where(held.high >= 0.0, np.maximum(foot, 0.0), foot)
    # Densest next to the foot, where a low ceiling leaves only a sliver.
    share = (1.0 - np.arange(GRID + 1) / GRID) ** 2
    # Written so that the last point is the foot itself.
    below = _nearest(own, held, free[:, None] * share + foot[:, None] * (1.0 - share))
    answer[rows] = _or_above(own, held, free, below) if upward else below
    flight = plane.line(answer)[1]
    return np.where(flight > 0.0, answer, np.nan)


def _or_above(plane: ThrowPlane, bounds: LineBounds, best: Floats, below: Floats) -> Floats:
    """The better of the feasible slopes next below and next above the free optimum."""
    share = np.arange(GRID) / GRID
    above = _nearest(plane, bounds, best[:, None] + (1.0 + best[:, None]) * (share / (1.0 - share)))
    distances: list[Floats] = []
    for slope in (below, above):
        none = np.isnan(slope)
        way, _ = crossing(plane, np.where(none, 1.0 + plane.rise / plane.reach, slope))
        distances.append(np.where(none, np.inf, way))
    return np.where(distances[0] <= distances[1], below, above)


def _nearest(plane: ThrowPlane, bounds: LineBounds, grid: Floats) -> Floats:
    """First point along each row of ``grid`` (N, G) with no negative slack; NaN where there is none."""
    values = _on_grid(plane, bounds, grid)
    kept = values >= 0.0
    last = grid.shape[1] - 1
    found = np.any(kept, axis=1)
    first = np.asarray(np.where(found, np.argmax(kept, axis=1), last + 1), dtype=np.int64)
    index = np.minimum(first, last)
    rows = np.arange(grid.shape[0], dtype=np.int64)
    inside, outside = grid[rows, index], grid[rows, np.maximum(index - 1, 0)]
    hit, peak, before = _hidden_peaks(plane, bounds, grid, values, first)
    inside[hit], outside[hit], found[hit] = peak, before, True
    answer = np.full(rows.size, np.nan)
    answer[found] = _border(take(plane, found), take(bounds, found), inside[found], outside[found])
    return answer


def _on_grid(plane: ThrowPlane, bounds: LineBounds, grid: Floats) -> Floats:
    values = np.empty_like(grid)
    for first in range(0, grid.shape[0], ROWS_AT_ONCE):
        part = slice(first, first + ROWS_AT_ONCE)
        column = (part, None)
        values[part] = slack(take(plane, column), take(bounds, column), grid[part])
    return values


def _hidden_peaks(
    plane: ThrowPlane, bounds: LineBounds, grid: Floats, values: Floats, first: Ints
) -> tuple[Ints, Floats, Floats]:
    """Rows whose slack peaks above zero before ``first``: the row, the peak, the grid point before it."""
    here, after = values[:, :-1], values[:, 1:]
    before = np.concatenate([np.full((values.shape[0], 1), -np.inf), values[:, :-2]], axis=1)
    with np.errstate(invalid="ignore"):
        climb = np.maximum(here - before, here - after)
    hump = (here < 0.0) & (here > before) & (here >= after)
    # A concave peak rises at most one climb above its grid point; two leave room for kinks.
    tall = here + 2.0 * climb >= 0.0
    early = np.arange(values.shape[1] - 1, dtype=np.int64) < first[:, None]
    row, k = np.nonzero(np.asarray(hump & tall & early, dtype=np.bool_))
    near, far = grid[row, np.maximum(k - 1, 0)], grid[row, k + 1]
    if row.size == 0:
        return row, near, near
    own, held = take(plane, row), take(bounds, row)
    peak, top = highest(partial(slack, own, held), near, far, GOLDEN_STEPS)
    lifted = top >= 0.0
    hit, where = np.unique(row[lifted], return_index=True)
    return hit, peak[lifted][where], near[lifted][where]


def _border(plane: ThrowPlane, bounds: LineBounds, inside: Floats, outside: Floats) -> Floats:
    """Zero of the slack between a point that keeps the bounds and one that does not, on the safe side."""
    weight_in, weight_out = slack(plane, bounds, inside), slack(plane, bounds, outside)
    for step in range(BRACKET_STEPS):
        width = np.abs(inside - outside)
        live = width > BRACKET_WIDTH * (1.0 + np.abs(inside))
        if not live.any():
            break
        # Regula falsi in the Illinois form.
        with np.errstate(invalid="ignore", divide="ignore"):
            probe = (outside * weight_in - inside * weight_out) / (weight_in - weight_out)
        within = (probe - inside) * (probe - outside) < 0.0
        # Every third step halves, so that a kink or an infinite slack cannot stall the search.
        probe = np.where(within & (step % 3 < 2), probe, 0.5 * (inside + outside))
        value = slack(plane, bounds, probe)
        good, bad = live & (value >= 0.0), live & (value < 0.0)
        weight_out = np.where(good, 0.5 * weight_out, np.where(bad, value, weight_out))
        weight_in = np.where(bad, 0.5 * weight_in, np.where(good, value, weight_in))
        inside, outside = np.where(good, probe, inside), np.where(bad, probe, outside)
    return inside
