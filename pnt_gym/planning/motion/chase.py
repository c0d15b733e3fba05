"""Earliest time at which a hand meets a moving object. Compiled; see `pnt_gym.compiled`.

The hand moves from rest to rest to the point above the object's place at time t, then down: the hand is late at t when
both moves together take longer than t. Speeds, peaks and times of a stroke are those of `planning.motion.scurve`,
operation by operation.
"""

from __future__ import annotations

import math

import numpy as np

from pnt_gym.arrays import Floats, Ints
from pnt_gym.compiled import compile_for, kernel_part
from pnt_gym.planning.motion.intercept import InterceptReason

# Samples of lateness after the object's closest approach, where lateness may begin and end several times.
SCAN = 96
# Halvings of a bracket; enough to reach rounding.
HALVINGS = 64
# Numbers of a chase: position of the object relative to the hand, raised by the clearance; the object's velocity; time
# of the hand's descent; limits of the hand; first and last allowed time, and the latest time that needs to be searched.
X, Y, Z, VX, VY, VZ, DESCENT, VELOCITY, ACCELERATION, JERK, FIRST, LAST, END = range(13)
# Rows of `hunts` (16, N): hand, object, the object's velocity, clearance, limits of the hand, window along the axis,
# and time before which the object may not be picked.
HAND, PLACE, BELT, LIFT, LIMITS, LOW, HIGH, NOT_BEFORE = 0, 3, 6, 9, 10, 13, 14, 15
MET, PASSED, NEVER_ENTERS, TOO_LATE = map(int, InterceptReason)


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


@kernel_part
def _allowed_times(hunts: Floats, row: int, axis: int) -> tuple[float, float]:
    """Times at which an object enters and leaves its window; infinite for an object that never enters."""
    place, speed = hunts[PLACE + axis, row], hunts[BELT + axis, row]
    low, high = hunts[LOW, row], hunts[HIGH, row]
    if speed == 0.0:
        return -math.inf if low <= place <= high else math.inf, math.inf
    at_low, at_high = (low - place) / speed, (high - place) / speed
    return min(at_low, at_high), max(at_low, at_high)


@kernel_part
def _set_up(hunts: Floats, row: int, chase: Floats) -> None:
    """Write the numbers of a chase, except for its allowed times.

    A hand catches a slower object: T(d) <= d / V + 2 (V / A + A / J) for every d, and the object is never farther away
    than |offset| + speed t.
    """
    for k in range(3):
        chase[X + k], chase[VX + k] = hunts[PLACE + k, row] - hunts[HAND + k, row], hunts[BELT + k, row]
        chase[VELOCITY + k] = hunts[LIMITS + k, row]
    chase[Z] += hunts[LIFT, row]
    velocity, acceleration, jerk = chase[VELOCITY], chase[ACCELERATION], chase[JERK]
    chase[DESCENT] = _stroke_time(hunts[LIFT, row], velocity, acceleration, jerk)
    offset = math.sqrt(chase[X] * chase[X] + chase[Y] * chase[Y] + chase[Z] * chase[Z])
    speed = math.sqrt(chase[VX] * chase[VX] + chase[VY] * chase[VY] + chase[VZ] * chase[VZ])
    peak = min(math.sqrt(jerk * velocity), acceleration)
    latest = offset / velocity + 2.0 * (velocity / peak + peak / jerk) + chase[DESCENT]
    chase[END] = 1.001 * latest / (1.0 - speed / velocity) if speed < velocity else math.inf


@compile_for("void(float64[:, ::1], int64, float64, float64[:, ::1], int64[::1])")
def meet(hunts: Floats, axis: int, horizon: float, numbers: Floats, reasons: Ints) -> None:
    """Find the first meetings of N hands with objects.

    Args:
        hunts: hands and objects (16, N), by the rows above.
        axis: coordinate that the windows bound.
        horizon: latest time that is searched [s].
        numbers: result (7, N): time, position, wait, travel and descent of each meeting; NaN without a meeting.
        reasons: result (N,): `InterceptReason` of each object.
    """
    chase = np.empty(13)
    for row in range(hunts.shape[1]):
        _set_up(hunts, row, chase)
        enter, leave = _allowed_times(hunts, row, axis)
        first, last = max(enter, hunts[NOT_BEFORE, row], 0.0), min(leave, horizon)
        numbers[:, row] = math.nan
        if first > horizon:
            reasons[row] = NEVER_ENTERS
            continue
        if first > last:
            reasons[row] = PASSED
            continue
        chase[FIRST], chase[LAST] = first, last
        time = _earliest_meeting(chase)
        if math.isnan(time):
            reasons[row] = TOO_LATE
            continue
        x, y, z = chase[X] + time * chase[VX], chase[Y] + time * chase[VY], chase[Z] + time * chase[VZ]
        travel = _stroke_time(math.sqrt(x * x + y * y + z * z), chase[VELOCITY], chase[ACCELERATION], chase[JERK])
        reasons[row], numbers[0, row] = MET, time
        for k in range(3):
            numbers[1 + k, row] = hunts[PLACE + k, row] + time * hunts[BELT + k, row]
        numbers[4, row] = 0.0 if time > first else max(time - travel - chase[DESCENT], 0.0)
        numbers[5, row], numbers[6, row] = travel, chase[DESCENT]
