"""Meetings of hands with objects on the belt, candidate by candidate in machine code; see `pnt_gym.compiled`.

The formulas are those of `StraightMover` and `TrackingMover`, operation by operation, without segments of motions.
"""

from __future__ import annotations

import math

import numpy as np

from pnt_gym.arrays import Floats, Ints
from pnt_gym.compiled import compile_for, kernel_part
from pnt_gym.planning.motion.chase import CHASE_COLUMNS, earliest, search_end
from pnt_gym.planning.motion.chase import END as CHASE_END
from pnt_gym.planning.motion.chase import FIRST as CHASE_FIRST
from pnt_gym.planning.motion.chase import LAST as CHASE_LAST
from pnt_gym.planning.motion.strokes import stroke_time

# Columns of a speed setting: percentage; limits of the hand; acceleration and jerk that are left for the way to an
# object, time of the descent, least time of that way, virtual place of its end ahead of the object and behind the lift,
# and the window of that place. Lengths are in m, times in s.
PERCENT, VELOCITY, ACCELERATION, JERK, WAY_ACCELERATION, WAY_JERK, DESCENT, LEAST_TIME, EARLY, BEHIND, LOW, HIGH = (
    range(12)
)
# Numbers of a cell: speed of the belt and the same as a length; height of the belt; gap under the lip; clearance above
# an object; latest meeting that is searched, and latest one that counts; dwell; height of the ceiling above the pick;
# coasting after the release; share of gravity while braking, NaN without; reserve of the target; semi-axes and heights
# of the workspace; downstream end of the window; whether hands ride with the belt; speed and share of the fading.
(
    SPEED, PACE, BELT_HEIGHT, LIP, CLEARANCE, SEARCH, HORIZON, DWELL, CEILING, COAST, GRAVITY_SHARE, RESERVE, SEMI_X,
    SEMI_Y, Z_MIN, Z_MAX, WINDOW_END, RIDES, USUAL_SPEED, MOST_SHARE,
) = range(20)  # fmt: skip


@kernel_part
def _set_up(numbers: Floats, setting: Floats, point: Floats, hand: Floats, chase: Floats) -> bool:
    """Write the chase of a hand after a point, as `plan_intercept`; returns whether the point comes in time."""
    speed, x = numbers[SPEED], point[0]
    for axis in range(3):
        chase[axis] = point[axis] - hand[axis]
    chase[2] += numbers[CLEARANCE]
    velocity, acceleration, jerk = setting[VELOCITY], setting[WAY_ACCELERATION], setting[WAY_JERK]
    chase[3], chase[4], chase[5], chase[6] = speed, 0.0, 0.0, setting[DESCENT]
    chase[7], chase[8], chase[9] = velocity, acceleration, jerk
    low_time, high_time = (setting[LOW] - x) / speed, (setting[HIGH] - x) / speed
    first, last = max(min(low_time, high_time), 0.0), min(max(low_time, high_time), numbers[SEARCH])
    chase[CHASE_FIRST], chase[CHASE_LAST] = (first, last) if first <= last else (0.0, 0.0)
    far = math.sqrt(chase[0] * chase[0] + chase[1] * chase[1] + chase[2] * chase[2])
    chase[CHASE_END] = search_end(far, numbers[PACE], (velocity, acceleration, jerk), setting[DESCENT])
    return first <= last and first <= numbers[SEARCH]


@kernel_part
def _wait(numbers: Floats, setting: Floats, chase: Floats, time: float) -> float:
    """Standstill of a hand above the belt before a meeting [s]."""
    if time > chase[CHASE_FIRST]:
        return 0.0
    x, y, z = chase[0] + time * numbers[SPEED], chase[1], chase[2]
    stroke = math.sqrt(x * x + y * y + z * z)
    travel = stroke_time(stroke, setting[VELOCITY], setting[WAY_ACCELERATION], setting[WAY_JERK])
    return max(time - travel - setting[DESCENT], 0.0)


@compile_for(
    "Tuple((i8[::1], f8[::1], f8[:, ::1], f8[::1], f8[::1]))("
    "f8[::1], f8[:, ::1], i8[:, :], f8[:], i8[:], i8[:, :], f8[:, :], f8[:, :, :], f8[:, :], f8[:, :])"
)
def meet_candidates(
    numbers: Floats,
    settings: Floats,
    candidates: Ints,
    places: Floats,
    lines: Ints,
    index: Ints,
    hand: Floats,
    size: Floats,
    known_depth: Floats,
    lane_y: Floats,
) -> tuple[Ints, Floats, Floats, Floats, Floats]:
    """Find the candidates that hands meet in time, as `Mover.reach` and `plan_intercept` do.

    Args:
        numbers: numbers of the cell by the names above.
        settings: speed settings by the columns above (S, 12).
        candidates: line among the K lines, object among the objects in sight, bin and setting, (4, C).
        places: position of the object from the robot's base (C,) [m].
        lines: indices of the lines (K,).
        index: indices of the objects in sight (K, W).
        hand: positions of the deciding robots' hands (K, 3) [m].
        size: extents of all objects (N, M, 3) [m].
        known_depth: known depth of the centre of mass (N, M) [m].
        lane_y: positions across the belt (N, M) [m].

    Returns:
        The candidates that are met (P,), the times of the meetings (P,) [s], where the objects are lifted (P, 3) [m],
        the limit of the setting's acceleration (P,) [m/s2] and the standstill of the hand above the belt (P,) [s].
    """
    most = len(places)
    points, chases, is_open = np.empty((most, 3)), np.empty((most, CHASE_COLUMNS)), np.empty(most, dtype=np.bool_)
    for c in range(most):
        k, setting = candidates[0, c], settings[candidates[3, c]]
        line, i = lines[k], index[k, candidates[1, c]]
        points[c, 0], points[c, 1] = places[c] - setting[EARLY], lane_y[line, i]
        points[c, 2] = numbers[BELT_HEIGHT] + size[line, i, 2] + numbers[LIP] - known_depth[line, i]
        is_open[c] = _set_up(numbers, setting, points[c], hand[k], chases[c])
    times, is_reached = np.empty(most), np.empty(most, dtype=np.bool_)
    earliest(chases, times, is_reached)
    met, picks = np.empty(most, dtype=np.int64), np.empty((most, 3))
    acceleration, waits, count = np.empty(most), np.empty(most), 0
    for c in range(most):
        setting, time = settings[candidates[3, c]], times[c]
        if not (is_open[c] and is_reached[c] and time >= setting[LEAST_TIME] and time <= numbers[HORIZON]):
            continue
        met[count], times[count], acceleration[count] = c, time, setting[ACCELERATION]
        waits[count] = _wait(numbers, setting, chases[c], time)
        picks[count, 0] = points[c, 0] + time * numbers[SPEED] + setting[BEHIND]
        picks[count, 1], picks[count, 2] = points[c, 1], points[c, 2]
        count += 1
    return met[:count], times[:count], picks[:count], acceleration[:count], waits[:count]


@compile_for("void(f8, f8[:, ::1])")
def write_descents(clearance: float, settings: Floats) -> None:
    """Write the times of the descents of speed settings (S, 12), from the other columns."""
    for setting in settings:
        setting[DESCENT] = stroke_time(clearance, setting[VELOCITY], setting[WAY_ACCELERATION], setting[WAY_JERK])
