"""Meetings of hands with objects on a belt: where an object may be picked, and when. Compiled.

`chase` finds the time of a meeting; this module says which times are allowed and what follows from the meeting.
"""

from __future__ import annotations

import math

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.compiled import kernel, kernel_part
from pnt_gym.planning.motion.chase import (
    ACCELERATION,
    CHASE_COLUMNS,
    DESCENT,
    END,
    FIRST,
    JERK,
    LAST,
    VELOCITY,
    VX,
    VY,
    VZ,
    X,
    Y,
    Z,
    search,
    search_end,
)
from pnt_gym.planning.motion.strokes import stroke_time
from pnt_gym.planning.reasons import InterceptReason
from pnt_gym.rows import Floats2, Ints1

# Rows of `hunts` (16, N): hand, object, the object's velocity, clearance, limits of the hand, window along the axis,
# and time before which the object may not be picked.
HAND, PLACE, BELT, LIFT, LIMITS, LOW, HIGH, NOT_BEFORE = 0, 3, 6, 9, 10, 13, 14, 15
IS_MET, PASSED, NEVER_ENTERS, TOO_LATE = map(int, InterceptReason)


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
    """Write the numbers of a chase, except for its allowed times."""
    for k in range(3):
        chase[X + k], chase[VX + k] = hunts[PLACE + k, row] - hunts[HAND + k, row], hunts[BELT + k, row]
        chase[VELOCITY + k] = hunts[LIMITS + k, row]
    chase[Z] += hunts[LIFT, row]
    velocity, acceleration, jerk = chase[VELOCITY], chase[ACCELERATION], chase[JERK]
    chase[DESCENT] = stroke_time(hunts[LIFT, row], velocity, acceleration, jerk)
    offset = math.sqrt(chase[X] * chase[X] + chase[Y] * chase[Y] + chase[Z] * chase[Z])
    speed = math.sqrt(chase[VX] * chase[VX] + chase[VY] * chase[VY] + chase[VZ] * chase[VZ])
    chase[END] = search_end(offset, speed, (velocity, acceleration, jerk), chase[DESCENT])


@kernel_part
def _write_meeting(hunts: Floats, row: int, chase: Floats, time: float, numbers: Floats) -> None:
    """Write the numbers of a meeting, as `meet`."""
    x, y, z = chase[X] + time * chase[VX], chase[Y] + time * chase[VY], chase[Z] + time * chase[VZ]
    travel = stroke_time(math.sqrt(x * x + y * y + z * z), chase[VELOCITY], chase[ACCELERATION], chase[JERK])
    numbers[0, row] = time
    for k in range(3):
        numbers[1 + k, row] = hunts[PLACE + k, row] + time * hunts[BELT + k, row]
    numbers[4, row] = 0.0 if time > chase[FIRST] else max(time - travel - chase[DESCENT], 0.0)
    numbers[5, row], numbers[6, row] = travel, chase[DESCENT]


@kernel
def meet(hunts: Floats2, axis: int, horizon: float, numbers: Floats2, reasons: Ints1) -> None:
    """Find the first meetings of N hands with objects.

    Args:
        hunts: hands and objects (16, N), by the rows above.
        axis: coordinate that the windows bound.
        horizon: latest time that is searched [s].
        numbers: result (7, N): time, position, wait, travel and descent of each meeting; NaN without a meeting.
        reasons: result (N,): `InterceptReason` of each object.
    """
    chases, rows, count = np.empty((hunts.shape[1], CHASE_COLUMNS)), np.empty(hunts.shape[1], dtype=np.int64), 0
    for row in range(hunts.shape[1]):
        numbers[:, row] = math.nan
        enter, leave = _allowed_times(hunts, row, axis)
        first, last = max(enter, hunts[NOT_BEFORE, row], 0.0), min(leave, horizon)
        reasons[row] = NEVER_ENTERS if first > horizon else PASSED if first > last else TOO_LATE
        if reasons[row] == TOO_LATE:
            _set_up(hunts, row, chases[count])
            chases[count, FIRST], chases[count, LAST], rows[count] = first, last, row
            count += 1
    times = np.empty(count)
    search(chases[:count], times)
    for k in range(count):
        if not math.isnan(times[k]):
            reasons[rows[k]] = IS_MET
            _write_meeting(hunts, rows[k], chases[k], times[k], numbers)
