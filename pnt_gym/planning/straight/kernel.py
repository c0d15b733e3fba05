"""Throws along straight lines, N at a time. Compiled; see `pnt_gym.compiled`.

`crossing` and `bounds` hold the formulas of one throw; a single throw is a batch of one row.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.compiled import empty_rows, kernel, kernel_part
from pnt_gym.constants import GRAVITY
from pnt_gym.planning.motion.strokes import brake_distance
from pnt_gym.planning.straight.bounds import LANES, Box, slope_below_roof, slope_in_bounds
from pnt_gym.planning.straight.crossing import Line, best_slope, crossing, flight_time, lay_out
from pnt_gym.planning.straight.plan import CONTACT, MIN_REACH, Reason, ReleaseBatch
from pnt_gym.planning.straight.rows import Space, Stop, StopRules, Throw, ThrowLine
from pnt_gym.rows import Bools1, Floats2, Floats3, Ints1, Rows1

NO_REACH, TOO_HIGH, OUTSIDE, TOO_FLAT = map(int, (Reason.NO_REACH, Reason.CEILING, Reason.WORKSPACE, Reason.ELEVATION))


LINE, RELEASE = ThrowLine.dtype, ReleaseBatch.dtype


@kernel_part
def _choose_slope(throw: Throw, has_workspace: bool, slacks: Floats) -> tuple[float, bool, int]:
    """Slope, whether a bound moved the line, and reason of a throw, as `choose_slopes`; ``slacks`` is overwritten."""
    plane, _, _ = lay_out(throw)
    if plane.reach <= MIN_REACH:
        return math.nan, False, NO_REACH
    best = best_slope(plane)
    roof = throw.ceiling - throw.pick[2]
    box = Box(throw.near, throw.far, throw.low, min(throw.high, roof))
    if not has_workspace and box.high >= 0.0:
        slope = slope_below_roof(plane, box.high, best, slacks)
    else:
        slope = slope_in_bounds(plane, box, best, has_workspace)
    if not math.isnan(slope):
        return slope, slope != best, 0
    # The reason is the ceiling where the ceiling alone rules the throw out.
    if has_workspace:
        below_roof = slope_in_bounds(plane, Box(0.0, math.inf, -math.inf, roof), best, not has_workspace)
        return slope, False, TOO_HIGH if math.isnan(below_roof) else OUTSIDE
    return slope, False, TOO_HIGH


@kernel
def choose_slopes(throws: Rows1[Throw], has_workspace: bool) -> Rows1[ThrowLine]:
    """Find the quickest lines of N throws, within a workspace if ``has_workspace``."""
    slacks, lines = np.empty(LANES), empty_rows(len(throws), LINE)
    for row in range(len(throws)):
        line = lines[row]
        line.slope, line.moved, line.reason = _choose_slope(throws[row], has_workspace, slacks)
    return lines


@kernel_part
def _clear(release: Any) -> None:
    """Write a release that holds no plan."""
    for k in range(3):
        release.position[k] = release.velocity[k] = release.direction[k] = math.nan
    release.speed = release.acceleration = release.angle = release.azimuth = math.nan
    release.distance = release.time = release.flight_time = math.nan
    release.ceiling_active = release.workspace_active = False
    release.straight = True


@kernel_part
def _write_release(throw: Throw, line: ThrowLine, needs_angles: bool, has_workspace: bool, release: Any) -> None:
    """Write the release of a throw along a line; the reason where the line leads to no throw."""
    plane, cosine, sine = lay_out(throw)
    slope, flight = line.slope, flight_time(plane, line.slope)
    if math.isnan(slope):
        return
    if plane.reach <= MIN_REACH or flight <= 0.0:
        release.reason = TOO_FLAT if plane.reach > MIN_REACH else NO_REACH
        return
    distance, speed = crossing(plane, slope)
    peak = min(math.sqrt(plane.jerk * speed), plane.acceleration)
    release.speed, release.acceleration, release.distance, release.flight_time = speed, peak, distance, flight
    # Half of Eq. 4 over the stroke 2 P_r, which is Eq. 12.
    release.time = distance / speed + 0.5 * (speed / peak + peak / plane.jerk)
    if needs_angles:
        release.angle, release.azimuth = math.atan(slope), math.atan2(sine, cosine)
    level = 1.0 / math.sqrt(1.0 + slope * slope)
    direction = (level * cosine, level * sine, level * slope)
    for k in range(3):
        release.position[k] = throw.pick[k] + distance * direction[k]
        release.velocity[k] = speed * direction[k]
        release.direction[k] = direction[k]
    roofed = line.moved and (not has_workspace or release.position[2] >= throw.ceiling - CONTACT)
    release.ceiling_active, release.workspace_active = roofed, line.moved and not roofed


@kernel
def release_rows(
    throws: Rows1[Throw], has_workspace: bool, needs_angles: bool, lines: Rows1[ThrowLine]
) -> Rows1[ReleaseBatch]:
    """Compute the releases of N throws along lines, for instance of `choose_slopes`; NaN gives NaN.

    Angle and azimuth stay NaN unless ``needs_angles``.
    """
    releases = empty_rows(len(throws), RELEASE)
    for row in range(len(throws)):
        release = releases[row]
        _clear(release)
        release.reason = lines[row].reason
        _write_release(throws[row], lines[row], needs_angles, has_workspace, release)
        release.feasible = release.reason == 0
    return releases


@kernel_part
def is_inside(x: float, y: float, z: float, space: Space) -> bool:
    """Whether a point lies in a workspace [m]."""
    east, north = x / space.semi_x, y / space.semi_y
    return (1.0 - math.sqrt(east * east + north * north)) >= 0.0 and space.z_min <= z <= space.z_max


@kernel_part
def _stops_inside(throw: Throw, line: Line, window: float, brake: float, space: Space) -> bool:
    """Whether the hand of a throw along a line stops inside the workspace, after the window at constant velocity."""
    way = line.distance + (window * line.speed + brake_distance(line.speed, brake, throw.jerk))
    x, y, z = throw.pick[0] + line.x * way, throw.pick[1] + line.y * way, throw.pick[2] + line.z * way
    return is_inside(x, y, z, space)


@kernel_part
def _line_at(throw: Throw, slope: float) -> Line:
    """Line of a throw at a slope; its distance is NaN where there is no throw."""
    plane, cosine, sine = lay_out(throw)
    if plane.reach <= MIN_REACH or not flight_time(plane, slope) > 0.0:
        return Line(math.nan, math.nan, math.nan, math.nan, math.nan)
    distance, speed = crossing(plane, slope)
    level = 1.0 / math.sqrt(1.0 + slope * slope)
    return Line(distance, speed, level * cosine, level * sine, level * slope)


@kernel_part
def _has_reserve(
    throw: Throw, slope: float, shift: tuple[float, float], window: float, brake: float, space: Space
) -> bool:
    """Whether a throw stops inside the workspace also with its target moved by a shift, back and forth."""
    x, y = throw.target[0], throw.target[1]
    is_good = True
    for side in range(2):
        sign = 2.0 * side - 1.0
        throw.target[0], throw.target[1] = x + sign * shift[0], y + sign * shift[1]
        line = _line_at(throw, slope)
        is_good = is_good and line.distance >= 0.0 and _stops_inside(throw, line, window, brake, space)
    throw.target[0], throw.target[1] = x, y
    return is_good


@kernel
def keep_stops_inside(
    throws: Rows1[Throw],
    releases: Rows1[ReleaseBatch],
    stops: Rows1[Stop],
    has_shifts: bool,
    window: float,
    space: Space,
    good: Bools1,
) -> None:
    """Write which of N planned throws stop inside a workspace, also with their targets moved back and forth.

    The workspace is convex and the path straight, so the pick and the stop are enough.

    Args:
        throws: the throws.
        releases: their releases.
        stops: how the hands stop.
        has_shifts: whether the targets move; if not, the shifts mean nothing.
        window: time between the release and the braking [s].
        space: the workspace.
        good: which throws have a plan; overwritten by the result.
    """
    for row in range(len(throws)):
        throw, release, stop = throws[row], releases[row], stops[row]
        if not (good[row] and is_inside(throw.pick[0], throw.pick[1], throw.pick[2], space)):
            good[row] = False
            continue
        ahead, brake = release.direction, stop.braking
        line = Line(release.distance, release.speed, ahead[0], ahead[1], ahead[2])
        good[row] = _stops_inside(throw, line, window, brake, space)
        if has_shifts:
            shift = stop.shift[0], stop.shift[1]
            good[row] &= _has_reserve(throw, stop.slope, shift, window, brake, space)


@kernel_part
def _is_accepted(throw: Throw, slope: float, origin: Floats, rules: StopRules, space: Space) -> bool:
    """Whether a throw at a slope stops inside the workspace, also to moved targets; see `choose_targets`."""
    window, gravity_share, reserve = rules
    line = _line_at(throw, slope)
    if not (line.distance >= 0.0 and is_inside(throw.pick[0], throw.pick[1], throw.pick[2], space)):
        return False
    brake = throw.acceleration
    if gravity_share > 0.0:
        brake = min(brake, gravity_share * GRAVITY / max(math.sin(math.atan(slope)), 1e-3))
    if not _stops_inside(throw, line, window, brake, space):
        return False
    if reserve == 0.0:
        return True
    x, y = throw.target[0] - origin[0], throw.target[1] - origin[1]
    distance = math.sqrt(x * x + y * y)
    shift = reserve * (x / distance), reserve * (y / distance)
    return _has_reserve(throw, slope, shift, window, brake, space)


@kernel
def choose_targets(
    throws: Rows1[Throw], targets: Floats3, origins: Floats2, rules: StopRules, space: Space, good: Bools1
) -> tuple[Ints1, Rows1[ThrowLine]]:
    """Find for each of N objects the first of T targets with an accepted throw; the last target where there is none.

    Args:
        throws: the throws; their targets are overwritten by the chosen targets.
        targets: targets in the order in which to try them (N, T, 3) [m].
        origins: picks from which targets are moved along the throw (N, 3) [m].
        rules: rules of the stop.
        space: the workspace.
        good: which objects may be thrown; overwritten by which throws are accepted (N,).

    Returns:
        Indices of the chosen targets (N,), and the lines of their throws.
    """
    slacks, attempts = np.empty(LANES), np.empty(len(targets), dtype=np.int64)
    count, lines = targets.shape[1], empty_rows(len(targets), LINE)
    for row in range(len(targets)):
        throw, line = throws[row], lines[row]
        may_throw, good[row] = good[row], False
        for attempt in range(0 if may_throw else count - 1, count):
            for k in range(3):
                throw.target[k] = targets[row, attempt, k]
            line.slope, line.moved, line.reason = _choose_slope(throw, False, slacks)
            attempts[row] = attempt
            if may_throw and _is_accepted(throw, line.slope, origins[row], rules, space):
                good[row] = True
                break
    return attempts, lines
