"""Paths of piecewise constant jerk: sums of motions, borders of segments, samples. Compiled; see `pnt_gym.compiled`."""

from __future__ import annotations

import math

import numpy as np

from pnt_gym.arrays import Floats, Ints
from pnt_gym.compiled import compile_for, kernel_part

# Columns of a table: position, velocity, acceleration and jerk from a border of two segments on, and the border's time.
# The first row holds before the first border and has the first border's time.
JERK, TIME, COLUMNS = 9, 12, 13


@compile_for(
    "void(f8[:, ::1], f8[:, :, ::1], f8[:, ::1], f8[:, :, ::1], f8[:, ::1], f8[:, :, ::1])",
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


@compile_for(
    "b1(f8[:, ::1], f8[:, ::1], f8[:, ::1], f8[:, ::1], f8[:, :, ::1], b1,f8[:, ::1], f8[:, :, :, ::1], f8[:, :, ::1])"
)
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
def _row_at(table: Floats, time: float, row: int) -> int:
    """The row that holds at a time, searched for from a given row on."""
    while row < len(table) - 1 and _holds(table, time, row + 1):
        row += 1
    while row > 0 and not _holds(table, time, row):
        row -= 1
    return row


@compile_for("void(float64[:,:,::1], float64[:,::1], int64[:,::1])")
def rows_at(table: Floats, times: Floats, rows: Ints) -> None:
    """Write to `rows` (N, M) the rows of tables (N, R, COLUMNS) that hold at times (N, M), or (1, M) for all paths [s].

    A border belongs to the segment after it, but the last border to the segment before it.
    """
    for path in range(len(table)):
        row = 0
        time = times[path % len(times)]
        for k in range(len(time)):
            row = _row_at(table[path], time[k], row)
            rows[path, k] = row


@compile_for("void(float64[:,:,::1], float64[:,::1], float64[:,:,::1], float64[:,:,::1], float64[:,:,::1])")
def sample(table: Floats, times: Floats, position: Floats, velocity: Floats, acceleration: Floats) -> None:
    """Write the motions (N, M, 3) of N paths at times as of `rows_at`, from the paths' tables (N, R, COLUMNS)."""
    for path in range(len(table)):
        row = 0
        time = times[path % len(times)]
        for k in range(len(time)):
            row = _row_at(table[path], time[k], row)
            at = table[path, row]
            t = time[k] - at[TIME]
            half = 0.5 * t
            for axis in range(3):
                p, v, a = at[axis], at[axis + 3], at[axis + 6]
                slope = t * at[axis + JERK]
                position[path, k, axis] = p + t * (v + half * (a + slope / 3.0))
                velocity[path, k, axis] = v + t * (a + 0.5 * slope)
                acceleration[path, k, axis] = a + slope
