"""Throws along straight lines, N at a time. Compiled; see `pnt_gym.compiled`.

`crossing` and `bounds` hold the formulas of one throw; a single throw is a batch of one row.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.compiled import kernel, kernel_part
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
from pnt_gym.rows import Bools1, Bools2, Floats1, Floats2, Floats3, Ints1

NO_REACH, TOO_HIGH, OUTSIDE, TOO_FLAT = map(int, (Reason.NO_REACH, Reason.CEILING, Reason.WORKSPACE, Reason.ELEVATION))


class ThrowLines(NamedTuple):
    """ThrowLines of N throws."""

    slope: Floats1
    """Tangents of the elevations (N,), NaN where there is no throw."""
    moved: Bools1
    """Whether a bound moved the line (N,)."""
    reason: Ints1
    """`Reason` where there is no throw (N,)."""


class Releases(NamedTuple):
    """Releases of N throws along their lines."""

    vectors: Floats3
    """Position, velocity and direction (3, N, 3)."""
    numbers: Floats2
    """Speed, acceleration, angle, azimuth, distance, time and time of flight (7, N)."""
    active: Bools2
    """Whether the ceiling and whether the workspace moved the release (2, N)."""


class StopRules(NamedTuple):
    """Rules by which a hand stops after a throw."""

    window: float
    """Time between release and braking [s]."""
    gravity_share: float
    """Share of gravity with which the hand may fall while braking; 0 for full braking."""
    reserve: float
    """Displacement of the targets, forth and back, with which a throw has to be possible [m]."""


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


@kernel
def choose_slopes(throws: Floats2, has_workspace: bool, lines: ThrowLines) -> None:
    """Write the quickest lines of N throws ``throws`` (15, N), within a workspace if ``has_workspace``."""
    slacks = np.empty(LANES)
    for row in range(throws.shape[1]):
        slope, moved, reason = _choose_slope(throws, row, has_workspace, slacks)
        lines.slope[row], lines.moved[row], lines.reason[row] = slope, moved, reason


@kernel
def release_rows(
    throws: Floats2, has_workspace: bool, needs_angles: bool, lines: ThrowLines, releases: Releases
) -> None:
    """Write the releases of N throws ``throws`` (15, N) along lines, for instance of `choose_slopes`; NaN gives NaN.

    The reason of a line that leads to no throw is written, too. Angle and azimuth stay NaN unless ``needs_angles``.
    """
    slopes, moved, reasons = lines
    vectors, numbers, active = releases
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


@kernel
def keep_stops_inside(
    throws: Floats2, plans: Floats2, shifts: Floats2, window: float, workspace: Floats1, good: Bools1
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
def _is_accepted(throws: Floats, row: int, slope: float, origin: Floats, rules: StopRules, workspace: Floats) -> bool:
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


@kernel
def choose_targets(
    throws: Floats2,
    targets: Floats3,
    origins: Floats2,
    rules: StopRules,
    workspace: Floats1,
    attempts: Ints1,
    lines: ThrowLines,
    good: Bools1,
) -> None:
    """Find for each of N objects the first of T targets with an accepted throw; the last target where there is none.

    Args:
        throws: the throws (15, N); their targets are overwritten by the chosen targets.
        targets: targets in the order in which to try them (N, T, 3) [m].
        origins: picks from which targets are moved along the throw (N, 3) [m].
        rules: rules of the stop.
        workspace: two semi-axes, least and greatest height (4,) [m].
        attempts: written, indices of the chosen targets (N,).
        lines: written, as by `choose_slopes`.
        good: which objects may be thrown; overwritten by which throws are accepted (N,).
    """
    slacks, count = np.empty(LANES), targets.shape[1]
    for row in range(len(targets)):
        may_throw, good[row] = good[row], False
        for attempt in range(0 if may_throw else count - 1, count):
            for k in range(3):
                throws[TO_X + k, row] = targets[row, attempt, k]
            slope, moved, reason = _choose_slope(throws, row, False, slacks)
            lines.slope[row], lines.moved[row], lines.reason[row] = slope, moved, reason
            attempts[row] = attempt
            if may_throw and _is_accepted(throws, row, slope, origins[row], rules, workspace):
                good[row] = True
                break
