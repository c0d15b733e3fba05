"""Earliest time at which a hand meets a moving object. Compiled; see `pnt_gym.compiled`.

The hand moves from rest to rest to the point above the object's place at time t, then down: the hand is late at t when
both moves together take longer than t. Speeds, peaks and times of a stroke are those of `planning.motion.scurve`,
operation by operation.
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
def _is_late(chase: Floats, time: float) -> bool:
    """Whether the hand would arrive after the given time."""
    x, y, z = chase[X] + time * chase[VX], chase[Y] + time * chase[VY], chase[Z] + time * chase[VZ]
    travel = _stroke_time(math.sqrt(x * x + y * y + z * z), chase[VELOCITY], chase[ACCELERATION], chase[JERK])
    return travel + chase[DESCENT] - time > 0.0


@kernel_part
def _border_time(chase: Floats, late: float, met: float) -> float:
    """Border between late and met, by bisection: the end of the final bracket at which the hand is not late."""
    for _ in range(HALVINGS):
        middle = 0.5 * (late + met)
        if middle in (late, met):
            break
        if _is_late(chase, middle):
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
    if not _is_late(chase, nearest):
        return _border_time(chase, chase[FIRST], nearest)
    end, before = max(nearest, min(chase[LAST], chase[END])), nearest
    for k in range(1, SCAN + 1):
        share = k / SCAN
        time = nearest + (end - nearest) * (share * share)
        if not _is_late(chase, time):
            return _border_time(chase, before, time)
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
