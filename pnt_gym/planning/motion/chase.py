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

from pnt_gym.arrays import Floats, Ints
from pnt_gym.compiled import kernel, kernel_part
from pnt_gym.planning.motion.strokes import is_short, stroke_time
from pnt_gym.rows import Bools1, Floats1, Floats2

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
# Late hands are searched for in blocks of so many lanes, whose loops become vector instructions. A block holds numbers
# of its lanes line by line: first the columns of `chases` before `FIRST`, then those named below.
WIDTH = 32
# Halvings that are surely needed of most brackets before rounding decides.
SURE_HALVINGS = 40
# Columns of `chases`: position of the object relative to the hand, raised by the clearance; the object's velocity; time
# of the hand's descent; limits of the hand; first and last allowed time, and the latest time that needs to be searched.
X, Y, Z, VX, VY, VZ, DESCENT, VELOCITY, ACCELERATION, JERK, FIRST, LAST, END = range(13)
CHASE_COLUMNS = 13
# Lines of a block: size of the lateness and its growth with the time, for the rounding; time before and lateness then,
# border and margin of the secant method; bracket of the bisection and number of its halvings; time at which the object
# is closest.
SIZE, GROWTH, BEFORE, LATENESS, BORDER, MARGIN, LATE, MET, HALVED, NEAREST = range(10, 20)
LINES = 20


@kernel_part
def _arrival(chase: Floats, time: float) -> float:
    """Time at which the hand touches an object whose place is that at a time, if the hand sets off now."""
    x, y, z = chase[X] + time * chase[VX], chase[Y] + time * chase[VY], chase[Z] + time * chase[VZ]
    travel = stroke_time(math.sqrt(x * x + y * y + z * z), chase[VELOCITY], chase[ACCELERATION], chase[JERK])
    return travel + chase[DESCENT]


@kernel_part
def _is_late(chase: Floats, time: float) -> bool:
    """Whether the hand would arrive after the given time."""
    return _arrival(chase, time) - time > 0.0


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
def _nearest(chase: Floats) -> float:
    """Allowed time at which the object is closest to the hand."""
    square = chase[VX] * chase[VX] + chase[VY] * chase[VY] + chase[VZ] * chase[VZ]
    along = chase[X] * chase[VX] + chase[Y] * chase[VY] + chase[Z] * chase[VZ]
    return min(max(-along / (square if square > 0.0 else 1.0), chase[FIRST]), chase[LAST])


@kernel_part
def _later_meeting(chase: Floats) -> float:
    """The first allowed time at which a hand is not late that is late at first; NaN where there is none."""
    nearest = _nearest(chase)
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
def _load(chase: Floats, block: Floats, lane: int) -> bool:
    """Write a chase to a lane of a block; returns whether the border of its lateness can be found there."""
    nearest = _nearest(chase)
    x, y, z = chase[X] + nearest * chase[VX], chase[Y] + nearest * chase[VY], chase[Z] + nearest * chase[VZ]
    distance, velocity, acceleration, jerk = (
        math.sqrt(x * x + y * y + z * z),
        chase[VELOCITY],
        chase[ACCELERATION],
        chase[JERK],
    )
    if is_short(distance, velocity, acceleration, jerk):
        return False
    square = acceleration * acceleration
    root = math.sqrt(square * square + 4.0 * jerk * jerk * distance * acceleration)
    # T' is 1 / (v + A^2 / 2 J) with a plateau of acceleration and 1 / V at the greatest speed.
    slope = max(1.0 / (2.0 * jerk * distance * acceleration / (square + root) + 0.5 * square / jerk), 1.0 / velocity)
    speed = math.sqrt(chase[VX] * chase[VX] + chase[VY] * chase[VY] + chase[VZ] * chase[VZ])
    if not speed * slope < STEEPEST:
        return False
    for k in range(FIRST):
        block[k * WIDTH + lane] = chase[k]
    block[SIZE * WIDTH + lane] = 1.0 + slope * (abs(chase[X]) + abs(chase[Y]) + abs(chase[Z]))
    block[GROWTH * WIDTH + lane] = 1.0 + slope * speed
    block[BEFORE * WIDTH + lane] = nearest
    return True


@kernel_part
def _lane_lateness(block: Floats, lane: int, time: float) -> float:
    """Lateness of a lane at a time, for strokes that are not short: `_arrival` without branches and calls."""
    x = block[X * WIDTH + lane] + time * block[VX * WIDTH + lane]
    y = block[Y * WIDTH + lane] + time * block[VY * WIDTH + lane]
    z = block[Z * WIDTH + lane] + time * block[VZ * WIDTH + lane]
    distance = math.sqrt(x * x + y * y + z * z)
    velocity, jerk = block[VELOCITY * WIDTH + lane], block[JERK * WIDTH + lane]
    acceleration = block[ACCELERATION * WIDTH + lane]
    square = acceleration * acceleration
    root = math.sqrt(square * square + 4.0 * jerk * jerk * distance * acceleration)
    speed = 2.0 * jerk * distance * acceleration / (square + root)
    speed = speed if speed < velocity else velocity
    peak, never_flat = math.sqrt(jerk * velocity), jerk * velocity <= square
    speed, peak = (velocity if never_flat else speed), (peak if never_flat else acceleration)
    return distance / speed + (speed / peak + peak / jerk) + block[DESCENT * WIDTH + lane] - time


@kernel_part
def _find_borders(block: Floats, lanes: int) -> None:
    """Find the borders of lateness of a block's lanes by the secant method, and their margins.

    A margin is infinite where the border is not found.
    """
    for lane in range(lanes):
        nearest = block[BEFORE * WIDTH + lane]
        lateness = _lane_lateness(block, lane, nearest)
        block[LATENESS * WIDTH + lane], block[BORDER * WIDTH + lane] = lateness, nearest + lateness
        block[MARGIN * WIDTH + lane] = math.inf
    for _ in range(STEPS):
        missing = 0
        for lane in range(lanes):
            time, before = block[BORDER * WIDTH + lane], block[BEFORE * WIDTH + lane]
            lateness, was = _lane_lateness(block, lane, time), block[LATENESS * WIDTH + lane]
            rounding = ROUNDING * (block[SIZE * WIDTH + lane] + block[GROWTH * WIDTH + lane] * abs(time))
            is_near, margin = abs(lateness) <= 0.25 * rounding, block[MARGIN * WIDTH + lane]
            margin = rounding / (1.0 - STEEPEST) if is_near else margin
            # A border that has been found stays.
            stays = (margin < math.inf) | (lateness == was)
            after = time - lateness * (time - before) / (lateness - was)
            block[MARGIN * WIDTH + lane], block[BORDER * WIDTH + lane] = margin, (time if stays else after)
            block[BEFORE * WIDTH + lane] = before if stays else time
            block[LATENESS * WIDTH + lane] = was if stays else lateness
            missing += 0 if stays else 1
        if missing == 0:
            break


@kernel_part
def _halve_surely(block: Floats, lanes: int) -> None:
    """Bisect the brackets of a block's lanes as long as the borders tell where hands are late."""
    for _ in range(SURE_HALVINGS):
        for lane in range(lanes):
            late, met, border = block[LATE * WIDTH + lane], block[MET * WIDTH + lane], block[BORDER * WIDTH + lane]
            middle = 0.5 * (late + met)
            is_sure, is_late = abs(middle - border) > block[MARGIN * WIDTH + lane], middle < border
            block[HALVED * WIDTH + lane] += 1.0 if is_sure else 0.0
            block[LATE * WIDTH + lane] = middle if is_sure & is_late else late
            block[MET * WIDTH + lane] = middle if is_sure & (not is_late) else met


@kernel_part
def _halve_brackets(block: Floats, lanes: int) -> None:
    """Bisect the brackets of a block's lanes, as `_border_time`; lateness is tried only next to the borders."""
    _halve_surely(block, lanes)
    for _ in range(HALVINGS):
        moves = 0
        for lane in range(lanes):
            late, met, border = block[LATE * WIDTH + lane], block[MET * WIDTH + lane], block[BORDER * WIDTH + lane]
            middle, halved = 0.5 * (late + met), block[HALVED * WIDTH + lane]
            goes_on = (middle != late) & (middle != met) & (halved < HALVINGS)
            is_tried = _lane_lateness(block, lane, middle) > 0.0
            is_late = middle < border if abs(middle - border) > block[MARGIN * WIDTH + lane] else is_tried
            block[HALVED * WIDTH + lane] = halved + 1.0
            block[LATE * WIDTH + lane] = middle if goes_on & is_late else late
            block[MET * WIDTH + lane] = middle if goes_on & (not is_late) else met
            moves += 1 if goes_on else 0
        if moves == 0:
            break


@kernel_part
def _bracket(chase: Floats, nearest: float, border: float, margin: float) -> tuple[float, float]:
    """Times before and after the first meeting, as `_later_meeting` finds them; NaN where there is no meeting."""
    if not _is_late_near(chase, nearest, border, margin):
        return chase[FIRST], nearest
    end, before = max(nearest, min(chase[LAST], chase[END])), nearest
    if not end > nearest:
        return math.nan, math.nan
    # Samples well before the border are late.
    share = min(max((border - margin - nearest) / (end - nearest), 0.0), 1.0)
    first = max(int(SCAN * math.sqrt(share)) - 1, 1)
    if first > 1:
        share = (first - 1) / SCAN
        before = nearest + (end - nearest) * (share * share)
    for k in range(first, SCAN + 1):
        share = k / SCAN
        time = nearest + (end - nearest) * (share * share)
        if not _is_late_near(chase, time, border, margin):
            return before, time
        before = time
    return math.nan, math.nan


@kernel_part
def _is_late_near(chase: Floats, time: float, border: float, margin: float) -> bool:
    """Whether the hand would arrive after the given time, tried only next to the border."""
    if abs(time - border) > margin:
        return time < border
    return _is_late(chase, time)


@kernel_part
def _search_block(chases: Floats, rows: Ints, count: int, block: Floats, time: Floats) -> None:
    """Write the meetings of some late hands, which stand in the first lanes of a block; NaN where there is none."""
    for lane in range(count):
        block[NEAREST * WIDTH + lane] = block[BEFORE * WIDTH + lane]
    _find_borders(block, count)
    for lane in range(count):
        late, met = math.nan, math.nan
        if block[MARGIN * WIDTH + lane] < math.inf:
            border, margin = block[BORDER * WIDTH + lane], block[MARGIN * WIDTH + lane]
            late, met = _bracket(chases[rows[lane]], block[NEAREST * WIDTH + lane], border, margin)
        block[LATE * WIDTH + lane], block[MET * WIDTH + lane], block[HALVED * WIDTH + lane] = late, met, 0.0
        if math.isnan(late):
            block[HALVED * WIDTH + lane] = HALVINGS
    _halve_brackets(block, count)
    for lane in range(count):
        is_known = block[MARGIN * WIDTH + lane] < math.inf
        time[rows[lane]] = block[MET * WIDTH + lane] if is_known else _later_meeting(chases[rows[lane]])


@kernel_part
def search(chases: Floats, time: Floats) -> None:
    """Write the times of the first meetings of N chases; NaN where there is none."""
    block, rows, count = np.zeros(LINES * WIDTH), np.empty(WIDTH, dtype=np.int64), 0
    for row in range(len(chases)):
        chase = chases[row]
        if not _is_late(chase, chase[FIRST]):
            time[row] = chase[FIRST]
        elif _load(chase, block, count):
            rows[count] = row
            count += 1
            if count == WIDTH:
                _search_block(chases, rows, count, block, time)
                count = 0
        else:
            time[row] = _later_meeting(chase)
    if count > 0:
        _search_block(chases, rows, count, block, time)


@kernel
def earliest(chases: Floats2, time: Floats1, reached: Bools1) -> None:
    """Write the first meetings of N chases to `time` and `reached` (N,).

    Args:
        chases: one chase per row (N, 13), by the columns above.
        time: time of the meeting; the first allowed time where there is no meeting.
        reached: whether there is a meeting.
    """
    search(chases, time)
    for row in range(len(chases)):
        reached[row] = not math.isnan(time[row])
        time[row] = time[row] if reached[row] else chases[row, FIRST]


@kernel_part
def search_end(offset: float, speed: float, limits: tuple[float, float, float], descent: float) -> float:
    """Time by which a hand has surely caught an object that is slower; infinite for any other object.

    T(d) <= d / V + 2 (V / A + A / J) for every d, and the object is never farther away than |offset| + speed t.
    """
    velocity, acceleration, jerk = limits
    if not speed < velocity:
        return math.inf
    peak = min(math.sqrt(jerk * velocity), acceleration)
    latest = offset / velocity + 2.0 * (velocity / peak + peak / jerk) + descent
    return 1.001 * latest / (1.0 - speed / velocity)
