"""Samples of paths of piecewise constant jerk at many times. Compiled; see `pnt_gym.compiled`."""

from __future__ import annotations

from pnt_gym.arrays import Floats, Ints
from pnt_gym.compiled import compile_for, kernel_part

# Columns of a table: position, velocity, acceleration and jerk from a border of two segments on, and the border's time.
# The first row holds before the first border and has the first border's time.
JERK, TIME, COLUMNS = 9, 12, 13


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
    """Write to `rows` (N, M) the rows of tables (N, R, COLUMNS) that hold at times (N, M) [s].

    A border belongs to the segment after it, but the last border to the segment before it.
    """
    for path in range(len(table)):
        row = 0
        for k in range(times.shape[1]):
            row = _row_at(table[path], times[path, k], row)
            rows[path, k] = row


@compile_for("void(float64[:,:,::1], float64[:,::1], float64[:,:,::1], float64[:,:,::1], float64[:,:,::1])")
def sample(table: Floats, times: Floats, position: Floats, velocity: Floats, acceleration: Floats) -> None:
    """Write the motions (N, M, 3) of N paths at times (N, M) [s], computed from the paths' tables (N, R, COLUMNS)."""
    for path in range(len(table)):
        row = 0
        for k in range(times.shape[1]):
            row = _row_at(table[path], times[path, k], row)
            at = table[path, row]
            t = times[path, k] - at[TIME]
            half = 0.5 * t
            for axis in range(3):
                p, v, a = at[axis], at[axis + 3], at[axis + 6]
                slope = t * at[axis + JERK]
                position[path, k, axis] = p + t * (v + half * (a + slope / 3.0))
                velocity[path, k, axis] = v + t * (a + 0.5 * slope)
                acceleration[path, k, axis] = a + slope
