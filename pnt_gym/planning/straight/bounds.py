"""The quickest line of a throw whose release point is bounded. Compiled; see `pnt_gym.compiled`.

Seen from the pick, the release point may lie between ``near`` and ``far`` horizontally and between ``low``
and ``high`` vertically: a ceiling, a workspace. The release distance grows on either side of the free optimum, so the
bounded optimum is the feasible elevation next to the free optimum: the greatest feasible elevation below, or with a
workspace perhaps the least feasible elevation above. The feasible set can consist of several intervals (a flat and a
steep way to throw), so the search runs on a grid from the free optimum outwards, and golden section examines each peak
of the slack between two grid points that might reach zero. Bounds translate to bounds on the distance, and P*(u) <= p
can be decided without solving for P*: it holds when the speed that a release at p needs, (L - p) / c, is allowed and is
reached within p.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from pnt_gym.arrays import Floats
from pnt_gym.compiled import kernel_part
from pnt_gym.planning.motion.strokes import ramp_distance
from pnt_gym.planning.straight.crossing import TINY, PlaneThrow, crossing, flight_time

GRID = 96
# Slacks of a ceiling that are computed together, in vector instructions.
LANES = 16
GOLDEN = 0.6180339887498949
GOLDEN_STEPS = 40
BRACKET_STEPS = 100
# Width of a bracket, relative to the slope plus one, at which the search ends.
BRACKET_WIDTH = 2e-16


class Box(NamedTuple):
    """Bounds of the release point relative to the pick [m]; near may be 0, far, low and high may be infinite."""

    near: float
    far: float
    low: float
    high: float


@kernel_part
def _slack(throw: PlaneThrow, box: Box, slope: float) -> float:
    """Slack of the bounds [m], continuous in ``slope`` and negative exactly where a bound is broken."""
    secant = math.sqrt(1.0 + slope * slope)
    length, flight = throw.reach * secant, flight_time(throw, slope)
    if slope == 0.0:
        roof, floor = math.inf if box.low <= 0.0 <= box.high else -math.inf, -math.inf
    else:
        per_height = secant / slope
        roof, floor = box.high * per_height, box.low * per_height
        if slope < 0.0:
            roof, floor = floor, roof
    longest, shortest = min(box.far * secant, roof), max(box.near * secant, floor)
    # The crossing never lies beyond the full line, so a bound beyond the line's end cannot bind.
    margin = math.inf if longest >= length else _room(throw, length, flight, longest)
    return margin if shortest <= 0.0 else min(margin, -_room(throw, length, flight, shortest))


@kernel_part
def _room(throw: PlaneThrow, length: float, flight: float, distance: float) -> float:
    """Slack [m] of the condition P <= ``distance``: negative exactly where the crossing lies beyond ``distance``.

    No branches, for vector instructions.
    """
    speed = (length - distance) / (flight if flight > TINY else TINY)
    speed = speed if speed > 0.0 else 0.0
    speed = speed if speed < throw.velocity else throw.velocity
    room = distance - ramp_distance(speed, throw.acceleration, throw.jerk)
    reserve = flight * throw.velocity - (length - distance)
    return room if room < reserve else reserve


@kernel_part
def slope_in_bounds(throw: PlaneThrow, box: Box, best: float, upward: bool) -> float:
    """Tangent of the elevation of the quickest throw within bounds; NaN where there is no throw.

    If ``upward``, elevations above the free optimum are searched too, which bounds other than a ceiling need.
    """
    if _slack(throw, box, best) >= 0.0:
        return best
    foot = throw.rise / throw.reach
    if not upward and box.high >= 0.0:
        # A level throw keeps any ceiling that is not below the pick, so the optimum is not below level.
        foot = max(foot, 0.0)
    answer, way = math.nan, math.inf
    for above in range(1 + upward):
        slope = _nearest_slope(throw, box, best, foot, above)
        if flight_time(throw, slope) > 0.0:
            distance, _ = crossing(throw, slope)
            if distance < way:
                answer, way = slope, distance
    return answer


@kernel_part
def _grid_point(best: float, foot: float, above: int, k: int) -> float:
    """Slope k of the grid from the free optimum up, or from the free optimum down to the foot.

    The downward grid is densest next to the foot, where a low ceiling leaves only a narrow feasible interval.
    """
    share = k / GRID
    if above:
        return best + (1.0 + best) * (share / (1.0 - share))
    share = (1.0 - share) * (1.0 - share)
    return best * share + foot * (1.0 - share)


@kernel_part
def _roof_slacks(throw: PlaneThrow, high: float, best: float, foot: float, first: int, slacks: Floats) -> None:
    """Write `_slack` of a ceiling alone, ``high`` above the pick, at points of the downward grid from ``first`` on.

    The slopes are positive. Without branches, the loop becomes vector instructions.
    """
    for i in range(len(slacks)):
        share = 1.0 - (first + i) / GRID
        share *= share
        slope = best * share + foot * (1.0 - share)
        secant = math.sqrt(1.0 + slope * slope)
        length, distance = throw.reach * secant, high * (secant / slope)
        room = _room(throw, length, flight_time(throw, slope), distance)
        slacks[i] = math.inf if distance >= length else room


@kernel_part
def slope_below_roof(throw: PlaneThrow, high: float, best: float, slacks: Floats) -> float:
    """`slope_in_bounds` for a ceiling alone, ``high`` above the pick and not below the pick.

    The grid of `_nearest_slope` is evaluated `LANES` points at a time, in ``slacks``.
    """
    box = Box(0.0, math.inf, -math.inf, high)
    older, old, last = -math.inf, _slack(throw, box, best), best
    if old >= 0.0:
        return best
    foot, before = max(throw.rise / throw.reach, 0.0), best
    for k in range(1, GRID + 1):
        lane = (k - 1) % LANES
        if lane == 0:
            _roof_slacks(throw, high, best, foot, k, slacks)
        slope = _grid_point(best, foot, 0, k)
        value = slacks[lane] if k < GRID else _slack(throw, box, slope)
        keeps = value >= 0.0
        # A peak between the last three probes may reach above 0, although no probe does.
        if older < old < 0.0 and value <= old and old + 2.0 * max(old - older, old - value) >= 0.0:
            peak, height = _greatest_slack(throw, box, before, slope)
            if height >= 0.0:
                slope, value, last, old, keeps = peak, height, before, (older if k > 1 else old), True
        if keeps:
            slope = _border(throw, box, slope, value, last, old)
            return slope if flight_time(throw, slope) > 0.0 and crossing(throw, slope)[0] < math.inf else math.nan
        older, old, before, last = old, value, last, slope
    return math.nan


@kernel_part
def _nearest_slope(throw: PlaneThrow, box: Box, best: float, foot: float, above: int) -> float:
    """Slope without negative slack that is nearest to the free optimum, whose slack is negative; NaN if none exists."""
    older, old, last = -math.inf, _slack(throw, box, best), best
    before = best
    for k in range(1, GRID + 1 - above):
        slope = _grid_point(best, foot, above, k)
        value = _slack(throw, box, slope)
        # A concave peak rises at most one climb above its grid point; two leave room for kinks.
        if older < old < 0.0 and value <= old and old + 2.0 * max(old - older, old - value) >= 0.0:
            peak, height = _greatest_slack(throw, box, before, slope)
            if height >= 0.0:
                return _border(throw, box, peak, height, before, older if k > 1 else old)
        if value >= 0.0:
            return _border(throw, box, slope, value, last, old)
        older, old, before, last = old, value, last, slope
    return math.nan


@kernel_part
def _greatest_slack(throw: PlaneThrow, box: Box, low: float, high: float) -> tuple[float, float]:
    """Slope of the greatest slack between two slopes, and the slack at this slope, by golden section."""
    left, right = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    at_left, at_right = _slack(throw, box, left), _slack(throw, box, right)
    for _ in range(GOLDEN_STEPS):
        if at_left >= at_right:
            high, right, at_right = right, left, at_left
            left = high - GOLDEN * (high - low)
            at_left = _slack(throw, box, left)
        else:
            low, left, at_left = left, right, at_right
            right = low + GOLDEN * (high - low)
            at_right = _slack(throw, box, right)
    return (left, at_left) if at_left >= at_right else (right, at_right)


@kernel_part
def _border(throw: PlaneThrow, box: Box, a: float, at_a: float, b: float, at_b: float) -> float:
    """Zero of the slack between a slope ``a`` that keeps the bounds and a slope ``b`` that does not, on the safe side.

    Chandrupatla's method halves the bracket wherever the slack is not close to a straight line, so a kink or an
    infinite slack cannot stall the search.
    """
    share = 0.5
    for _ in range(BRACKET_STEPS):
        probe = a + share * (b - a)
        value = _slack(throw, box, probe)
        # The point that leaves the bracket still gives the curvature of the slack.
        c, at_c = (b, at_b) if (value >= 0.0) != (at_a >= 0.0) else (a, at_a)
        b, at_b = (a, at_a) if (value >= 0.0) != (at_a >= 0.0) else (b, at_b)
        a, at_a = probe, value
        width = BRACKET_WIDTH * (1.0 + abs(a))
        if abs(b - a) <= width:
            break
        # A least step, so that the next bracket encloses the zero.
        least = 0.5 * width / abs(b - a)
        share = min(max(_share(a, at_a, b, at_b, c, at_c), least), 1.0 - least)
    return a if at_a >= 0.0 else b


@kernel_part
def _share(a: float, at_a: float, b: float, at_b: float, c: float, at_c: float) -> float:
    """Next probe as a share of the way from ``a`` to ``b``: by inverse quadratic interpolation, or a half."""
    # Interpolation where the parabola is monotone between a and b (Chandrupatla 1997).
    place, level = (a - b) / (c - b), (at_a - at_b) / (at_c - at_b)
    if level * level < place and (1.0 - level) * (1.0 - level) < 1.0 - place:
        straight = at_a / (at_b - at_a) * at_c / (at_b - at_c)
        return straight + (c - a) / (b - a) * at_a / (at_c - at_a) * at_b / (at_c - at_b)
    return 0.5
