"""The quickest throw whose release point must stay within bounds: a ceiling, a workspace.

Seen from the pick, the release point may lie between ``near`` and ``far`` horizontally and between ``low``
and ``high`` vertically. The release distance grows on either side of the free optimum, so the bounded optimum
is the feasible elevation next to it: the greatest one below, or with a workspace perhaps the least one above.
The feasible set can fall apart into intervals (a flat and a steep way to throw), so it is searched on a grid
from the free optimum outwards, and a peak of the slack between two grid points that might reach zero is
looked at closely.

The bounds translate to bounds on the distance, and P*(u) <= p can be asked without solving for P*: it holds
when the speed that a release at p would need, (L - p) / c, is allowed and is reached within p.
"""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np

from pnt_gym.arrays import Floats, Ints, take
from pnt_gym.planning.motion.roots import highest
from pnt_gym.planning.straight.crossing import TINY, ThrowPlane, crossing, ramp_distance

GRID = 96
GOLDEN_STEPS = 40
BRACKET_STEPS = 100
# A bracket this narrow, relative to the slope plus one, is an answer.
BRACKET_WIDTH = 2e-16
# Rows whose grid is evaluated together; few enough for it to stay in cache.
ROWS_AT_ONCE = 256


class Bounds(NamedTuple):
    """Bounds of the release point seen from the pick, each (N,) [m]; near may be 0, the others infinite."""

    near: Floats
    far: Floats
    low: Floats
    high: Floats


def slack(plane: ThrowPlane, bounds: Bounds, slope: Floats) -> Floats:
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


def bounded_slope(plane: ThrowPlane, bounds: Bounds, best: Floats, *, upward: bool) -> Floats:
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


def _or_above(plane: ThrowPlane, bounds: Bounds, best: Floats, below: Floats) -> Floats:
    """The better of the feasible slopes next below and next above the free optimum."""
    share = np.arange(GRID) / GRID
    above = _nearest(plane, bounds, best[:, None] + (1.0 + best[:, None]) * (share / (1.0 - share)))
    distances: list[Floats] = []
    for slope in (below, above):
        none = np.isnan(slope)
        way, _ = crossing(plane, np.where(none, 1.0 + plane.rise / plane.reach, slope))
        distances.append(np.where(none, np.inf, way))
    return np.where(distances[0] <= distances[1], below, above)


def _nearest(plane: ThrowPlane, bounds: Bounds, grid: Floats) -> Floats:
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


def _on_grid(plane: ThrowPlane, bounds: Bounds, grid: Floats) -> Floats:
    values = np.empty_like(grid)
    for first in range(0, grid.shape[0], ROWS_AT_ONCE):
        part = slice(first, first + ROWS_AT_ONCE)
        column = (part, None)
        values[part] = slack(take(plane, column), take(bounds, column), grid[part])
    return values


def _hidden_peaks(
    plane: ThrowPlane, bounds: Bounds, grid: Floats, values: Floats, first: Ints
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
    own, held = take(plane, row), take(bounds, row)
    peak, top = highest(partial(slack, own, held), near, far, GOLDEN_STEPS)
    lifted = top >= 0.0
    hit, where = np.unique(row[lifted], return_index=True)
    return hit, peak[lifted][where], near[lifted][where]


def _border(plane: ThrowPlane, bounds: Bounds, inside: Floats, outside: Floats) -> Floats:
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
