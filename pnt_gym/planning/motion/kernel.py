"""Motions of constant jerk in pieces, N at a time: strokes, stops, sums, borders, samples; falls and margins.

Compiled; see `pnt_gym.compiled`. The formulas of one stroke, stop or fading are those of `strokes`.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.compiled import empty_rows, kernel, kernel_part
from pnt_gym.planning.motion.limits import LimitRows, Space
from pnt_gym.planning.motion.rows import Borders, Fading, Knot, Segments, Start, Stroke
from pnt_gym.planning.motion.strokes import (
    fading_time,
    least_fading,
    limits_beside,
    ramp_distance,
    stop_phases,
    stroke_phases,
    time_to_fall,
)
from pnt_gym.rows import Floats1, Floats2, Floats3, Ints2, Rows1, Rows2

RUN_UP, STOP, MOVE = 4, 3, 7
"""Numbers of segments: up to a release and half the cruise; of a stop; of a move from rest to rest."""
STROKE = Stroke.dtype


@kernel_part
def new_segments(count: int, columns: int) -> Segments:
    """Segments of N motions whose values are arbitrary."""
    return Segments(np.empty((count, columns)), np.empty((count, columns, 3)))


@kernel
def superpose(first: Segments, second: Segments) -> Segments:
    """Return the sums of N motions that begin together; a motion that is over goes on without jerk.

    Each sum has the borders of both motions, so K and L segments give K + L segments.
    """
    count, columns = first.durations.shape[0], first.durations.shape[1] + second.durations.shape[1]
    total = new_segments(count, columns)
    for row in range(count):
        ends, others = np.cumsum(first.durations[row]), np.cumsum(second.durations[row])
        # Numbers of borders so far, and indices of the segments that hold in the middle between two borders.
        i, j, k, m = 0, 0, 0, 0
        border = 0.0
        for column in range(columns):
            before = border
            if j == len(others) or (i < len(ends) and ends[i] <= others[j]):
                border, i = ends[i], i + 1
            else:
                border, j = others[j], j + 1
            total.durations[row, column] = border - before
            middle = border - 0.5 * (border - before)
            while k < len(ends) and middle > ends[k]:
                k += 1
            while m < len(others) and middle > others[m]:
                m += 1
            for axis in range(3):
                jerk = first.jerks[row, k, axis] if k < len(ends) else 0.0
                total.jerks[row, column, axis] = jerk + (second.jerks[row, m, axis] if m < len(others) else 0.0)
    return total


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
def write_run_up(segments: Segments, row: int, first: int, ahead: Floats, distance: float, limits: LimitRows) -> float:
    """Write the first half of a stroke of twice a distance, from a column on; returns its duration.

    This is the throw motion up to the release (section III-D): jerk up, plateau, jerk down, half the cruise.
    """
    velocity, acceleration, jerk = limits.velocity[row], limits.acceleration[row], limits.jerk[row]
    _, _, ramp, plateau, cruise = stroke_phases(2.0 * distance, velocity, acceleration, jerk)
    _write_phases(segments, row, first, (ramp, plateau, ramp, 0.5 * cruise), (jerk, 0.0, -jerk, 0.0), ahead)
    return ramp + plateau + ramp + 0.5 * cruise


@kernel_part
def write_stop(
    segments: Segments, row: int, first: int, ahead: Floats, speed: float, acceleration: float, jerk: float
) -> float:
    """Write the quickest stop from a speed, from a column on; returns its duration."""
    ramp, plateau = stop_phases(speed, acceleration, jerk)
    _write_phases(segments, row, first, (ramp, plateau, ramp), (-jerk, 0.0, jerk), ahead)
    return ramp + plateau + ramp


@kernel_part
def _write_move(segments: Segments, row: int, first: int, way: tuple[float, float, float], limits: LimitRows) -> None:
    """Write the quickest move along a way, from a column on."""
    velocity, acceleration, jerk = limits.velocity[row], limits.acceleration[row], limits.jerk[row]
    distance = math.sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2])
    _, _, ramp, plateau, cruise = stroke_phases(distance, velocity, acceleration, jerk)
    divisor = distance if distance > 0.0 else 1.0
    phases, jerks = (ramp, plateau, ramp, cruise, ramp, plateau, ramp), (jerk, 0.0, -jerk, 0.0, -jerk, 0.0, jerk)
    _write_phases(segments, row, first, phases, jerks, (way[0] / divisor, way[1] / divisor, way[2] / divisor))


@kernel_part
def _write_phases(segments: Segments, row: int, first: int, phases: Any, jerks: Any, ahead: Any) -> None:
    """Write segments along a direction, from a column on."""
    for k in range(len(phases)):
        segments.durations[row, first + k] = phases[k]
        for axis in range(3):
            segments.jerks[row, first + k, axis] = jerks[k] * ahead[axis]


@kernel
def accelerate(direction: Floats2, distance: Floats1, limits: LimitRows) -> Segments:
    """Compute first halves of strokes along unit vectors (N, 3) over distances (N,) [m]."""
    segments = new_segments(len(distance), RUN_UP)
    for row in range(len(distance)):
        write_run_up(segments, row, 0, direction[row], distance[row], limits)
    return segments


@kernel
def brake(direction: Floats2, speed: Floats1, limits: LimitRows) -> Segments:
    """Compute the quickest stops along unit vectors (N, 3) from speeds (N,) [m/s]."""
    segments = new_segments(len(speed), STOP)
    for row in range(len(speed)):
        write_stop(segments, row, 0, direction[row], speed[row], limits.acceleration[row], limits.jerk[row])
    return segments


@kernel
def brake_distance(speed: Floats1, limits: LimitRows) -> Floats1:
    """Compute the ways of the quickest stops (N,) [m] from speeds (N,) [m/s]."""
    way = np.empty(len(speed))
    for row in range(len(way)):
        way[row] = ramp_distance(speed[row], limits.acceleration[row], limits.jerk[row])
    return way


@kernel
def rest_to_rest(way: Floats2, limits: LimitRows) -> Segments:
    """Compute the quickest moves along ways (N, 3) [m]."""
    segments = new_segments(len(way), MOVE)
    for row in range(len(way)):
        _write_move(segments, row, 0, (way[row, 0], way[row, 1], way[row, 2]), limits)
    return segments


@kernel
def go_back(stop: Floats2, pick: Floats2, wait: Floats1, limits: LimitRows, clearance: float) -> Segments:
    """Compute motions from rest at points (N, 3) to rest above picks (N, 3), waits there (N,) [s], and descents [m]."""
    segments = new_segments(len(stop), MOVE + 1 + MOVE)
    for row in range(len(stop)):
        x, y = pick[row, 0] - stop[row, 0], pick[row, 1] - stop[row, 1]
        _write_move(segments, row, 0, (x, y, pick[row, 2] + clearance - stop[row, 2]), limits)
        segments.durations[row, MOVE], segments.jerks[row, MOVE] = wait[row], 0.0
        _write_move(segments, row, MOVE + 1, (0.0, 0.0, -clearance), limits)
    return segments


@kernel
def strokes(distance: Floats1, limits: LimitRows) -> Rows1[Stroke]:
    """Compute the quickest motions over distances (N,) [m]."""
    rows = empty_rows(len(distance), STROKE)
    for k in range(len(rows)):
        row, velocity, acceleration, jerk = rows[k], limits.velocity[k], limits.acceleration[k], limits.jerk[k]
        speed, peak, ramp, plateau, cruise = stroke_phases(distance[k], velocity, acceleration, jerk)
        row.speed, row.acceleration, row.ramp, row.plateau, row.cruise = speed, peak, ramp, plateau, cruise
        row.time = 4.0 * ramp + 2.0 * plateau + cruise
    return rows


@kernel
def fade(limits: LimitRows, speed: float, time: float) -> Fading:
    """Compute the fadings of a belt's speed from N hands with limits, in a time [s]; 0 where the limits decide."""
    count = len(limits.velocity)
    acceleration, jerk, lead = np.empty(count), np.empty(count), np.zeros((count, 3))
    fading = Fading(
        np.empty(count), lead, np.empty(count, dtype=np.bool_), LimitRows(limits.velocity, acceleration, jerk)
    )
    for row in range(count):
        velocity, peak, sharpest = limits.velocity[row], limits.acceleration[row], limits.jerk[row]
        duration = time if time > 0.0 else fading_time(speed, velocity, peak, sharpest)
        fading.time[row], lead[row, 0] = duration, speed * duration / 2.0
        fading.is_possible[row] = duration >= least_fading(speed, peak)
        acceleration[row], jerk[row] = limits_beside(duration, speed, peak, sharpest)
    return fading


@kernel
def grow(time: Floats1, speed: float, columns: int) -> Segments:
    """Compute the growths of a belt's speed (negative: the fadings) in N durations, as the last two segments."""
    segments = new_segments(len(time), columns)
    for row in range(len(time)):
        jerk = 4.0 * speed / (time[row] * time[row])
        phases, jerks = (0.5 * time[row], 0.5 * time[row]), (jerk, -jerk)
        segments.durations[row], segments.jerks[row] = 0.0, 0.0
        _write_phases(segments, row, columns - 2, phases, jerks, (1.0, 0.0, 0.0))
    return segments


@kernel
def times_to_fall(drop: Floats1, rise: Floats1) -> Floats1:
    """Compute the times (N,) [s] until objects come down by heights (N,) [m] after releases with speeds (N,) [m/s]."""
    time = np.empty(len(drop))
    for row in range(len(time)):
        time[row] = time_to_fall(drop[row], rise[row])
    return time


@kernel_part
def space_margin(x: float, y: float, z: float, space: Space) -> float:
    """Distance of a point to the border of a workspace [m], as `EllipticWorkspace.margin` explains; NaN gives NaN."""
    if math.isnan(x + y + z):
        return math.nan
    x, y = x - space.x, y - space.y
    east, north = x / space.semi_x, y / space.semi_y
    sideways = (1.0 - math.sqrt(east * east + north * north)) * min(space.semi_x, space.semi_y)
    if space.hole > 0.0:
        sideways = min(sideways, math.sqrt(x * x + y * y) - space.hole)
    return min(sideways, z - space.z_min, space.z_max - z)


@kernel_part
def passes_hole(x: float, y: float, end_x: float, end_y: float, space: Space) -> bool:
    """Whether a straight way passes beside the hole of a workspace."""
    if space.hole <= 0.0:
        return True
    x, y, way_x, way_y = x - space.x, y - space.y, end_x - x, end_y - y
    length = way_x * way_x + way_y * way_y
    # The way's point that is nearest to the middle of the hole.
    share = min(max(-(x * way_x + y * way_y) / length, 0.0), 1.0) if length > 0.0 else 0.0
    near_x, near_y = x + share * way_x, y + share * way_y
    return near_x * near_x + near_y * near_y >= space.hole * space.hole


@kernel
def margins(points: Floats2, space: Space) -> Floats1:
    """Compute the distances of points (N, 3) to the border of a workspace (N,) [m]."""
    margin = np.empty(len(points))
    for row in range(len(margin)):
        margin[row] = space_margin(points[row, 0], points[row, 1], points[row, 2], space)
    return margin
