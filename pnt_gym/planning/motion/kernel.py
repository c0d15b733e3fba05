"""Paths of piecewise constant jerk: motions along lines, sums, borders of segments, samples. Compiled; see `compiled`.

Motions along lines are those of `scurve` and `riding`, operation by operation. NumPy rounds cube roots in its own way,
so the cube roots of short strokes (`scurve.cube_roots`) are arguments.
"""

from __future__ import annotations

import math

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.compiled import kernel, kernel_part
from pnt_gym.planning.motion.limits import LimitRows
from pnt_gym.planning.motion.rows import Knot
from pnt_gym.planning.motion.strokes import is_short, long_peaks, ramp_times, stop_times
from pnt_gym.planning.motion.trajectory import Borders, Ends, Lines, Segments, Start
from pnt_gym.rows import Floats1, Floats2, Floats3, Ints2, Rows1, Rows2

# Numbers of segments: up to a release and half the cruise; window and braking; a move from rest to rest.
RUN_UP, STOPPING, MOVE = 4, 4, 7


@kernel
def add_motions(one: Segments, other: Segments, total: Segments) -> None:
    """Write the sums of N motions of K segments and N of L segments, with K + L segments."""
    durations = total.durations
    for row in range(len(durations)):
        first, second = np.cumsum(one.durations[row]), np.cumsum(other.durations[row])
        # Numbers of borders so far, and indices of the segments that hold in the middle between two borders.
        i, j, k, m = 0, 0, 0, 0
        border = 0.0
        for column in range(durations.shape[1]):
            before = border
            if j == len(second) or (i < len(first) and first[i] <= second[j]):
                border, i = first[i], i + 1
            else:
                border, j = second[j], j + 1
            durations[row, column] = border - before
            middle = border - 0.5 * (border - before)
            while k < len(first) and middle > first[k]:
                k += 1
            while m < len(second) and middle > second[m]:
                m += 1
            for axis in range(3):
                jerk = one.jerks[row, k, axis] if k < len(first) else 0.0
                total.jerks[row, column, axis] = jerk + (other.jerks[row, m, axis] if m < len(second) else 0.0)


@kernel_part
def _integrate(path: int, segments: Segments, borders: Borders) -> bool:
    """Compute borders of a path from the first border on, as `lay_out`."""
    is_good = True
    times, position, velocity, acceleration = borders
    for k in range(segments.durations.shape[1]):
        d = segments.durations[path, k]
        is_good &= 0.0 <= d < math.inf
        times[path, k + 1] = times[path, k] + d
        for axis in range(3):
            jerk = segments.jerks[path, k, axis]
            is_good &= math.isfinite(jerk)
            p, v, a = position[path, k, axis], velocity[path, k, axis], acceleration[path, k, axis]
            acceleration[path, k + 1, axis] = a + d * jerk
            velocity[path, k + 1, axis] = v + d * (a + 0.5 * d * jerk)
            position[path, k + 1, axis] = p + d * (v + 0.5 * d * (a + d * jerk / 3.0))
    return is_good


@kernel
def lay_out(start: Start, segments: Segments, rides: bool, borders: Borders, table: Rows2[Knot]) -> bool:
    """Compute borders and tables of N paths of K segments; tell whether all values are finite, and durations positive.

    The tables (N, K + 2) have rest at both ends, or constant velocity if ``rides``.
    """
    is_good = True
    last = segments.durations.shape[1]
    times, position, velocity, acceleration = borders
    for path in range(len(start.position)):
        times[path, 0] = 0.0
        for axis in range(3):
            is_good &= math.isfinite(start.position[path, axis])
            position[path, 0, axis] = start.position[path, axis]
            velocity[path, 0, axis] = start.velocity[path, axis]
            acceleration[path, 0, axis] = start.acceleration[path, axis]
        is_good &= _integrate(path, segments, borders)
        for row in range(last + 2):
            k = max(row - 1, 0)
            knot = table[path, row]
            knot.time = times[path, k]
            is_inside = 0 < row <= last
            for axis in range(3):
                knot.position[axis] = position[path, k, axis]
                knot.velocity[axis] = velocity[path, k, axis] if is_inside or rides else 0.0
                knot.acceleration[axis] = acceleration[path, k, axis] if is_inside else 0.0
                knot.jerk[axis] = segments.jerks[path, k, axis] if is_inside else 0.0
    return is_good


@kernel_part
def _holds(table: Rows1[Knot], time: float, row: int) -> bool:
    """Whether a time lies after the border at which a row of a path's table begins."""
    return time > table[row].time if row == len(table) - 1 else time >= table[row].time


@kernel_part
def row_at(table: Rows1[Knot], time: float, row: int) -> int:
    """The row that holds at a time, searched for from a given row on."""
    while row < len(table) - 1 and _holds(table, time, row + 1):
        row += 1
    while row > 0 and not _holds(table, time, row):
        row -= 1
    return row


@kernel_part
def motion_in(knot: Knot, time: float, axis: int) -> tuple[float, float, float]:
    """Position, velocity and acceleration along an axis at a time, by the row of a table that holds."""
    t = time - knot.time
    p, v, a = knot.position[axis], knot.velocity[axis], knot.acceleration[axis]
    slope = t * knot.jerk[axis]
    return p + t * (v + 0.5 * t * (a + slope / 3.0)), v + t * (a + 0.5 * slope), a + slope


@kernel
def rows_at(table: Rows2[Knot], times: Floats2, rows: Ints2) -> None:
    """Write to `rows` (N, M) the rows of tables (N, R) that hold at times (N, M), or (1, M) for all paths [s].

    A border belongs to the segment after it, but the last border to the segment before it.
    """
    for path in range(len(table)):
        row = 0
        time = times[path % len(times)]
        for k in range(len(time)):
            row = row_at(table[path], time[k], row)
            rows[path, k] = row


@kernel
def sample(table: Rows2[Knot], times: Floats2, position: Floats3, velocity: Floats3, acceleration: Floats3) -> None:
    """Write the motions (N, M, 3) of N paths at times as of `rows_at`, from the paths' tables (N, R)."""
    for path in range(len(table)):
        row = 0
        time = times[path % len(times)]
        for k in range(len(time)):
            row = row_at(table[path], time[k], row)
            for axis in range(3):
                p, v, a = motion_in(table[path, row], time[k], axis)
                position[path, k, axis], velocity[path, k, axis], acceleration[path, k, axis] = p, v, a


@kernel_part
def _vector(numbers: Floats) -> tuple[float, float, float]:
    return numbers[0], numbers[1], numbers[2]


@kernel_part
def _limits(limits: LimitRows, row: int) -> tuple[float, float, float]:
    return limits.velocity[row], limits.acceleration[row], limits.jerk[row]


@kernel_part
def _stroke_phases(
    distance: float, limits: tuple[float, float, float], roots: tuple[float, float]
) -> tuple[float, float, float]:
    """Durations of ramp, plateau and cruise of a stroke, as `scurve.scurves`."""
    speed, peak = roots if is_short(distance, *limits) else long_peaks(distance, *limits)
    ramp, plateau = ramp_times(speed, peak, limits[2])
    cruise = max(distance / speed - 2.0 * ramp - plateau, 0.0) if speed > 0.0 else 0.0
    return ramp, plateau, cruise


@kernel_part
def _write_jerk(jerks: Floats, column: int, jerk: float, direction: tuple[float, float, float]) -> None:
    """Write the jerk of a segment along a direction."""
    for axis in range(3):
        jerks[column, axis] = jerk * direction[axis]


@kernel_part
def _write_move(
    durations: Floats,
    jerks: Floats,
    first: int,
    way: tuple[float, float, float],
    limits: tuple[float, float, float],
    roots: tuple[float, float],
) -> None:
    """Write the quickest move along a way as seven segments from a column on, as `scurve.rest_to_rest`."""
    distance = math.sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2])
    ramp, plateau, cruise = _stroke_phases(distance, limits, roots)
    divisor = distance if distance > 0.0 else 1.0
    direction = way[0] / divisor, way[1] / divisor, way[2] / divisor
    phases = (ramp, plateau, ramp, cruise, ramp, plateau, ramp)
    signs = (1.0, 0.0, -1.0, 0.0, -1.0, 0.0, 1.0)
    for k in range(MOVE):
        durations[first + k] = phases[k]
        _write_jerk(jerks, first + k, limits[2] * signs[k], direction)


@kernel
def write_throws(
    pick: Floats2,
    lines: Lines,
    limits: LimitRows,
    braking: Floats1,
    roots: Floats2,
    window: float,
    segments: Segments,
    ends: Ends,
) -> None:
    """Write the motions of N hands along lines: up to the release, on at constant velocity, and to a stop.

    Args:
        pick: first points (N, 3) [m].
        lines: the lines.
        limits: limits of the hands.
        braking: greatest accelerations of the braking (N,) [m/s2].
        roots: cube roots of strokes of twice the distances (2, N).
        window: time of constant velocity after the release [s].
        segments: written, 8 of each motion.
        ends: written, releases and stops.
    """
    for row in range(len(pick)):
        d, j, ahead = segments.durations[row], segments.jerks[row], _vector(lines.direction[row])
        jerk, top = limits.jerk[row], lines.speed[row]
        ramp, plateau, cruise = _stroke_phases(
            2.0 * lines.distance[row], _limits(limits, row), (roots[0, row], roots[1, row])
        )
        d[0], d[1], d[2], d[3], d[4] = ramp, plateau, ramp, cruise * 0.5, window
        ends.release_time[row] = d[0] + d[1] + d[2] + d[3]
        ramp, plateau = stop_times(top, braking[row], jerk)
        d[5], d[6], d[7] = ramp, plateau, ramp
        ends.stop_time[row] = ends.release_time[row] + window + (d[5] + d[6] + d[7])
        signs = (1.0, 0.0, -1.0, 0.0, 0.0, -1.0, 0.0, 1.0)
        for k in range(RUN_UP + STOPPING):
            _write_jerk(j, k, jerk * signs[k], ahead)
        run_out = window * top + 0.5 * top * (2.0 * ramp + plateau)
        for axis in range(3):
            ends.stop[row, axis] = pick[row, axis] + ahead[axis] * (lines.distance[row] + run_out)


@kernel
def write_returns(
    stop: Floats2, pick: Floats2, wait: Floats1, limits: LimitRows, roots: Floats3, clearance: float, back: Segments
) -> None:
    """Write the motions of N hands from rest to above picks, their waits there, and their descents.

    Args:
        stop: first points (N, 3) [m].
        pick: picks (N, 3) [m].
        wait: times at rest above the picks (N,) [s].
        limits: limits of the hands.
        roots: cube roots of the moves and of the descents (2, 2, N).
        clearance: height of the descents [m].
        back: written, 15 segments of each motion.
    """
    for row in range(len(stop)):
        rows, durations, jerks = _limits(limits, row), back.durations[row], back.jerks[row]
        x, y = pick[row, 0] - stop[row, 0], pick[row, 1] - stop[row, 1]
        way = x, y, pick[row, 2] + clearance - stop[row, 2]
        _write_move(durations, jerks, 0, way, rows, (roots[0, 0, row], roots[1, 0, row]))
        durations[MOVE] = wait[row]
        _write_jerk(jerks, MOVE, 0.0, way)
        down = 0.0, 0.0, -clearance
        _write_move(durations, jerks, MOVE + 1, down, rows, (roots[0, 1, row], roots[1, 1, row]))


@kernel
def fading_times(limits: LimitRows, speed: float, usual_speed: float, share: float, time: Floats1) -> None:
    """Write the durations (N,) of fadings under limits of N motions, as `riding.Fading.for_limits`."""
    for row in range(len(time)):
        velocity, acceleration, jerk = _limits(limits, row)
        least, growth = 2.0 * speed / (share * acceleration), acceleration / jerk
        longest = (velocity + speed) / acceleration + growth
        time[row] = min(longest, max((usual_speed + speed) / acceleration + growth, least))


@kernel
def reduce_limits(time: Floats1, speed: float, share: float, limits: LimitRows) -> None:
    """Reduce limits to those that fadings of durations (N,) leave; `share` is `riding.MOST_SHARE`."""
    least = 1.0 - share
    for row in range(len(time)):
        peak = 2.0 * speed / time[row]
        acceleration, jerk = limits.acceleration[row], limits.jerk[row]
        limits.acceleration[row] = max(acceleration - peak, least * acceleration)
        limits.jerk[row] = max(jerk - 2.0 * peak / time[row], least * jerk)


@kernel
def write_fading(time: Floats1, speed: float, sign: float, segments: Segments) -> None:
    """Write the growth (sign 1) or fading (-1) of a belt's speed in N durations, as the last two segments."""
    durations, jerks = segments
    last = durations.shape[1] - 1
    for row in range(len(time)):
        jerk = 4.0 * sign * speed / (time[row] * time[row])
        durations[row, last - 1] = durations[row, last] = 0.5 * time[row]
        jerks[row] = 0.0
        jerks[row, last - 1, 0], jerks[row, last, 0] = jerk, -jerk
