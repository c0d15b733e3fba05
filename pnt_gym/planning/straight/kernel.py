"""Throws along straight lines, N at a time. Compiled; see `pnt_gym.compiled`.

`crossing` and `bounds` hold the formulas of one throw; a single throw is a batch of one row.
"""

from __future__ import annotations

import math

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.compiled import compile_for, kernel_part
from pnt_gym.constants import GRAVITY
from pnt_gym.planning.motion.strokes import brake_distance
from pnt_gym.planning.straight.bounds import LANES, Box, slope_below_roof, slope_in_bounds
from pnt_gym.planning.straight.crossing import (
    ACCELERATION,
    CEILING,
    FAR,
    HIGH,
    JERK,
    LOW,
    NEAR,
    TO_X,
    TO_Y,
    Line,
    X,
    Y,
    Z,
    best_slope,
    crossing,
    flight_time,
    lay_out,
)
from pnt_gym.planning.straight.plan import CONTACT, MIN_REACH, Reason

NO_REACH, TOO_HIGH, OUTSIDE, TOO_FLAT = map(int, (Reason.NO_REACH, Reason.CEILING, Reason.WORKSPACE, Reason.ELEVATION))


@kernel_part
def _choose_slope(throws: Floats, row: int, has_workspace: bool, slacks: Floats) -> tuple[float, bool, int]:
    """Slope, whether a bound moved the line, and reason of one row, as `choose_slopes`; ``slacks`` is overwritten."""
    throw, _, _ = lay_out(throws, row)
    if throw.reach <= MIN_REACH:
        return math.nan, False, NO_REACH
    best = best_slope(throw)
    roof = throws[CEILING, row] - throws[Z, row]
    box = Box(throws[NEAR, row], throws[FAR, row], throws[LOW, row], min(throws[HIGH, row], roof))
    if not has_workspace and box.high >= 0.0:
        slope = slope_below_roof(throw, box.high, best, slacks)
    else:
        slope = slope_in_bounds(throw, box, best, has_workspace)
    if not math.isnan(slope):
        return slope, slope != best, 0
    # The reason is the ceiling where the ceiling alone rules the throw out.
    if has_workspace:
        below_roof = slope_in_bounds(throw, Box(0.0, math.inf, -math.inf, roof), best, not has_workspace)
        return slope, False, TOO_HIGH if math.isnan(below_roof) else OUTSIDE
    return slope, False, TOO_HIGH


@compile_for("void(f8[:, ::1], b1, f8[::1], b1[::1], i8[::1])")
def choose_slopes(throws: Floats, has_workspace: bool, slopes: Floats, moved: Bools, reasons: Ints) -> None:
    """Find the quickest lines of N throws ``throws`` (15, N), within a workspace if ``has_workspace``.

    Written are ``slopes`` (N,), the tangents of the lines' elevations, NaN where there is no throw; ``moved`` (N,),
    whether a bound moved the line; and ``reasons`` (N,), the `Reason` where there is no throw.
    """
    slacks = np.empty(LANES)
    for row in range(throws.shape[1]):
        slopes[row], moved[row], reasons[row] = _choose_slope(throws, row, has_workspace, slacks)


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
        throw, cosine, sine = lay_out(throws, row)
        slope, flight = slopes[row], flight_time(throw, slopes[row])
        vectors[:, row], numbers[:, row], active[:, row] = math.nan, math.nan, False
        if math.isnan(slope):
            continue
        if throw.reach <= MIN_REACH or flight <= 0.0:
            reasons[row] = TOO_FLAT if throw.reach > MIN_REACH else NO_REACH
            continue
        distance, speed = crossing(throw, slope)
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
def is_inside(x: float, y: float, z: float, workspace: Floats) -> bool:
    """Whether a point lies in an elliptic workspace, given as its two semi-axes and its two heights [m]."""
    east, north = x / workspace[0], y / workspace[1]
    return (1.0 - math.sqrt(east * east + north * north)) >= 0.0 and workspace[2] <= z <= workspace[3]


@kernel_part
def _stops_inside(throws: Floats, row: int, line: Line, window: float, brake: float, workspace: Floats) -> bool:
    """Whether the hand of a throw along a line stops inside the workspace, after the window at constant velocity."""
    way = line.distance + (window * line.speed + brake_distance(line.speed, brake, throws[JERK, row]))
    return is_inside(
        throws[X, row] + line.x * way, throws[Y, row] + line.y * way, throws[Z, row] + line.z * way, workspace
    )


@kernel_part
def _line_at(throws: Floats, row: int, slope: float) -> Line:
    """Line of a throw at a slope; its distance is NaN where there is no throw."""
    throw, cosine, sine = lay_out(throws, row)
    if throw.reach <= MIN_REACH or not flight_time(throw, slope) > 0.0:
        return Line(math.nan, math.nan, math.nan, math.nan, math.nan)
    distance, speed = crossing(throw, slope)
    level = 1.0 / math.sqrt(1.0 + slope * slope)
    return Line(distance, speed, level * cosine, level * sine, level * slope)


@kernel_part
def _has_reserve(
    throws: Floats, row: int, slope: float, shift: tuple[float, float], window: float, brake: float, workspace: Floats
) -> bool:
    """Whether a throw stops inside the workspace also with its target moved by a shift, back and forth."""
    x, y = throws[TO_X, row], throws[TO_Y, row]
    is_good = True
    for side in range(2):
        sign = 2.0 * side - 1.0
        throws[TO_X, row], throws[TO_Y, row] = x + sign * shift[0], y + sign * shift[1]
        line = _line_at(throws, row, slope)
        is_good = is_good and line.distance >= 0.0 and _stops_inside(throws, row, line, window, brake, workspace)
    throws[TO_X, row], throws[TO_Y, row] = x, y
    return is_good


@compile_for("void(f8[:, ::1], f8[:, ::1], f8[:, ::1], f8, f8[::1], b1[::1])")
def keep_stops_inside(
    throws: Floats, plans: Floats, shifts: Floats, window: float, workspace: Floats, good: Bools
) -> None:
    """Write which of N planned throws stop inside a workspace, also with their targets moved forth and back.

    The workspace is convex and the path straight, so the pick and the stop are enough.

    Args:
        throws: the throws (15, N).
        plans: tangent of the elevation, distance, speed, direction and greatest acceleration of the braking (7, N).
        shifts: displacements of the targets along x and y (2, N) [m]; (2, 0) for the targets alone.
        window: time between the release and the braking [s].
        workspace: two semi-axes, least and greatest height (4,) [m].
        good: which throws have a plan; overwritten by the result.
    """
    for row in range(throws.shape[1]):
        if not (good[row] and is_inside(throws[X, row], throws[Y, row], throws[Z, row], workspace)):
            good[row] = False
            continue
        slope, brake = plans[0, row], plans[6, row]
        line = Line(plans[1, row], plans[2, row], plans[3, row], plans[4, row], plans[5, row])
        good[row] = _stops_inside(throws, row, line, window, brake, workspace)
        if shifts.shape[1] > 0:
            shift = shifts[0, row], shifts[1, row]
            good[row] &= _has_reserve(throws, row, slope, shift, window, brake, workspace)


@kernel_part
def _is_accepted(
    throws: Floats, row: int, slope: float, origin: Floats, rules: tuple[float, float, float], workspace: Floats
) -> bool:
    """Whether a throw at a slope stops inside the workspace, also to moved targets; see `choose_targets`."""
    window, gravity_share, reserve = rules
    line = _line_at(throws, row, slope)
    if not (line.distance >= 0.0 and is_inside(throws[X, row], throws[Y, row], throws[Z, row], workspace)):
        return False
    brake = throws[ACCELERATION, row]
    if gravity_share > 0.0:
        brake = min(brake, gravity_share * GRAVITY / max(math.sin(math.atan(slope)), 1e-3))
    if not _stops_inside(throws, row, line, window, brake, workspace):
        return False
    if reserve == 0.0:
        return True
    x, y = throws[TO_X, row] - origin[0], throws[TO_Y, row] - origin[1]
    distance = math.sqrt(x * x + y * y)
    shift = reserve * (x / distance), reserve * (y / distance)
    return _has_reserve(throws, row, slope, shift, window, brake, workspace)


@compile_for(
    "void(f8[:, ::1], f8[:, :, ::1], f8[:, :], UniTuple(f8, 3), f8[::1], i8[::1], f8[::1], b1[::1], i8[::1], b1[::1])"
)
def choose_targets(
    throws: Floats,
    targets: Floats,
    origins: Floats,
    rules: tuple[float, float, float],
    workspace: Floats,
    attempts: Ints,
    slopes: Floats,
    moved: Bools,
    reasons: Ints,
    good: Bools,
) -> None:
    """Find for each of N objects the first of T targets with an accepted throw; the last target where there is none.

    Args:
        throws: the throws (15, N); their targets are overwritten by the chosen targets.
        targets: targets in the order in which to try them (N, T, 3) [m].
        origins: picks from which targets are moved along the throw (N, 3) [m].
        rules: time between release and braking [s]; share of gravity with which the hand may fall while braking, 0 for
            full braking; displacement of the targets, forth and back, with which a throw has to be possible [m].
        workspace: two semi-axes, least and greatest height (4,) [m].
        attempts: written, indices of the chosen targets (N,).
        slopes: written, as `choose_slopes`, and so are `moved` and `reasons`.
        moved: see `slopes`.
        reasons: see `slopes`.
        good: which objects may be thrown; overwritten by which throws are accepted (N,).
    """
    slacks, count = np.empty(LANES), targets.shape[1]
    for row in range(len(targets)):
        may_throw, good[row] = good[row], False
        for attempt in range(0 if may_throw else count - 1, count):
            for k in range(3):
                throws[TO_X + k, row] = targets[row, attempt, k]
            slopes[row], moved[row], reasons[row] = _choose_slope(throws, row, False, slacks)
            attempts[row] = attempt
            if may_throw and _is_accepted(throws, row, slopes[row], origins[row], rules, workspace):
                good[row] = True
                break
