"""Paths of piecewise constant jerk: motions along lines, sums, borders of segments, samples. Compiled; see `compiled`.

Motions along lines are those of `scurve` and `riding`, operation by operation. NumPy rounds cube roots in its own way,
so the cube roots of short strokes (`scurve.cube_roots`) are arguments.
"""

from __future__ import annotations

import math

import numpy as np

from pnt_gym.arrays import Floats, Ints
from pnt_gym.compiled import compile_for, kernel_part
from pnt_gym.planning.motion.strokes import is_short, long_peaks, ramp_times, stop_times

# Columns of a table: position, velocity, acceleration and jerk from a border of two segments on, and the border's time.
# The first row holds before the first border and has the first border's time.
JERK, TIME, COLUMNS = 9, 12, 13
# Numbers of segments: up to a release and half the cruise; window and braking; a move from rest to rest.
RUN_UP, STOPPING, MOVE = 4, 4, 7


@compile_for(
    "void(f8[:, :], f8[:, :, :], f8[:, :], f8[:, :, :], f8[:, ::1], f8[:, :, ::1])",
)
def add_motions(
    first_durations: Floats,
    first_jerks: Floats,
    second_durations: Floats,
    second_jerks: Floats,
    durations: Floats,
    jerks: Floats,
) -> None:
    """Write the sums of two motions of K and L segments as `durations` (N, K + L) and `jerks` (N, K + L, 3)."""
    for row in range(len(durations)):
        first, second = np.cumsum(first_durations[row]), np.cumsum(second_durations[row])
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
                jerk = first_jerks[row, k, axis] if k < len(first) else 0.0
                jerks[row, column, axis] = jerk + (second_jerks[row, m, axis] if m < len(second) else 0.0)


@kernel_part
def _integrate(path: int, durations: Floats, jerks: Floats, times: Floats, knots: Floats) -> bool:
    """Compute borders of a path from the first border on, as `lay_out`."""
    is_good = True
    for k in range(durations.shape[1]):
        d = durations[path, k]
        is_good &= 0.0 <= d < math.inf
        times[path, k + 1] = times[path, k] + d
        for axis in range(3):
            jerk = jerks[path, k, axis]
            is_good &= math.isfinite(jerk)
            p, v, a = knots[0, path, k, axis], knots[1, path, k, axis], knots[2, path, k, axis]
            knots[2, path, k + 1, axis] = a + d * jerk
            knots[1, path, k + 1, axis] = v + d * (a + 0.5 * d * jerk)
            knots[0, path, k + 1, axis] = p + d * (v + 0.5 * d * (a + d * jerk / 3.0))
    return is_good


@compile_for("b1(f8[:, :], f8[:, :], f8[:, :], f8[:, :], f8[:, :, :], b1, f8[:, ::1], f8[:, :, :, ::1], f8[:, :, ::1])")
def lay_out(
    start: Floats,
    start_velocity: Floats,
    start_acceleration: Floats,
    durations: Floats,
    jerks: Floats,
    rides: bool,
    times: Floats,
    knots: Floats,
    table: Floats,
) -> bool:
    """Compute borders and tables of N paths of K segments; tell whether all values are finite, and durations positive.

    Written are ``times`` (N, K + 1), the times of the borders; ``knots`` (3, N, K + 1, 3), position, velocity and
    acceleration there; and ``table`` (N, K + 2, COLUMNS), with rest at both ends, or constant velocity if ``rides``.
    """
    is_good = True
    last = durations.shape[1]
    for path in range(len(start)):
        times[path, 0] = 0.0
        for axis in range(3):
            is_good &= math.isfinite(start[path, axis])
            knots[0, path, 0, axis] = start[path, axis]
            knots[1, path, 0, axis] = start_velocity[path, axis]
            knots[2, path, 0, axis] = start_acceleration[path, axis]
        is_good &= _integrate(path, durations, jerks, times, knots)
        for row in range(last + 2):
            k = max(row - 1, 0)
            table[path, row, TIME] = times[path, k]
            is_inside = 0 < row <= last
            for axis in range(3):
                table[path, row, axis] = knots[0, path, k, axis]
                table[path, row, 3 + axis] = knots[1, path, k, axis] if is_inside or rides else 0.0
                table[path, row, 6 + axis] = knots[2, path, k, axis] if is_inside else 0.0
                table[path, row, JERK + axis] = jerks[path, k, axis] if is_inside else 0.0
    return is_good


@kernel_part
def _holds(table: Floats, time: float, row: int) -> bool:
    """Whether a time lies after the border at which a row of a path's table (R, COLUMNS) begins."""
    return time > table[row, TIME] if row == len(table) - 1 else time >= table[row, TIME]


@kernel_part
def row_at(table: Floats, time: float, row: int) -> int:
    """The row that holds at a time, searched for from a given row on."""
    while row < len(table) - 1 and _holds(table, time, row + 1):
        row += 1
    while row > 0 and not _holds(table, time, row):
        row -= 1
    return row


@kernel_part
def motion_in(at: Floats, time: float, axis: int) -> tuple[float, float, float]:
    """Position, velocity and acceleration along an axis at a time, by the row of a table that holds (COLUMNS,)."""
    t = time - at[TIME]
    p, v, a = at[axis], at[axis + 3], at[axis + 6]
    slope = t * at[axis + JERK]
    return p + t * (v + 0.5 * t * (a + slope / 3.0)), v + t * (a + 0.5 * slope), a + slope


@compile_for("void(float64[:,:,::1], float64[:,::1], int64[:,::1])")
def rows_at(table: Floats, times: Floats, rows: Ints) -> None:
    """Write to `rows` (N, M) the rows of tables (N, R, COLUMNS) that hold at times (N, M), or (1, M) for all paths [s].

    A border belongs to the segment after it, but the last border to the segment before it.
    """
    for path in range(len(table)):
        row = 0
        time = times[path % len(times)]
        for k in range(len(time)):
            row = row_at(table[path], time[k], row)
            rows[path, k] = row


@compile_for("void(float64[:,:,::1], float64[:,::1], float64[:,:,::1], float64[:,:,::1], float64[:,:,::1])")
def sample(table: Floats, times: Floats, position: Floats, velocity: Floats, acceleration: Floats) -> None:
    """Write the motions (N, M, 3) of N paths at times as of `rows_at`, from the paths' tables (N, R, COLUMNS)."""
    for path in range(len(table)):
        row = 0
        time = times[path % len(times)]
        for k in range(len(time)):
            row = row_at(table[path], time[k], row)
            for axis in range(3):
                p, v, a = motion_in(table[path, row], time[k], axis)
                position[path, k, axis], velocity[path, k, axis], acceleration[path, k, axis] = p, v, a


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


@compile_for(
    "void(f8[:, :], f8[:, :], f8[:], f8[:], f8[:, ::1], f8[::1], f8[:, ::1], f8, f8[:, ::1], f8[:, :, ::1],"
    "f8[:, ::1], f8[:, ::1])"
)
def write_throws(
    pick: Floats,
    direction: Floats,
    distance: Floats,
    speed: Floats,
    limits: Floats,
    braking: Floats,
    roots: Floats,
    window: float,
    durations: Floats,
    jerks: Floats,
    times: Floats,
    stop: Floats,
) -> None:
    """Write the motions of N hands along lines: up to the release, on at constant velocity, and to a stop.

    Args:
        pick: first points (N, 3) [m].
        direction: unit vectors of the lines (N, 3).
        distance: ways to the releases (N,) [m].
        speed: speeds at the releases (N,) [m/s].
        limits: limits of the hands (3, N).
        braking: greatest accelerations of the braking (N,) [m/s2].
        roots: cube roots of strokes of twice the distances (2, N).
        window: time of constant velocity after the release [s].
        durations: written (N, 8) [s].
        jerks: written (N, 8, 3) [m/s3].
        times: written, times of the releases and of the stops (2, N) [s].
        stop: written, points of the stops (N, 3) [m].
    """
    for row in range(len(pick)):
        d, j = durations[row], jerks[row]
        ahead = direction[row, 0], direction[row, 1], direction[row, 2]
        rows, jerk = (limits[0, row], limits[1, row], limits[2, row]), limits[2, row]
        ramp, plateau, cruise = _stroke_phases(2.0 * distance[row], rows, (roots[0, row], roots[1, row]))
        d[0], d[1], d[2], d[3], d[4] = ramp, plateau, ramp, cruise * 0.5, window
        times[0, row] = d[0] + d[1] + d[2] + d[3]
        top = speed[row]
        ramp, plateau = stop_times(top, braking[row], jerk)
        d[5], d[6], d[7] = ramp, plateau, ramp
        times[1, row] = times[0, row] + window + (d[5] + d[6] + d[7])
        signs = (1.0, 0.0, -1.0, 0.0, 0.0, -1.0, 0.0, 1.0)
        for k in range(RUN_UP + STOPPING):
            _write_jerk(j, k, jerk * signs[k], ahead)
        run_out = window * top + 0.5 * top * (2.0 * ramp + plateau)
        for axis in range(3):
            stop[row, axis] = pick[row, axis] + ahead[axis] * (distance[row] + run_out)


@compile_for("void(f8[:, :], f8[:, :], f8[:], f8[:, ::1], f8[:, :, ::1], f8, f8[:, ::1], f8[:, :, ::1])")
def write_returns(
    stop: Floats,
    pick: Floats,
    wait: Floats,
    limits: Floats,
    roots: Floats,
    clearance: float,
    durations: Floats,
    jerks: Floats,
) -> None:
    """Write the motions of N hands from rest to above picks, their waits there, and their descents.

    Args:
        stop: first points (N, 3) [m].
        pick: picks (N, 3) [m].
        wait: times at rest above the picks (N,) [s].
        limits: limits of the hands (3, N).
        roots: cube roots of the moves and of the descents (2, 2, N).
        clearance: height of the descents [m].
        durations: written (N, 15) [s].
        jerks: written (N, 15, 3) [m/s3].
    """
    for row in range(len(stop)):
        rows = limits[0, row], limits[1, row], limits[2, row]
        x, y = pick[row, 0] - stop[row, 0], pick[row, 1] - stop[row, 1]
        way = x, y, pick[row, 2] + clearance - stop[row, 2]
        _write_move(durations[row], jerks[row], 0, way, rows, (roots[0, 0, row], roots[1, 0, row]))
        durations[row, MOVE] = wait[row]
        _write_jerk(jerks[row], MOVE, 0.0, way)
        down = 0.0, 0.0, -clearance
        _write_move(durations[row], jerks[row], MOVE + 1, down, rows, (roots[0, 1, row], roots[1, 1, row]))


@compile_for("void(f8[:], f8[:], f8[:], f8, f8, f8, f8[::1])")
def fading_times(
    velocity: Floats, acceleration: Floats, jerk: Floats, speed: float, usual_speed: float, share: float, time: Floats
) -> None:
    """Write the durations (N,) of fadings under limits (N,) each, as `riding.Fading.for_limits`."""
    for row in range(len(time)):
        least, growth = 2.0 * speed / (share * acceleration[row]), acceleration[row] / jerk[row]
        longest = (velocity[row] + speed) / acceleration[row] + growth
        time[row] = min(longest, max((usual_speed + speed) / acceleration[row] + growth, least))


@compile_for("void(f8[::1], f8, f8, f8[:, ::1])")
def reduce_limits(time: Floats, speed: float, share: float, limits: Floats) -> None:
    """Reduce limits (3, N) to those that fadings of durations (N,) leave; `share` is `riding.MOST_SHARE`."""
    least = 1.0 - share
    for row in range(len(time)):
        peak = 2.0 * speed / time[row]
        limits[1, row] = max(limits[1, row] - peak, least * limits[1, row])
        limits[2, row] = max(limits[2, row] - 2.0 * peak / time[row], least * limits[2, row])


@compile_for("void(f8[::1], f8, f8, f8[:, ::1], f8[:, :, ::1])")
def write_fading(time: Floats, speed: float, sign: float, durations: Floats, jerks: Floats) -> None:
    """Write the growth (sign 1) or fading (-1) of a belt's speed in N durations, as the last two segments."""
    last = durations.shape[1] - 1
    for row in range(len(time)):
        jerk = 4.0 * sign * speed / (time[row] * time[row])
        durations[row, last - 1] = durations[row, last] = 0.5 * time[row]
        jerks[row] = 0.0
        jerks[row, last - 1, 0], jerks[row, last, 0] = jerk, -jerk
