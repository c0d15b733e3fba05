"""Release point and speed of throws along a line, and the quickest line, by closed forms and root finding.

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

**Bounds.** Seen from the pick, the release point may lie between ``near`` and ``far`` horizontally and between ``low``
and ``high`` vertically: a ceiling, a workspace. The release distance grows on either side of the free optimum, so the
bounded optimum is the feasible elevation next to the free optimum: the greatest feasible elevation below, or with a
workspace perhaps the least feasible elevation above. The feasible set can consist of several intervals (a flat and a
steep way to throw), so the search runs on a grid from the free optimum outwards, and golden section examines each peak
of the slack between two grid points that might reach zero. Bounds translate to bounds on the distance, and P*(u) <= p
can be decided without solving for P*: it holds when the speed that a release at p needs, (L - p) / c, is allowed and is
reached within p.

The functions are compiled; one throw and N throws run through the same machine code, row by row.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.compiled import compile_for, kernel_part
from pnt_gym.constants import GRAVITY
from pnt_gym.planning.straight.plan import CONTACT, MIN_REACH, Reason

# Rows of an array of throws (15, N), in SI units: pick, target, limits, tolerance, ceiling, and the workspace relative
# to the pick.
X, Y, Z, TO_X, TO_Y, TO_Z, VELOCITY, ACCELERATION, JERK, TOLERANCE, CEILING, NEAR, FAR, LOW, HIGH = range(15)
NO_REACH, TOO_HIGH, OUTSIDE, TOO_FLAT = map(int, (Reason.NO_REACH, Reason.CEILING, Reason.WORKSPACE, Reason.ELEVATION))

# Newton steps for the cubic of the jerk-only crossing: its start is within a factor sqrt(2) of the root, from
# where five steps reach rounding.
CROSSING_STEPS = 7
# Replaces a flight time of zero, at the foot of the elevation range.
TINY = 1e-300
CUBIC_STEPS = 9
NEWTON_STEPS = 80
# Newton's error squares with every step: after a step this small the next step is below rounding.
SLOPE_PRECISION = 1e-9
GRID = 96
# Slacks of a ceiling that are computed together, in vector instructions.
LANES = 16
GOLDEN = 0.6180339887498949
GOLDEN_STEPS = 40
BRACKET_STEPS = 100
# Width of a bracket, relative to the slope plus one, at which the search ends.
BRACKET_WIDTH = 2e-16


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


class Box(NamedTuple):
    """Bounds of the release point relative to the pick [m]; near may be 0, far, low and high may be infinite."""

    near: float
    far: float
    low: float
    high: float


@kernel_part
def _lay_out(throws: Floats, row: int) -> tuple[PlaneThrow, float, float]:
    """Throw of a row, and cosine and sine of its azimuth; reach is shortened by the tolerance and may be negative."""
    x, y = throws[TO_X, row] - throws[X, row], throws[TO_Y, row] - throws[Y, row]
    full = math.sqrt(x * x + y * y)
    cosine, sine = (x / full, y / full) if full > 0.0 else (1.0, 0.0)
    reach = full - throws[TOLERANCE, row] / max(abs(cosine), abs(sine))
    rise = throws[TO_Z, row] - throws[Z, row]
    return PlaneThrow(reach, rise, throws[VELOCITY, row], throws[ACCELERATION, row], throws[JERK, row]), cosine, sine


@kernel_part
def _ramp_distance(speed: float, acceleration: float, jerk: float) -> float:
    """P_S(V) [m], the shortest way from rest to ``speed`` with no acceleration at its end: the inverse of V_S."""
    if jerk * speed <= acceleration * acceleration:
        return speed * math.sqrt(speed / jerk)
    return 0.5 * speed * (speed / acceleration + acceleration / jerk)


@kernel_part
def _flight_time(throw: PlaneThrow, slope: float) -> float:
    """Time of flight c [s] at the tangent ``slope`` of the elevation."""
    return math.sqrt(2.0 * max(throw.reach * slope - throw.rise, 0.0) / GRAVITY)


@kernel_part
def _crossing(throw: PlaneThrow, slope: float) -> tuple[float, float]:
    """Release distance P [m] and speed V [m/s] at the tangent ``slope`` of the elevation."""
    velocity, acceleration, jerk = throw.velocity, throw.acceleration, throw.jerk
    length, flight = throw.reach * math.sqrt(1.0 + slope * slope), _flight_time(throw, slope)
    cruising = length - velocity * flight
    if _ramp_distance(velocity, acceleration, jerk) <= cruising:
        return cruising, velocity
    knee = min(acceleration * acceleration / jerk, velocity)
    if knee * math.sqrt(knee / jerk) + knee * flight <= length:
        speed = _plateau_speed(length, flight, acceleration, jerk)
    else:
        speed = _jerk_speed(length, flight, jerk)
    speed = min(speed, velocity)
    return _ramp_distance(speed, acceleration, jerk), speed


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
def _best_slope(throw: PlaneThrow) -> float:
    """Tangent of the elevation of the quickest throw without bounds, by Newton's method inside a shrinking bracket."""
    cap = _saturation_slope(throw)
    if _optimality(throw, cap)[0] <= 0.0:
        return cap
    low = max(throw.rise / throw.reach, 0.0)
    u = high = min(cap, _steepest_slope(throw))
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
def _steepest_slope(throw: PlaneThrow) -> float:
    """Tangent of the elevation of least speed, (Z + sqrt(X^2 + Z^2)) / X, without cancellation for Z < 0."""
    reach, rise = throw.reach, throw.rise
    slant = math.sqrt(reach * reach + rise * rise)
    return reach / (slant - rise) if rise < 0.0 else (rise + slant) / reach


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


@kernel_part
def _slack(throw: PlaneThrow, box: Box, slope: float) -> float:
    """Slack of the bounds [m], continuous in ``slope`` and negative exactly where a bound is broken."""
    secant = math.sqrt(1.0 + slope * slope)
    length, flight = throw.reach * secant, _flight_time(throw, slope)
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
    """Slack [m] of the condition P <= ``distance``: negative exactly where the crossing lies beyond ``distance``."""
    speed = max((length - distance) / max(flight, TINY), 0.0)
    way = _ramp_distance(min(speed, throw.velocity), throw.acceleration, throw.jerk)
    return min(distance - way, flight * throw.velocity - (length - distance))


@kernel_part
def _slope_in_bounds(throw: PlaneThrow, box: Box, best: float, upward: bool) -> float:
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
        if _flight_time(throw, slope) > 0.0:
            distance, _ = _crossing(throw, slope)
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
def _roof_slack(throw: PlaneThrow, high: float, slope: float) -> float:
    """`_slack` of a ceiling alone, ``high`` above the pick, at a positive slope, without branches and calls."""
    reach, rise, velocity, acceleration, jerk = throw
    secant, drop = math.sqrt(1.0 + slope * slope), reach * slope - rise
    length, flight = reach * secant, math.sqrt(2.0 * (drop if drop > 0.0 else 0.0) / GRAVITY)
    distance = high * (secant / slope)
    speed = (length - distance) / (flight if flight > TINY else TINY)
    speed = speed if speed > 0.0 else 0.0
    speed = speed if speed < velocity else velocity
    short, long = speed * math.sqrt(speed / jerk), 0.5 * speed * (speed / acceleration + acceleration / jerk)
    room = distance - (short if jerk * speed <= acceleration * acceleration else long)
    reserve = flight * velocity - (length - distance)
    return math.inf if distance >= length else (room if room < reserve else reserve)


@kernel_part
def _roof_slacks(throw: PlaneThrow, high: float, best: float, foot: float, first: int, slacks: Floats) -> None:
    """Write `_roof_slack` at points of the downward grid from ``first`` on; the loop becomes vector instructions."""
    for i in range(len(slacks)):
        share = 1.0 - (first + i) / GRID
        share *= share
        slacks[i] = _roof_slack(throw, high, best * share + foot * (1.0 - share))


@kernel_part
def _slope_below_roof(throw: PlaneThrow, high: float, best: float, slacks: Floats) -> float:
    """`_slope_in_bounds` for a ceiling alone, ``high`` above the pick and not below the pick.

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
        if older < old < 0.0 and value <= old and old + 2.0 * max(old - older, old - value) >= 0.0:
            peak, height = _greatest_slack(throw, box, before, slope)
            if height >= 0.0:
                slope, value, last, old, keeps = peak, height, before, (older if k > 1 else old), True
        if keeps:
            slope = _border_slope(throw, box, slope, value, last, old)
            return slope if _flight_time(throw, slope) > 0.0 and _crossing(throw, slope)[0] < math.inf else math.nan
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
                return _border_slope(throw, box, peak, height, before, older if k > 1 else old)
        if value >= 0.0:
            return _border_slope(throw, box, slope, value, last, old)
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
def _border_slope(throw: PlaneThrow, box: Box, a: float, at_a: float, b: float, at_b: float) -> float:
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
    place, level = (a - b) / (c - b), (at_a - at_b) / (at_c - at_b)
    if level * level < place and (1.0 - level) * (1.0 - level) < 1.0 - place:
        straight = at_a / (at_b - at_a) * at_c / (at_b - at_c)
        return straight + (c - a) / (b - a) * at_a / (at_c - at_a) * at_b / (at_c - at_b)
    return 0.5


@compile_for("void(f8[:, ::1], b1, f8[::1], b1[::1], i8[::1])")
def choose_slopes(throws: Floats, has_workspace: bool, slopes: Floats, moved: Bools, reasons: Ints) -> None:
    """Find the quickest lines of N throws ``throws`` (15, N), within a workspace if ``has_workspace``.

    Written are ``slopes`` (N,), the tangents of the lines' elevations, NaN where there is no throw; ``moved`` (N,),
    whether a bound moved the line; and ``reasons`` (N,), the `Reason` where there is no throw.
    """
    slacks = np.empty(LANES)
    for row in range(throws.shape[1]):
        throw, _, _ = _lay_out(throws, row)
        slopes[row], moved[row], reasons[row] = math.nan, False, NO_REACH
        if throw.reach <= MIN_REACH:
            continue
        best = _best_slope(throw)
        roof = throws[CEILING, row] - throws[Z, row]
        box = Box(throws[NEAR, row], throws[FAR, row], throws[LOW, row], min(throws[HIGH, row], roof))
        if not has_workspace and box.high >= 0.0:
            slope = _slope_below_roof(throw, box.high, best, slacks)
        else:
            slope = _slope_in_bounds(throw, box, best, has_workspace)
        slopes[row], moved[row], reasons[row] = slope, slope != best, 0
        if math.isnan(slope):
            # The reason is the ceiling where the ceiling alone rules the throw out.
            if has_workspace:
                slope = _slope_in_bounds(throw, Box(0.0, math.inf, -math.inf, roof), best, not has_workspace)
            moved[row], reasons[row] = False, TOO_HIGH if math.isnan(slope) else OUTSIDE


@compile_for("void(f8[:, ::1], b1, b1, f8[::1], b1[::1], i8[::1], f8[:, :, ::1], f8[:, ::1], b1[:, ::1])")
def release_rows(
    throws: Floats,
    has_workspace: bool,
    needs_angles: bool,
    slopes: Floats,
    moved: Bools,
    reasons: Ints,
    vectors: Floats,
    numbers: Floats,
    active: Bools,
) -> None:
    """Compute the releases of N throws along lines of given slopes, for instance of `choose_slopes`; NaN gives NaN.

    Written are ``reasons`` (N,), the `Reason` where a line leads to no throw; ``vectors`` (3, N, 3), position, velocity
    and direction; ``numbers`` (7, N), speed, acceleration, angle, azimuth, distance, time and time of flight; and
    ``active`` (2, N), whether the ceiling and whether the workspace moved the release. Angle and azimuth stay NaN
    unless ``needs_angles``.
    """
    for row in range(throws.shape[1]):
        throw, cosine, sine = _lay_out(throws, row)
        slope, flight = slopes[row], _flight_time(throw, slopes[row])
        vectors[:, row], numbers[:, row], active[:, row] = math.nan, math.nan, False
        if math.isnan(slope):
            continue
        if throw.reach <= MIN_REACH or flight <= 0.0:
            reasons[row] = TOO_FLAT if throw.reach > MIN_REACH else NO_REACH
            continue
        distance, speed = _crossing(throw, slope)
        peak = min(math.sqrt(throw.jerk * speed), throw.acceleration)
        # Half of Eq. 4 over the stroke 2 P_r, which is Eq. 12.
        time = distance / speed + 0.5 * (speed / peak + peak / throw.jerk)
        numbers[0, row], numbers[1, row] = speed, peak
        numbers[4, row], numbers[5, row], numbers[6, row] = distance, time, flight
        if needs_angles:
            numbers[2, row], numbers[3, row] = math.atan(slope), math.atan2(sine, cosine)
        level = 1.0 / math.sqrt(1.0 + slope * slope)
        direction = (level * cosine, level * sine, level * slope)
        for k in range(3):
            vectors[0, row, k] = throws[X + k, row] + distance * direction[k]
            vectors[1, row, k] = speed * direction[k]
            vectors[2, row, k] = direction[k]
        roofed = moved[row] and (not has_workspace or vectors[0, row, 2] >= throws[CEILING, row] - CONTACT)
        active[0, row], active[1, row] = roofed, moved[row] and not roofed


@kernel_part
def _is_inside(x: float, y: float, z: float, workspace: Floats) -> bool:
    """Whether a point lies in an elliptic workspace, given as its two semi-axes and its two heights [m]."""
    east, north = x / workspace[0], y / workspace[1]
    return (1.0 - math.sqrt(east * east + north * north)) >= 0.0 and workspace[2] <= z <= workspace[3]


@kernel_part
def _brake_distance(speed: float, acceleration: float, jerk: float) -> float:
    """Way of the quickest stop [m], as `scurve.brake_distance`."""
    peak = min(math.sqrt(jerk * speed), acceleration)
    ramp = peak / jerk
    plateau = max(speed / peak - ramp, 0.0) if peak > 0.0 else 0.0
    return 0.5 * speed * (2.0 * ramp + plateau)


@kernel_part
def _stops_inside(throws: Floats, row: int, line: Line, window: float, brake: float, workspace: Floats) -> bool:
    """Whether the hand of a throw along a line stops inside the workspace, after the window at constant velocity."""
    way = line.distance + (window * line.speed + _brake_distance(line.speed, brake, throws[JERK, row]))
    return _is_inside(
        throws[X, row] + line.x * way, throws[Y, row] + line.y * way, throws[Z, row] + line.z * way, workspace
    )


@compile_for("void(f8[:, ::1], f8[:, ::1], f8[:, ::1], f8, f8[::1], b1[::1])")
def keep_stops_inside(
    throws: Floats, plans: Floats, shifts: Floats, window: float, workspace: Floats, good: Bools
) -> None:
    """Write which of N planned throws stop inside a workspace, also with their targets moved forth and back.

    The workspace is convex and the path straight, so the pick and the stop are enough.

    Args:
        throws: the throws (15, N), whose targets are moved.
        plans: tangent of the elevation, distance, speed, direction and greatest acceleration of the braking (7, N).
        shifts: displacements of the targets along x and y (2, N) [m]; (2, 0) for the targets alone.
        window: time between the release and the braking [s].
        workspace: two semi-axes, least and greatest height (4,) [m].
        good: which throws have a plan; overwritten by the result.
    """
    for row in range(throws.shape[1]):
        if not (good[row] and _is_inside(throws[X, row], throws[Y, row], throws[Z, row], workspace)):
            good[row] = False
            continue
        slope, brake = plans[0, row], plans[6, row]
        line = Line(plans[1, row], plans[2, row], plans[3, row], plans[4, row], plans[5, row])
        good[row] = _stops_inside(throws, row, line, window, brake, workspace)
        x, y = throws[TO_X, row], throws[TO_Y, row]
        level = 1.0 / math.sqrt(1.0 + slope * slope)
        for side in range(2 if shifts.shape[1] > 0 else 0):
            sign = 2.0 * side - 1.0
            throws[TO_X, row], throws[TO_Y, row] = x + sign * shifts[0, row], y + sign * shifts[1, row]
            throw, cosine, sine = _lay_out(throws, row)
            if throw.reach <= MIN_REACH or not _flight_time(throw, slope) > 0.0:
                good[row] = False
                continue
            distance, speed = _crossing(throw, slope)
            line = Line(distance, speed, level * cosine, level * sine, level * slope)
            good[row] &= _stops_inside(throws, row, line, window, brake, workspace)
