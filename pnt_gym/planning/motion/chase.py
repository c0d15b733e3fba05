"""Earliest time at which a hand meets a moving object. Compiled; see `pnt_gym.compiled`.

The hand moves from rest to rest to the point above the object's place at time t, then down: the hand is late at t when
both moves together take longer than t.

Where a hand is late is known almost everywhere without trying. Let T(d) be the time of a stroke, D that of the descent,
d(t) the distance at t, and q the object's speed times the largest slope of T on the way. With q below 1 the lateness
T(d(t)) + D - t has one border r: lateness is at least (1 - q) (r - t) before r and at most -(1 - q) (t - r) after r. So
only times next to r, where rounding decides, are tried. The search visits the times that it would visit without this
knowledge, and gives the same bits.
"""

from __future__ import annotations

import math
from typing import Annotated, TypeAlias

import numpy as np

from pnt_gym.arrays import Floats, Ints
from pnt_gym.compiled import empty_rows, kernel, kernel_part
from pnt_gym.planning.motion.strokes import duration, greatest_acceleration, is_short, long_peaks, stroke_time
from pnt_gym.rows import Floats1, Row, Rows1, Triple, field

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
# Late hands are searched for in blocks of so many lanes, whose loops become vector instructions.
WIDTH = 32
# Halvings that are surely needed of most brackets before rounding decides.
SURE_HALVINGS = 40
Lanes: TypeAlias = Annotated[Floats, WIDTH]


class Chase(Row):
    """A hand that goes after a moving object."""

    way: Triple = field("m", "position of the object relative to the hand, raised by the clearance")
    belt: Triple = field("m/s", "velocity of the object")
    descent: float = field("s", "time of the hand's descent")
    velocity: float = field("m/s", "limit of the hand's speed")
    acceleration: float = field("m/s2", "limit of the hand's acceleration")
    jerk: float = field("m/s3", "limit of the hand's jerk")
    first: float = field("s", "first allowed time")
    last: float = field("s", "last allowed time")
    end: float = field("s", "latest time that needs to be searched")


class ChaseBlock(Row):
    """Chases next to each other, number by number."""

    x: Lanes = field("m", "way along x")
    y: Lanes = field("m", "way along y")
    z: Lanes = field("m", "way along z")
    belt_x: Lanes = field("m/s", "velocity of the object along x")
    belt_y: Lanes = field("m/s", "velocity of the object along y")
    belt_z: Lanes = field("m/s", "velocity of the object along z")
    descent: Lanes = field("s", "time of the descent")
    velocity: Lanes = field("m/s", "limit of the speed")
    acceleration: Lanes = field("m/s2", "limit of the acceleration")
    jerk: Lanes = field("m/s3", "limit of the jerk")
    size: Lanes = field("s", "size of the lateness, for the rounding")
    growth: Lanes = field("-", "growth of that size with the time")
    before: Lanes = field("s", "time before, of the secant method")
    lateness: Lanes = field("s", "lateness at that time")
    border: Lanes = field("s", "border that the secant method finds")
    margin: Lanes = field("s", "distance from the border up to which rounding decides; infinite without a border")
    late: Lanes = field("s", "end of the bracket at which the hand is late")
    met: Lanes = field("s", "end of the bracket at which the hand is not late")
    halved: Lanes = field("-", "number of halvings of the bracket")
    nearest: Lanes = field("s", "allowed time at which the object is closest")


CHASE, BLOCK = Chase.dtype, ChaseBlock.dtype


@kernel_part
def _arrival(chase: Chase, time: float) -> float:
    """Time at which the hand touches an object whose place is that at a time, if the hand sets off now."""
    x, y, z = (
        chase.way[0] + time * chase.belt[0],
        chase.way[1] + time * chase.belt[1],
        chase.way[2] + time * chase.belt[2],
    )
    travel = stroke_time(math.sqrt(x * x + y * y + z * z), chase.velocity, chase.acceleration, chase.jerk)
    return travel + chase.descent


@kernel_part
def _is_late(chase: Chase, time: float) -> bool:
    """Whether the hand would arrive after the given time."""
    return _arrival(chase, time) - time > 0.0


@kernel_part
def _border(chase: Chase, late: float, met: float) -> float:
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
def _nearest(chase: Chase) -> float:
    """Allowed time at which the object is closest to the hand."""
    square = chase.belt[0] * chase.belt[0] + chase.belt[1] * chase.belt[1] + chase.belt[2] * chase.belt[2]
    along = chase.way[0] * chase.belt[0] + chase.way[1] * chase.belt[1] + chase.way[2] * chase.belt[2]
    return min(max(-along / (square if square > 0.0 else 1.0), chase.first), chase.last)


@kernel_part
def _later_meeting(chase: Chase) -> float:
    """The first allowed time at which a hand is not late that is late at first; NaN where there is none."""
    nearest = _nearest(chase)
    if not _is_late(chase, nearest):
        return _border(chase, chase.first, nearest)
    end, before = max(nearest, min(chase.last, chase.end)), nearest
    for k in range(1, SCAN + 1):
        share = k / SCAN
        time = nearest + (end - nearest) * (share * share)
        if not _is_late(chase, time):
            return _border(chase, before, time)
        before = time
    return math.nan


@kernel_part
def _load(chase: Chase, block: ChaseBlock, lane: int) -> bool:
    """Write a chase to a lane of a block; returns whether the border of its lateness can be found there."""
    nearest = _nearest(chase)
    x, y, z = (
        chase.way[0] + nearest * chase.belt[0],
        chase.way[1] + nearest * chase.belt[1],
        chase.way[2] + nearest * chase.belt[2],
    )
    distance, velocity, acceleration, jerk = (
        math.sqrt(x * x + y * y + z * z),
        chase.velocity,
        chase.acceleration,
        chase.jerk,
    )
    if is_short(distance, velocity, acceleration, jerk):
        return False
    # T' is 1 / (v + A^2 / 2 J) with a plateau of acceleration and 1 / V at the greatest speed.
    plateau_speed, _ = long_peaks(distance, velocity, acceleration, jerk)
    slope = max(1.0 / (plateau_speed + 0.5 * acceleration * acceleration / jerk), 1.0 / velocity)
    speed = math.sqrt(chase.belt[0] * chase.belt[0] + chase.belt[1] * chase.belt[1] + chase.belt[2] * chase.belt[2])
    if not speed * slope < STEEPEST:
        return False
    block.x[lane], block.y[lane], block.z[lane] = chase.way[0], chase.way[1], chase.way[2]
    block.belt_x[lane], block.belt_y[lane], block.belt_z[lane] = chase.belt[0], chase.belt[1], chase.belt[2]
    block.descent[lane], block.velocity[lane] = chase.descent, velocity
    block.acceleration[lane], block.jerk[lane] = acceleration, jerk
    block.size[lane] = 1.0 + slope * (abs(chase.way[0]) + abs(chase.way[1]) + abs(chase.way[2]))
    block.growth[lane] = 1.0 + slope * speed
    block.before[lane] = nearest
    return True


@kernel_part
def _lane_lateness(block: ChaseBlock, lane: int, time: float) -> float:
    """Lateness of a lane at a time, for strokes that are not short: `_arrival` without branches and calls."""
    x = block.x[lane] + time * block.belt_x[lane]
    y = block.y[lane] + time * block.belt_y[lane]
    z = block.z[lane] + time * block.belt_z[lane]
    distance, jerk = math.sqrt(x * x + y * y + z * z), block.jerk[lane]
    speed, peak = long_peaks(distance, block.velocity[lane], block.acceleration[lane], jerk)
    return duration(distance, speed, peak, jerk) + block.descent[lane] - time


@kernel_part
def _find_borders(block: ChaseBlock, lanes: int) -> None:
    """Find the borders of lateness of a block's lanes by the secant method, and their margins.

    A margin is infinite where the border is not found.
    """
    for lane in range(lanes):
        nearest = block.before[lane]
        lateness = _lane_lateness(block, lane, nearest)
        block.lateness[lane], block.border[lane] = lateness, nearest + lateness
        block.margin[lane] = math.inf
    for _ in range(STEPS):
        missing = 0
        for lane in range(lanes):
            time, before = block.border[lane], block.before[lane]
            lateness, was = _lane_lateness(block, lane, time), block.lateness[lane]
            rounding = ROUNDING * (block.size[lane] + block.growth[lane] * abs(time))
            is_near, margin = abs(lateness) <= 0.25 * rounding, block.margin[lane]
            margin = rounding / (1.0 - STEEPEST) if is_near else margin
            # A border that has been found stays.
            stays = (margin < math.inf) | (lateness == was)
            after = time - lateness * (time - before) / (lateness - was)
            block.margin[lane], block.border[lane] = margin, (time if stays else after)
            block.before[lane] = before if stays else time
            block.lateness[lane] = was if stays else lateness
            missing += 0 if stays else 1
        if missing == 0:
            break


@kernel_part
def _halve_brackets(block: ChaseBlock, lanes: int) -> None:
    """Bisect the brackets of a block's lanes, as `_border`; lateness is tried only next to the borders."""
    # As long as the borders tell where hands are late, nothing is tried.
    for _ in range(SURE_HALVINGS):
        for lane in range(lanes):
            late, met, border = block.late[lane], block.met[lane], block.border[lane]
            middle = 0.5 * (late + met)
            is_sure, is_late = abs(middle - border) > block.margin[lane], middle < border
            block.halved[lane] += 1.0 if is_sure else 0.0
            block.late[lane] = middle if is_sure & is_late else late
            block.met[lane] = middle if is_sure & (not is_late) else met
    for _ in range(HALVINGS):
        moves = 0
        for lane in range(lanes):
            late, met, border = block.late[lane], block.met[lane], block.border[lane]
            middle, halved = 0.5 * (late + met), block.halved[lane]
            goes_on = (middle != late) & (middle != met) & (halved < HALVINGS)
            is_tried = _lane_lateness(block, lane, middle) > 0.0
            is_late = middle < border if abs(middle - border) > block.margin[lane] else is_tried
            block.halved[lane] = halved + 1.0
            block.late[lane] = middle if goes_on & is_late else late
            block.met[lane] = middle if goes_on & (not is_late) else met
            moves += 1 if goes_on else 0
        if moves == 0:
            break


@kernel_part
def _bracket(chase: Chase, nearest: float, border: float, margin: float) -> tuple[float, float]:
    """Times before and after the first meeting, as `_later_meeting` finds them; NaN where there is no meeting."""
    if not _is_late_near(chase, nearest, border, margin):
        return chase.first, nearest
    end, before = max(nearest, min(chase.last, chase.end)), nearest
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
def _is_late_near(chase: Chase, time: float, border: float, margin: float) -> bool:
    """Whether the hand would arrive after the given time, tried only next to the border."""
    if abs(time - border) > margin:
        return time < border
    return _is_late(chase, time)


@kernel_part
def _search_block(chases: Rows1[Chase], rows: Ints, count: int, blocks: Rows1[ChaseBlock], time: Floats) -> None:
    """Write the meetings of some late hands, which stand in the first lanes of a block; NaN where there is none."""
    block = blocks[0]
    for lane in range(count):
        block.nearest[lane] = block.before[lane]
    _find_borders(block, count)
    for lane in range(count):
        late, met = math.nan, math.nan
        if block.margin[lane] < math.inf:
            border, margin = block.border[lane], block.margin[lane]
            late, met = _bracket(chases[rows[lane]], block.nearest[lane], border, margin)
        block.late[lane], block.met[lane], block.halved[lane] = late, met, 0.0
        if math.isnan(late):
            block.halved[lane] = HALVINGS
    _halve_brackets(block, count)
    for lane in range(count):
        is_known = block.margin[lane] < math.inf
        time[rows[lane]] = block.met[lane] if is_known else _later_meeting(chases[rows[lane]])


@kernel_part
def search(chases: Rows1[Chase], time: Floats) -> None:
    """Write the times of the first meetings of N chases; NaN where there is none."""
    # The block is an array of one row, since a row alone does not keep its array in memory.
    blocks, rows, count = empty_rows(1, BLOCK), np.empty(WIDTH, dtype=np.int64), 0
    for row in range(len(chases)):
        chase = chases[row]
        if not _is_late(chase, chase.first):
            time[row] = chase.first
        elif _load(chase, blocks[0], count):
            rows[count] = row
            count += 1
            if count == WIDTH:
                _search_block(chases, rows, count, blocks, time)
                count = 0
        else:
            time[row] = _later_meeting(chase)
    if count > 0:
        _search_block(chases, rows, count, blocks, time)


@kernel
def earliest(chases: Rows1[Chase]) -> Floats1:
    """Times of the first meetings of N chases (N,) [s]; NaN where there is no meeting."""
    time = np.empty(len(chases))
    search(chases, time)
    return time


@kernel_part
def search_end(offset: float, speed: float, limits: tuple[float, float, float], descent: float) -> float:
    """Time by which a hand has surely caught an object that is slower; infinite for any other object.

    T(d) <= d / V + 2 (V / A + A / J) for every d, and the object is never farther away than |offset| + speed t.
    """
    velocity, acceleration, jerk = limits
    if not speed < velocity:
        return math.inf
    peak = greatest_acceleration(velocity, acceleration, jerk)
    latest = offset / velocity + 2.0 * (velocity / peak + peak / jerk) + descent
    return 1.001 * latest / (1.0 - speed / velocity)
