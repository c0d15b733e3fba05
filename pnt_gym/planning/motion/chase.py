"""Earliest time at which a hand meets a moving object. Compiled; see `pnt_gym.compiled`.

The hand moves from rest to rest to the point above the object's place at time t, then down: the hand is late at t when
both moves together take longer than t. Speeds, peaks and times of a stroke are those of `planning.motion.scurve`,
operation by operation.

Where a hand is late is known almost everywhere without trying. Let T(d) be the time of a stroke, D that of the descent,
d(t) the distance at t, and q the object's speed times the largest slope of T on the way. With q below 1 the lateness
T(d(t)) + D - t has one border r: lateness is at least (1 - q) (r - t) before r and at most -(1 - q) (t - r) after r. So
only times next to r, where rounding decides, are tried. The search visits the times that it would visit without this
knowledge, and gives the same bits.
"""

from __future__ import annotations

import math

import numpy as np

from pnt_gym.arrays import Bools, Floats
from pnt_gym.compiled import compile_for, kernel_part

# Samples of lateness after the object's closest approach, where lateness may begin and end several times.
SCAN = 96
# Halvings of a bracket; enough to reach rounding.
HALVINGS = 64
# Steps of the secant method for the border of lateness; five are usual.
STEPS = 12
# Greatest q with which the border is used.
STEEPEST = 0.5
# Bound of the rounding error of lateness, relative to the parts of lateness: some units in the last place.
ROUNDING = 32 * 2.220446049250313e-16
# Columns of `chases`: position of the object relative to the hand, raised by the clearance; the object's velocity; time
# of the hand's descent; limits of the hand; first and last allowed time, and the latest time that needs to be searched.
X, Y, Z, VX, VY, VZ, DESCENT, VELOCITY, ACCELERATION, JERK, FIRST, LAST, END = range(13)


@kernel_part
def _stroke_time(distance: float, velocity: float, acceleration: float, jerk: float) -> float:
    """Minimum time over a distance, as `scurve.stroke_time`."""
    square = acceleration * acceleration
    if jerk * jerk * distance <= 2.0 * acceleration * acceleration * acceleration and (
        jerk * distance * distance <= 4.0 * velocity * velocity * velocity
    ):
        speed, peak = np.cbrt(0.25 * jerk * distance * distance), np.cbrt(0.5 * jerk * jerk * distance)
    elif jerk * velocity <= square:
        speed, peak = velocity, math.sqrt(jerk * velocity)
    else:
        root = math.sqrt(square * square + 4.0 * jerk * jerk * distance * acceleration)
        speed, peak = min(2.0 * jerk * distance * acceleration / (square + root), velocity), acceleration
    if not speed > 0.0:
        return 0.0
    return distance / speed + (speed / peak + peak / jerk)


@kernel_part
def _stroke_slope(distance: float, velocity: float, acceleration: float, jerk: float) -> float:
    """Largest slope of the time of a stroke from a distance on [s/m]: there, or at the greatest speed."""
    # T' is 1 / (v + A^2 / 2 J) with a plateau of acceleration, 2 / (3 v) without; both fall with the distance.
    square = acceleration * acceleration
    root = math.sqrt(square * square + 4.0 * jerk * jerk * distance * acceleration)
    plateau = 1.0 / (2.0 * jerk * distance * acceleration / (square + root) + 0.5 * square / jerk)
    short = 2.0 / (3.0 * np.cbrt(0.25 * jerk * distance * distance))
    return max(plateau, short, 1.0 / velocity)


@kernel_part
def _arrival(chase: Floats, time: float) -> float:
    """Time at which the hand touches an object whose place is that at a time, if the hand sets off now."""
    x, y, z = chase[X] + time * chase[VX], chase[Y] + time * chase[VY], chase[Z] + time * chase[VZ]
    travel = _stroke_time(math.sqrt(x * x + y * y + z * z), chase[VELOCITY], chase[ACCELERATION], chase[JERK])
    return travel + chase[DESCENT]


@kernel_part
def _is_late(chase: Floats, time: float) -> bool:
    """Whether the hand would arrive after the given time."""
    return _arrival(chase, time) - time > 0.0


@kernel_part
def _border(chase: Floats, nearest: float, square: float) -> tuple[float, float]:
    """Border of lateness, and the time on either side of it within which lateness must be tried.

    The second number is infinite where the border is not known.
    """
    speed = math.sqrt(square)
    x, y, z = chase[X] + nearest * chase[VX], chase[Y] + nearest * chase[VY], chase[Z] + nearest * chase[VZ]
    slope = _stroke_slope(
        math.sqrt(x * x + y * y + z * z), chase[VELOCITY], chase[ACCELERATION], chase[JERK]
    )
    if not speed * slope < STEEPEST:
        return nearest, math.inf
    before, time = nearest, _arrival(chase, nearest)
    was = time - before
    size = 1.0 + slope * (abs(chase[X]) + abs(chase[Y]) + abs(chase[Z]))
    for _ in range(STEPS):
        late = _arrival(chase, time) - time
        rounding = ROUNDING * (size + (1.0 + slope * speed) * abs(time))
        if abs(late) <= 0.25 * rounding:
            return time, rounding / (1.0 - STEEPEST)
        if late == was:
            break
        before, time, was = time, time - late * (time - before) / (late - was), late
    return nearest, math.inf


@kernel_part
def _is_late_near(chase: Floats, time: float, border: float, margin: float) -> bool:
    """Whether the hand would arrive after the given time, tried only next to the border."""
    if abs(time - border) > margin:
        return time < border
    return _is_late(chase, time)


@kernel_part
def _border_time(chase: Floats, late: float, met: float, border: float, margin: float) -> float:
    """Border between late and met, by bisection: the end of the final bracket at which the hand is not late."""
    halvings, middle = HALVINGS, 0.5 * (late + met)
    while abs(middle - border) > margin and halvings > 0:
        is_late = middle < border
        late, met = (middle if is_late else late), (met if is_late else middle)
        middle, halvings = 0.5 * (late + met), halvings - 1
    for _ in range(halvings):
        middle = 0.5 * (late + met)
        if middle in (late, met):
            break
        if _is_late_near(chase, middle, border, margin):
            late = middle
        else:
            met = middle
    return met


@kernel_part
def _earliest_meeting(chase: Floats) -> float:
    """The first allowed time at which the hand is not late; NaN where there is none."""
    if not _is_late(chase, chase[FIRST]):
        return chase[FIRST]
    square = chase[VX] * chase[VX] + chase[VY] * chase[VY] + chase[VZ] * chase[VZ]
    along = chase[X] * chase[VX] + chase[Y] * chase[VY] + chase[Z] * chase[VZ]
    nearest = min(max(-along / (square if square > 0.0 else 1.0), chase[FIRST]), chase[LAST])
    border, margin = _border(chase, nearest, square)
    if not _is_late_near(chase, nearest, border, margin):
        return _border_time(chase, chase[FIRST], nearest, border, margin)
    end, before, first = max(nearest, min(chase[LAST], chase[END])), nearest, 1
    if not end > nearest:
        return math.nan
    if margin < math.inf:
        # Samples well before the border are late.
        share = (border - margin - nearest) / (end - nearest)
        first = min(max(int(SCAN * math.sqrt(min(max(share, 0.0), 1.0))) - 1, 1), SCAN + 1)
        if first > 1:
            share = (first - 1) / SCAN
            before = nearest + (end - nearest) * (share * share)
    for k in range(first, SCAN + 1):
        share = k / SCAN
        time = nearest + (end - nearest) * (share * share)
        if not _is_late_near(chase, time, border, margin):
            return _border_time(chase, before, time, border, margin)
        before = time
    return math.nan


@compile_for("void(float64[:,::1], float64[::1], boolean[::1])")
def earliest(chases: Floats, time: Floats, reached: Bools) -> None:
    """Write the first meetings of N chases to `time` and `reached` (N,).

    Args:
        chases: one chase per row (N, 13), by the columns above.
        time: time of the meeting; the first allowed time where there is no meeting.
        reached: whether there is a meeting.
    """
    for row in range(len(chases)):
        meeting = _earliest_meeting(chases[row])
        reached[row] = not math.isnan(meeting)
        time[row] = meeting if reached[row] else chases[row, FIRST]
