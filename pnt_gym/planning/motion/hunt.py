"""Meetings of hands with objects on a belt: where an object may be picked, and when. Compiled.

`chase` finds the time of a meeting; this module says which times are allowed and what follows from the meeting.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from pnt_gym.compiled import empty_rows, kernel, kernel_part
from pnt_gym.planning.motion.chase import Chase, search, search_end
from pnt_gym.planning.motion.rows import Hunt, Intercept
from pnt_gym.planning.motion.strokes import stroke_time
from pnt_gym.planning.reasons import InterceptReason
from pnt_gym.rows import Rows1

IS_MET, PASSED, NEVER_ENTERS, TOO_LATE = map(int, InterceptReason)


CHASE, MEETING = Chase.dtype, Intercept.dtype


@kernel_part
def _allowed_times(hunt: Hunt, axis: int) -> tuple[float, float]:
    """Times at which an object enters and leaves its window; infinite for an object that never enters."""
    place, speed = hunt.place[axis], hunt.belt[axis]
    if speed == 0.0:
        return -math.inf if hunt.low <= place <= hunt.high else math.inf, math.inf
    at_low, at_high = (hunt.low - place) / speed, (hunt.high - place) / speed
    return min(at_low, at_high), max(at_low, at_high)


@kernel_part
def _set_up(hunt: Hunt, chase: Chase) -> None:
    """Write a chase, except for its allowed times."""
    for k in range(3):
        chase.way[k], chase.belt[k] = hunt.place[k] - hunt.hand[k], hunt.belt[k]
    chase.way[2] += hunt.clearance
    velocity, acceleration, jerk = hunt.velocity, hunt.acceleration, hunt.jerk
    chase.velocity, chase.acceleration, chase.jerk = velocity, acceleration, jerk
    chase.descent = stroke_time(hunt.clearance, velocity, acceleration, jerk)
    way, belt = chase.way, chase.belt
    offset = math.sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2])
    speed = math.sqrt(belt[0] * belt[0] + belt[1] * belt[1] + belt[2] * belt[2])
    chase.end = search_end(offset, speed, (velocity, acceleration, jerk), chase.descent)


@kernel_part
def _write_meeting(hunt: Hunt, chase: Chase, time: float, meeting: Any) -> None:
    """Write a meeting."""
    way, belt = chase.way, chase.belt
    x, y, z = way[0] + time * belt[0], way[1] + time * belt[1], way[2] + time * belt[2]
    travel = stroke_time(math.sqrt(x * x + y * y + z * z), chase.velocity, chase.acceleration, chase.jerk)
    for k in range(3):
        meeting.position[k] = hunt.place[k] + time * hunt.belt[k]
    meeting.wait = 0.0 if time > chase.first else max(time - travel - chase.descent, 0.0)
    meeting.time, meeting.travel, meeting.descent = time, travel, chase.descent
    meeting.feasible, meeting.reason = True, IS_MET


@kernel_part
def _miss(meeting: Any, reason: int) -> None:
    """Write that there is no meeting, and why."""
    for k in range(3):
        meeting.position[k] = math.nan
    meeting.time = meeting.wait = meeting.travel = meeting.descent = math.nan
    meeting.feasible, meeting.reason = False, reason


@kernel
def meet(hunts: Rows1[Hunt], axis: int, horizon: float) -> Rows1[Intercept]:
    """Find the first meetings of N hands with objects.

    Args:
        hunts: hands and objects.
        axis: coordinate that the windows bound.
        horizon: latest time that is searched [s].
    """
    meetings = empty_rows(len(hunts), MEETING)
    chases, rows, count = empty_rows(len(hunts), CHASE), np.empty(len(hunts), dtype=np.int64), 0
    for row in range(len(hunts)):
        enter, leave = _allowed_times(hunts[row], axis)
        first, last = max(enter, hunts[row].earliest, 0.0), min(leave, horizon)
        reason = NEVER_ENTERS if first > horizon else PASSED if first > last else TOO_LATE
        _miss(meetings[row], reason)
        if reason == TOO_LATE:
            chase = chases[count]
            _set_up(hunts[row], chase)
            chase.first, chase.last, rows[count] = first, last, row
            count += 1
    times = np.empty(count)
    search(chases[:count], times)
    for k in range(count):
        if not math.isnan(times[k]):
            _write_meeting(hunts[rows[k]], chases[k], times[k], meetings[rows[k]])
    return meetings
