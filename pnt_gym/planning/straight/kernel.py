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
from pnt_gym.planning.motion.kernel import (
    RUN_UP,
    STOP,
    new_segments,
    passes_hole,
    space_margin,
    write_run_up,
    write_stop,
)
from pnt_gym.planning.motion.limits import LimitRows, Space
from pnt_gym.planning.motion.rows import Segments
from pnt_gym.planning.motion.strokes import duration, greatest_acceleration, peaks, ramp_distance
from pnt_gym.planning.straight.bounds import LANES, Box, slope_below_roof, slope_in_bounds
from pnt_gym.planning.straight.crossing import Line, best_slope, crossing, flight_time, lay_out
from pnt_gym.planning.straight.plan import CONTACT, MIN_REACH, Reason, ReleaseBatch
from pnt_gym.planning.straight.rows import Ends, StopRules, Throw, ThrowLine
from pnt_gym.rows import Bools1, Floats1, Floats2, Floats3, Ints1, Rows1

NO_REACH, TOO_HIGH, OUTSIDE, TOO_FLAT = map(int, (Reason.NO_REACH, Reason.CEILING, Reason.WORKSPACE, Reason.ELEVATION))
SAME_POINT = int(Reason.SAME_POINT)
LOWER_STEPS, HALVINGS = 24, 12
"""Number of lower elevations that are tried, and of bisection steps for the elevation between two of them."""

LINE, RELEASE, THROW = ThrowLine.dtype, ReleaseBatch.dtype, Throw.dtype


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
def _write_motion(throw: Throw, distance: float, speed: float, ahead: tuple[float, float, float], release: Any) -> None:
    """Write the motion to a release at a distance along a unit vector."""
    peak = greatest_acceleration(speed, throw.acceleration, throw.jerk)
    release.speed, release.acceleration, release.distance = speed, peak, distance
    # Half of Eq. 4 over the stroke 2 P_r, which is Eq. 12.
    release.time = 0.5 * duration(2.0 * distance, speed, peak, throw.jerk)
    for k in range(3):
        release.position[k] = throw.pick[k] + distance * ahead[k]
        release.velocity[k] = speed * ahead[k]
        release.direction[k] = ahead[k]


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
    if needs_angles:
        release.angle, release.azimuth = math.atan(slope), math.atan2(sine, cosine)
    level = 1.0 / math.sqrt(1.0 + slope * slope)
    release.flight_time = flight
    _write_motion(throw, distance, speed, (level * cosine, level * sine, level * slope), release)
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
def braking_limit(acceleration: float, gravity_share: float, rise: float) -> float:
    """Limit of the acceleration of a hand that brakes on a line with a given sine of the elevation [m/s2].

    With a share of gravity, the hand accelerates downwards by at most that share of g.
    """
    return min(acceleration, gravity_share * GRAVITY / max(rise, 1e-3)) if gravity_share > 0.0 else acceleration


@kernel_part
def stop_distance(release_distance: float, speed: float, window: float, braking: float, jerk: float) -> float:
    """Way of a hand from its pick to its stop [m], after the window at constant velocity."""
    return release_distance + (window * speed + ramp_distance(speed, braking, jerk))


@kernel_part
def _line_stops_inside(throw: Throw, line: Line, window: float, braking: float, space: Space) -> bool:
    """Whether the hand of a throw along a line stops inside the workspace, and passes beside its hole."""
    way = stop_distance(line.distance, line.speed, window, braking, throw.jerk)
    x, y, z = throw.pick[0] + line.x * way, throw.pick[1] + line.y * way, throw.pick[2] + line.z * way
    return space_margin(x, y, z, space) >= 0.0 and passes_hole(throw.pick[0], throw.pick[1], x, y, space)


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
def _is_accepted(
    throw: Throw, line: Line, slope: float, shift: tuple[float, float], rules: StopRules, space: Space
) -> bool:
    """Whether a throw along a line stops inside the workspace, also with its target moved by a shift, back and forth.

    The workspace is convex but for its hole, and the path straight, so pick, stop and hole are enough.
    """
    if not (line.distance >= 0.0 and space_margin(throw.pick[0], throw.pick[1], throw.pick[2], space) >= 0.0):
        return False
    braking = braking_limit(throw.acceleration, rules.gravity_share, line.z)
    is_good = _line_stops_inside(throw, line, rules.window, braking, space)
    if shift[0] == 0.0 and shift[1] == 0.0:
        return is_good
    x, y = throw.target[0], throw.target[1]
    for side in range(2):
        sign = 2.0 * side - 1.0
        throw.target[0], throw.target[1] = x + sign * shift[0], y + sign * shift[1]
        moved = _line_at(throw, slope)
        is_good = is_good and moved.distance >= 0.0 and _line_stops_inside(throw, moved, rules.window, braking, space)
    throw.target[0], throw.target[1] = x, y
    return is_good


@kernel_part
def stays_inside(throw: Throw, release: Any, shift: tuple[float, float], rules: StopRules, space: Space) -> bool:
    """Whether a planned throw stops inside a workspace, also with its target moved by a shift, back and forth."""
    ahead = release.direction
    slope = ahead[2] / math.sqrt(ahead[0] * ahead[0] + ahead[1] * ahead[1])
    line = Line(release.distance, release.speed, ahead[0], ahead[1], ahead[2])
    return release.feasible and _is_accepted(throw, line, slope, shift, rules, space)


@kernel_part
def _open_throws(picks: Floats, targets: Floats, limits: LimitRows) -> Any:
    """Throws from picks (N, 3) to targets (N, 3) [m] without bounds."""
    throws = empty_rows(len(picks), THROW)
    for row in range(len(picks)):
        throw = throws[row]
        for k in range(3):
            throw.pick[k], throw.target[k] = picks[row, k], targets[row, k]
        throw.velocity, throw.acceleration, throw.jerk = (
            limits.velocity[row],
            limits.acceleration[row],
            limits.jerk[row],
        )
        throw.tolerance, throw.ceiling = 0.0, math.inf
        throw.near, throw.far, throw.low, throw.high = 0.0, math.inf, -math.inf, math.inf
    return throws


@kernel
def stops_inside(
    picks: Floats2,
    targets: Floats2,
    limits: LimitRows,
    releases: Rows1[ReleaseBatch],
    shifts: Floats2,
    rules: StopRules,
    space: Space,
) -> Bools1:
    """Find which of N planned throws stay in a workspace until the hand has stopped on the line of the throw.

    The throws at the same elevation to targets moved by the shifts, forth and back, have to stay in the workspace too.

    Args:
        picks: starts of the hands at rest (N, 3) [m].
        targets: points the objects pass through (N, 3) [m].
        limits: limits of the hands (N,).
        releases: releases of the throws.
        shifts: displacements of the targets along x and y (N, 2+) [m]; zeros for the targets alone.
        rules: rules of the stops; the shifts stand for the reserve.
        space: positions that the hands can reach.
    """
    throws, good = _open_throws(picks, targets, limits), np.empty(len(picks), dtype=np.bool_)
    for row in range(len(throws)):
        good[row] = stays_inside(throws[row], releases[row], (shifts[row, 0], shifts[row, 1]), rules, space)
    return good


@kernel_part
def reserve_shift(throw: Throw, origin: Floats, reserve: float) -> tuple[float, float]:
    """Displacement of a target along the throw, as seen from an origin [m]."""
    x, y = throw.target[0] - origin[0], throw.target[1] - origin[1]
    distance = math.sqrt(x * x + y * y)
    return (reserve * (x / distance), reserve * (y / distance)) if reserve > 0.0 else (0.0, 0.0)


@kernel
def choose_targets(
    picks: Floats2,
    targets: Floats3,
    limits: LimitRows,
    ceiling: Floats1,
    rules: StopRules,
    space: Space,
    origins: Floats2,
    may_throw: Bools1,
) -> tuple[Ints1, Rows1[ReleaseBatch], Bools1]:
    """Find for each of N objects the quickest throw into the first of T targets whose throw is accepted.

    A row without an accepted throw has the last target. The arguments are finite, and are not checked.

    Args:
        picks: starts of the hands at rest (N, 3) [m].
        targets: targets in the order in which to try them (N, T, 3) [m].
        limits: limits of the hands (N,).
        ceiling: greatest heights of the release points (N,) [m].
        rules: rules of the stops.
        space: positions that the hands can reach.
        origins: points from which targets are moved along the throw (N, 3) [m].
        may_throw: which objects may be thrown at all (N,).

    Returns:
        Indices of the chosen targets (N,), the releases, and which throws are accepted (N,).
    """
    slacks, attempts, good = np.empty(LANES), np.empty(len(targets), dtype=np.int64), np.empty_like(may_throw)
    count, lines, throws = targets.shape[1], empty_rows(len(targets), LINE), _open_throws(picks, targets[:, 0], limits)
    for row in range(len(targets)):
        throw, line = throws[row], lines[row]
        throw.ceiling, good[row] = ceiling[row], False
        for attempt in range(0 if may_throw[row] else count - 1, count):
            for k in range(3):
                throw.target[k] = targets[row, attempt, k]
            line.slope, line.moved, line.reason = _choose_slope(throw, False, slacks)
            attempts[row] = attempt
            shift = reserve_shift(throw, origins[row], rules.reserve)
            along = _line_at(throw, line.slope)
            if may_throw[row] and _is_accepted(throw, along, line.slope, shift, rules, space):
                good[row] = True
                break
    return attempts, release_rows(throws, False, True, lines), good


@kernel_part
def _releases_below(throw: Throw, angle: float, top: float) -> bool:
    """Whether a throw at an elevation [rad] is possible and releases its object at most at a height [m]."""
    line = _line_at(throw, math.tan(angle))
    return throw.pick[2] + line.distance * line.z <= top


@kernel
def lower_angles(throws: Rows1[Throw], angles: Floats1, tops: Floats1) -> Floats1:
    """Find the largest elevations (N,) [rad] below others (N,) at which N throws release at most at heights (N,) [m].

    A coarse walk down finds the first elevation that fits, and bisection the border above it. An elevation is 0 where
    none fits.
    """
    lowered = np.empty(len(throws))
    for row in range(len(throws)):
        throw, angle, top, low = throws[row], angles[row], tops[row], 0.0
        for step in range(LOWER_STEPS - 1, 0, -1):
            if _releases_below(throw, angle * (step / LOWER_STEPS), top):
                low = step / LOWER_STEPS
                break
        high = low + 1.0 / LOWER_STEPS
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            if _releases_below(throw, angle * middle, top):
                low = middle
            else:
                high = middle
        lowered[row] = angle * low
    return lowered


@kernel
def release_at_points(throws: Rows1[Throw]) -> Rows1[ReleaseBatch]:
    """Compute the throws that release at their targets, with all the speed that the S-curve gives there.

    Azimuth and angle are those of the ways; the flight time stays NaN. A throw whose target is its pick has no plan.
    """
    releases = empty_rows(len(throws), RELEASE)
    for row in range(len(throws)):
        throw, release = throws[row], releases[row]
        _clear(release)
        release.reason = SAME_POINT
        x, y, z = throw.target[0] - throw.pick[0], throw.target[1] - throw.pick[1], throw.target[2] - throw.pick[2]
        flat, distance = math.sqrt(x * x + y * y), math.sqrt(x * x + y * y + z * z)
        if distance > MIN_REACH:
            speed = peaks(2.0 * distance, throw.velocity, throw.acceleration, throw.jerk)[0]
            _write_motion(throw, distance, speed, (x / distance, y / distance, z / distance), release)
            release.angle, release.azimuth, release.reason = math.atan2(z, flat), math.atan2(y, x), 0
        release.feasible = release.reason == 0
    return releases


@kernel
def throw_motions(
    pick: Floats2, releases: Rows1[ReleaseBatch], limits: LimitRows, rules: StopRules
) -> tuple[Segments, Ends]:
    """Compute the motions of N hands from picks (N, 3) [m] through releases and windows to stops, and their ends."""
    count = len(pick)
    segments, ends = (
        new_segments(count, RUN_UP + 1 + STOP),
        Ends(np.empty(count), np.empty(count), np.empty((count, 3))),
    )
    for row in range(count):
        release, ahead, jerk = releases[row], releases[row].direction, limits.jerk[row]
        braking = braking_limit(limits.acceleration[row], rules.gravity_share, ahead[2])
        run_up = write_run_up(segments, row, 0, ahead, release.distance, limits)
        segments.durations[row, RUN_UP], segments.jerks[row, RUN_UP] = rules.window, 0.0
        stop = write_stop(segments, row, RUN_UP + 1, ahead, release.speed, braking, jerk)
        ends.release_time[row], ends.stop_time[row] = run_up, run_up + rules.window + stop
        way = stop_distance(release.distance, release.speed, rules.window, braking, jerk)
        for axis in range(3):
            ends.stop[row, axis] = pick[row, axis] + ahead[axis] * way
    return segments, ends
