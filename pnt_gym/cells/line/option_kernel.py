"""Options of robots whose hands move on straight lines, candidate by candidate in machine code; see `pnt_gym.compiled`.

The formulas are those of `StraightMover` and `TrackingMover`, operation by operation, without segments of motions. The
stages of a candidate stand in separate functions, since meetings and releases are planned by the kernels of `planning`
in between. Numpy rounds the cube roots of throws and tangents in its own way, so they are computed there between two
stages.
"""

from __future__ import annotations

import math

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.compiled import compile_for, kernel_part
from pnt_gym.constants import GRAVITY

# Columns of a speed setting: percentage; limits of the hand; acceleration and jerk that are left for the way to an
# object, time of the descent, least time of that way, virtual place of its end ahead of the object and behind the lift,
# and the window of that place. Lengths are in m, times in s.
PERCENT, VELOCITY, ACCELERATION, JERK, WAY_ACCELERATION, WAY_JERK, DESCENT, LEAST_TIME, EARLY, BEHIND, LOW, HIGH = (
    range(12)
)
# Numbers of a cell: speed of the belt and the same as a length; height of the belt; gap under the lip; clearance above
# an object; latest meeting that is searched, and latest one that counts; dwell; height of the ceiling above the pick;
# coasting after the release; share of gravity while braking, NaN without; reserve of the target; semi-axes and heights
# of the workspace; downstream end of the window; whether hands ride with the belt; speed and share of the fading.
(
    SPEED, PACE, BELT_HEIGHT, LIP, CLEARANCE, SEARCH, HORIZON, DWELL, CEILING, COAST, GRAVITY_SHARE, RESERVE, SEMI_X,
    SEMI_Y, Z_MIN, Z_MAX, WINDOW_END, RIDES, USUAL_SPEED, MOST_SHARE,
) = range(20)  # fmt: skip
# Columns of a chase, as in `planning.motion.chase`.
CHASE_FIRST, CHASE_LAST, CHASE_END, CHASE_COLUMNS = 10, 11, 12, 13


@kernel_part
def _stroke_time(distance: float, limits: tuple[float, float, float]) -> float:
    """Shortest time of a stroke, as `planning.motion.chase` computes it."""
    jerk = limits[2]
    roots = np.cbrt(0.25 * jerk * distance * distance), np.cbrt(0.5 * jerk * jerk * distance)
    speed, peak = _peaks(distance, limits, roots)
    if not speed > 0.0:
        return 0.0
    return distance / speed + (speed / peak + peak / limits[2])


@kernel_part
def _peaks(distance: float, limits: tuple[float, float, float], roots: tuple[float, float]) -> tuple[float, float]:
    """`scurve.peaks` of one stroke, with speed and peak of a short stroke as numpy's cube roots."""
    velocity, acceleration, jerk = limits
    square = acceleration * acceleration
    if jerk * jerk * distance <= 2.0 * acceleration * acceleration * acceleration and (
        jerk * distance * distance <= 4.0 * velocity * velocity * velocity
    ):
        return roots
    if jerk * velocity <= square:
        return velocity, math.sqrt(jerk * velocity)
    root = math.sqrt(square * square + 4.0 * jerk * jerk * distance * acceleration)
    return min(2.0 * jerk * distance * acceleration / (square + root), velocity), acceleration


@kernel_part
def _ramp_times(velocity: float, acceleration: float, jerk: float) -> tuple[float, float]:
    """`scurve._ramp_times` of one motion."""
    ramp = acceleration / jerk
    return ramp, 0.0 if acceleration <= 0.0 else max(velocity / acceleration - ramp, 0.0)


@kernel_part
def _contains(numbers: Floats, x: float, y: float, z: float) -> bool:
    """Whether the workspace contains a point."""
    across, along = x / numbers[SEMI_X], y / numbers[SEMI_Y]
    sideways = (1.0 - math.sqrt(across * across + along * along)) * min(numbers[SEMI_X], numbers[SEMI_Y])
    return min(sideways, z - numbers[Z_MIN], numbers[Z_MAX] - z) >= 0.0


@compile_for(
    "void(f8[::1], f8[:, ::1], i8[:, :], f8[::1], i8[:], i8[:, :], f8[:, :], f8[:, :, :], f8[:, :], f8[:, :],"
    "f8[:, ::1], f8[:, ::1], b1[::1])"
)
def chase_objects(
    numbers: Floats,
    settings: Floats,
    candidates: Ints,
    places: Floats,
    lines: Ints,
    index: Ints,
    hand: Floats,
    size: Floats,
    known_depth: Floats,
    lane_y: Floats,
    points: Floats,
    chases: Floats,
    is_open: Bools,
) -> None:
    """Write the chases of hands after candidates, as `plan_intercept` does.

    Args:
        numbers: numbers of the cell by the names above.
        settings: speed settings by the columns above (S, 12).
        candidates: line among the K lines, object among the objects in sight, bin and setting, (4, C).
        places: position of the object from the robot's base (C,) [m].
        lines: indices of the lines (K,).
        index: indices of the objects in sight (K, W).
        hand: positions of the deciding robots' hands (K, 3) [m].
        size: extents of all objects (N, M, 3) [m].
        known_depth: known depth of the centre of mass (N, M) [m].
        lane_y: positions across the belt (N, M) [m].
        points: written, point that the hand must reach at time 0 (C, 3) [m].
        chases: written (C, 13).
        is_open: written, whether the object comes into the window in time (C,).
    """
    speed = numbers[SPEED]
    for c in range(len(places)):
        k, setting = candidates[0, c], settings[candidates[3, c]]
        line, i = lines[k], index[k, candidates[1, c]]
        height = numbers[BELT_HEIGHT] + size[line, i, 2] + numbers[LIP] - known_depth[line, i]
        x = places[c] - setting[EARLY]
        points[c, 0], points[c, 1], points[c, 2] = x, lane_y[line, i], height
        chase = chases[c]
        for axis in range(3):
            chase[axis] = points[c, axis] - hand[k, axis]
        chase[2] += numbers[CLEARANCE]
        velocity, acceleration, jerk = setting[VELOCITY], setting[WAY_ACCELERATION], setting[WAY_JERK]
        chase[3], chase[4], chase[5], chase[6] = speed, 0.0, 0.0, setting[DESCENT]
        chase[7], chase[8], chase[9] = velocity, acceleration, jerk
        low_time, high_time = (setting[LOW] - x) / speed, (setting[HIGH] - x) / speed
        first, last = max(min(low_time, high_time), 0.0), min(max(low_time, high_time), numbers[SEARCH])
        is_open[c] = first <= last and first <= numbers[SEARCH]
        chase[CHASE_FIRST], chase[CHASE_LAST] = (first, last) if first <= last else (0.0, 0.0)
        far = math.sqrt(chase[0] * chase[0] + chase[1] * chase[1] + chase[2] * chase[2])
        peak = min(math.sqrt(jerk * velocity), acceleration)
        latest = far / velocity + 2.0 * (velocity / peak + peak / jerk) + setting[DESCENT]
        slower = numbers[PACE] < velocity
        chase[CHASE_END] = 1.001 * latest / (1.0 - numbers[PACE] / velocity) if slower else math.inf


@compile_for(
    "i8(f8[::1], f8[:, ::1], i8[:, :], f8[:, ::1], f8[:, ::1], b1[::1], f8[::1], b1[::1], i8[::1], f8[:, ::1],"
    "f8[::1], f8[::1])"
)
def meet_objects(
    numbers: Floats,
    settings: Floats,
    candidates: Ints,
    points: Floats,
    chases: Floats,
    is_open: Bools,
    times: Floats,
    reached: Bools,
    met: Ints,
    picks: Floats,
    acceleration: Floats,
    waits: Floats,
) -> int:
    """Write the candidates that hands meet in time, as `Mover.reach` and `plan_intercept` do; returns their number.

    Args:
        numbers: see `chase_objects`.
        settings: see `chase_objects`.
        candidates: see `chase_objects`.
        points: see `chase_objects`.
        chases: see `chase_objects`.
        is_open: see `chase_objects`.
        times: times of the meetings (C,) [s].
        reached: whether there is a meeting (C,).
        met: written, the candidates that are met (at most C,).
        picks: written, where the objects are lifted (at most C, 3) [m].
        acceleration: written, limit of the setting's acceleration (at most C,) [m/s2].
        waits: written, standstill of the hand above the belt (at most C,) [s].
    """
    count = 0
    for c in range(len(times)):
        setting, time = settings[candidates[3, c]], times[c]
        if not (is_open[c] and reached[c] and time >= setting[LEAST_TIME] and time <= numbers[HORIZON]):
            continue
        met[count], acceleration[count], waits[count] = c, setting[ACCELERATION], 0.0
        picks[count, 0] = points[c, 0] + time * numbers[SPEED] + setting[BEHIND]
        picks[count, 1], picks[count, 2] = points[c, 1], points[c, 2]
        if not time > chases[c, CHASE_FIRST]:
            x, y, z = chases[c, 0] + time * numbers[SPEED], chases[c, 1], chases[c, 2]
            limits = setting[VELOCITY], setting[WAY_ACCELERATION], setting[WAY_JERK]
            waits[count] = max(time - _stroke_time(math.sqrt(x * x + y * y + z * z), limits) - setting[DESCENT], 0.0)
        count += 1
    return count


@compile_for(
    "void(f8[::1], f8[:, ::1], f8[:, ::1], i8[:, :], i8[:], f8[:, :], f8[:], f8[:, ::1], f8[:, ::1], f8[::1],b1[::1])"
)
def lay_out_throws(
    numbers: Floats,
    settings: Floats,
    sites: Floats,
    candidates: Ints,
    met: Ints,
    picks: Floats,
    acceleration: Floats,
    throws: Floats,
    moved_throws: Floats,
    fading: Floats,
    is_possible: Bools,
) -> None:
    """Write the throws of met candidates, and the same with moved targets, for the kernel of releases.

    Args:
        numbers: see `chase_objects`.
        settings: see `chase_objects`.
        sites: centres of the bins' openings (B, 3) [m].
        candidates: see `chase_objects`.
        met: the candidates that are met (C,).
        picks: where the objects are lifted (C, 3) [m].
        acceleration: limit of each throw's acceleration (C,) [m/s2].
        throws: written (15, C).
        moved_throws: written, first the throws with nearer targets, then those with farther targets (15, 2 C).
        fading: written, time in which the belt's speed fades from the hand (C,) [s].
        is_possible: written, whether the limits allow that fading (C,).
    """
    count, speed = len(met), numbers[SPEED]
    for m in range(count):
        setting, site = settings[candidates[3, met[m]]], sites[candidates[2, met[m]]]
        x, y, z = picks[m, 0], picks[m, 1], picks[m, 2]
        velocity, peak, jerk = setting[VELOCITY], acceleration[m], setting[JERK]
        start, fading[m], is_possible[m] = x, 0.0, True
        if numbers[RIDES] > 0.0:
            longest = (velocity + speed) / peak + peak / jerk
            usual = (numbers[USUAL_SPEED] + speed) / peak + peak / jerk
            shortest = 2.0 * speed / (numbers[MOST_SHARE] * peak)
            fading[m] = min(longest, max(usual, shortest))
            start = x + speed * fading[m] / 2.0
            is_possible[m] = fading[m] >= shortest
            least, taken = 1.0 - numbers[MOST_SHARE], 2.0 * speed / fading[m]
            peak, jerk = max(peak - taken, least * peak), max(jerk - 2.0 * taken / fading[m], least * jerk)
        dx, dy = site[0] - x, site[1] - y
        far = math.sqrt(dx * dx + dy * dy)
        for k in range(3):
            rows, column = (throws, m) if k == 0 else (moved_throws, m + (k - 1) * count)
            along = (2.0 * k - 3.0) * numbers[RESERVE]
            rows[0, column], rows[1, column], rows[2, column] = start, y, z
            rows[3, column], rows[4, column], rows[5, column] = site[0], site[1], site[2]
            if k > 0:
                rows[3, column], rows[4, column] = site[0] + along * (dx / far), site[1] + along * (dy / far)
            rows[6, column], rows[7, column], rows[8, column] = velocity, peak, jerk
            rows[9, column], rows[10, column] = 0.0, z + numbers[CEILING] if k == 0 else math.inf
            rows[11, column], rows[12, column] = 0.0, math.inf
            rows[13, column], rows[14, column] = -math.inf, math.inf


@kernel_part
def _braking_acceleration(numbers: Floats, acceleration: float, angle: float) -> float:
    """Limit of the acceleration while a hand brakes after a release at an elevation."""
    share = numbers[GRAVITY_SHARE]
    if math.isnan(share):
        return acceleration
    return min(acceleration, share * GRAVITY / max(math.sin(angle), 1e-3))


@kernel_part
def _stop_place(
    numbers: Floats, throws: Floats, column: int, vectors: Floats, figures: Floats, angle: float
) -> tuple[float, float, float]:
    """Place at which a hand stands still after its throw."""
    speed, jerk = figures[0, column], throws[8, column]
    acceleration = _braking_acceleration(numbers, throws[7, column], angle)
    ramp, plateau = _ramp_times(speed, min(math.sqrt(jerk * speed), acceleration), jerk)
    run_out = numbers[COAST] * speed + 0.5 * speed * (2.0 * ramp + plateau)
    way = figures[4, column] + run_out
    return (
        throws[0, column] + vectors[2, column, 0] * way,
        throws[1, column] + vectors[2, column, 1] * way,
        throws[2, column] + vectors[2, column, 2] * way,
    )


@compile_for(
    "i8(f8[::1], i8[:], f8[:, :], f8[:, ::1], i8[::1], f8[:, :, ::1], f8[:, ::1], f8[:, ::1], i8[::1],"
    "f8[:, :, ::1], f8[:, ::1], b1[::1], i8[::1], f8[:, ::1], f8[:, ::1])"
)
def accept_throws(
    numbers: Floats,
    met: Ints,
    picks: Floats,
    throws: Floats,
    reasons: Ints,
    vectors: Floats,
    figures: Floats,
    moved_throws: Floats,
    moved_reasons: Ints,
    moved_vectors: Floats,
    moved_figures: Floats,
    is_possible: Bools,
    good: Ints,
    stops: Floats,
    radicands: Floats,
) -> int:
    """Write the throws that the robot can execute, for their targets and for moved targets; returns their number.

    Args:
        numbers: see `chase_objects`.
        met: see `lay_out_throws`.
        picks: see `lay_out_throws`.
        throws: see `lay_out_throws`.
        reasons: reason why there is no throw, 0 where there is (C,).
        vectors: position, velocity and direction of the releases (3, C, 3).
        figures: speed, acceleration, angle, azimuth, distance, time and time of flight (7, C).
        moved_throws: see `lay_out_throws`.
        moved_reasons: the same of the moved throws (2 C,).
        moved_vectors: the same (3, 2 C, 3).
        moved_figures: the same (7, 2 C).
        is_possible: see `lay_out_throws`.
        good: written, the accepted throws (at most C,).
        stops: written, places where the hands stop (at most C, 3) [m].
        radicands: written, numbers whose cube roots are speed and peak of a short throw (2, C).
    """
    count, accepted = len(met), 0
    checks = 3 if numbers[RESERVE] > 0.0 else 1
    for m in range(count):
        if reasons[m] != 0 or not is_possible[m]:
            continue
        if not _contains(numbers, throws[0, m], throws[1, m], throws[2, m]):
            continue
        if numbers[RIDES] > 0.0 and not _contains(numbers, picks[m, 0], picks[m, 1], picks[m, 2]):
            continue
        angle = figures[2, m]
        x, y, z = _stop_place(numbers, throws, m, vectors, figures, angle)
        is_good = _contains(numbers, x, y, z)
        for k in range(1, checks):
            column = m + (k - 1) * count
            is_good = is_good and moved_reasons[column] == 0
            if is_good:
                is_good = _contains(
                    numbers, *_stop_place(numbers, moved_throws, column, moved_vectors, moved_figures, angle)
                )
        if is_good:
            good[accepted], stops[accepted, 0], stops[accepted, 1], stops[accepted, 2] = m, x, y, z
            stroke, jerk = 2.0 * figures[4, m], throws[8, m]
            radicands[0, accepted], radicands[1, accepted] = 0.25 * jerk * stroke * stroke, 0.5 * jerk * jerk * stroke
            accepted += 1
    return accepted


@kernel_part
def _throwing_times(
    numbers: Floats, throws: Floats, figures: Floats, m: int, roots: tuple[float, float]
) -> tuple[float, float]:
    """Times from the lift until release and stop, without the delay of a fading, as `StraightMover.throw`."""
    velocity, acceleration, jerk = throws[6, m], throws[7, m], throws[8, m]
    stroke, speed = 2.0 * figures[4, m], figures[0, m]
    top, peak = _peaks(stroke, (velocity, acceleration, jerk), roots)
    ramp, plateau = _ramp_times(top, peak, jerk)
    cruise = max(stroke / top - 2.0 * ramp - plateau, 0.0) if top > 0.0 else 0.0
    release = ramp + plateau + ramp + 0.5 * cruise
    limit = _braking_acceleration(numbers, acceleration, figures[2, m])
    ramp, plateau = _ramp_times(speed, min(math.sqrt(jerk * speed), limit), jerk)
    return release, release + numbers[COAST] + (ramp + plateau + ramp)


@compile_for(
    "void(f8[::1], f8[:, ::1], f8[:, ::1], i8[:, :], f8[:], i8[:], f8[:, :], f8[:, ::1], f8[:, ::1], f8[::1],"
    "i8[:], f8[:, ::1], f8[:], f8[:, :], f8[:, ::1])"
)
def finish_options(
    numbers: Floats,
    settings: Floats,
    sites: Floats,
    candidates: Ints,
    times: Floats,
    met: Ints,
    picks: Floats,
    throws: Floats,
    figures: Floats,
    fading: Floats,
    good: Ints,
    stops: Floats,
    waits: Floats,
    roots: Floats,
    options: Floats,
) -> None:
    """Write times and places of the accepted throws.

    Args:
        numbers: see `chase_objects`.
        settings: see `chase_objects`.
        sites: see `lay_out_throws`.
        candidates: see `chase_objects`.
        times: see `meet_objects`.
        met: see `lay_out_throws`.
        picks: see `lay_out_throws`.
        throws: see `lay_out_throws`.
        figures: see `accept_throws`.
        fading: see `lay_out_throws`.
        good: the accepted throws (G,).
        stops: see `accept_throws`.
        waits: see `meet_objects`.
        roots: cube roots of the radicands of the accepted throws (2, G).
        options: written, numbers as `PicksAndThrows` has them (G, 13).
    """
    for g in range(len(good)):
        m = good[g]
        c = met[m]
        setting, site, time = settings[candidates[3, c]], sites[candidates[2, c]], times[c]
        release, throwing = _throwing_times(numbers, throws, figures, m, (roots[0, g], roots[1, g]))
        if numbers[RIDES] > 0.0:
            throwing += max(fading[m] - release, 0.0)
        lift, option = time + numbers[DWELL], options[g]
        option[0] = setting[PERCENT]
        for axis in range(3):
            option[1 + axis], option[10 + axis] = picks[m, axis], stops[g, axis]
        option[4], option[5] = site[0] - picks[m, 0], site[1] - picks[m, 1]
        option[6], option[7] = lift, waits[m]
        option[8] = lift + (numbers[WINDOW_END] - picks[m, 0]) / numbers[SPEED]
        option[9] = throwing


@compile_for("void(f8, f8[:, ::1])")
def write_descents(clearance: float, settings: Floats) -> None:
    """Write the times of the descents of speed settings (S, 12), from the other columns."""
    for setting in settings:
        setting[DESCENT] = _stroke_time(clearance, (setting[VELOCITY], setting[WAY_ACCELERATION], setting[WAY_JERK]))
