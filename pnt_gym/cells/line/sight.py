"""Turns of robots, and what camera and encoder show them. Compiled; see `pnt_gym.compiled`.

Objects stand on a belt in the order of x, the most downstream first, so that those in sight follow each other.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from pnt_gym.cells.line.rows import (
    IDLE_TIME,
    UNAVAILABLE_X,
    Account,
    Candidate,
    LineNumbers,
    LineState,
    Rider,
    Seen,
    Tables,
)
from pnt_gym.compiled import empty_rows, kernel, kernel_part
from pnt_gym.rows import Ints1, Rows1, Rows2

SEEN, CANDIDATE = Seen.dtype, Candidate.dtype

LONGEST_PAUSE: Final = 1.0
"""A robot looks again after this time even if nothing is near, since an object that another robot failed to pick comes
unannounced [s]."""
LOOKS: Final = 100_000
"""Looks of one line without a result before the line is declared impossible."""


@kernel_part
def first_below(riders: Rows1[Rider], ride: float, border: float, is_inclusive: bool) -> int:
    """Index of the first object of one belt that lies upstream of a border, or on it if ``is_inclusive``."""
    begin, end = 0, len(riders)
    while begin < end:
        middle = (begin + end) // 2
        place = riders[middle].x + ride
        if place > border or (place == border and not is_inclusive):
            begin = middle + 1
        else:
            end = middle
    return begin


@kernel_part
def _range_in_sight(line: LineNumbers, riders: Rows1[Rider], time: float) -> tuple[int, int]:
    """The first object of one belt in sight, and the index after the last one."""
    ride = line.speed * time
    return first_below(riders, ride, line.sight_high, True), first_below(riders, ride, line.sight_low, False)


@kernel_part
def _down_until(tables: Tables, robot: int, time: float) -> float:
    """End of the standstill of a robot [s]; the present time where the robot does not stand still."""
    until = time
    for k in range(len(tables.standstills)):
        still = tables.standstills[k]
        if still.robot == robot and still.start <= until < still.end:
            until = still.end
    return until


@kernel_part
def _pause(tables: Tables, riders: Rows1[Rider], accounts: Rows1[Account], robot: int, time: float) -> float:
    """Time after which a robot looks again [s]; negative where an object that it takes is near."""
    line, base, able = tables.line[0], tables.stations[robot].base, tables.can_take[robot]
    least, ride = UNAVAILABLE_X, line.speed * time
    begin, end = _range_in_sight(line, riders, time)
    for j in range(begin, end):
        place = riders[j].x + ride - base
        if accounts[j].since <= time and able[riders[j].seen] and place <= line.window_high:
            if place >= line.near_low:
                return -1.0
            least = min(least, line.near_low - place)
    return min(max(least / line.speed, IDLE_TIME), LONGEST_PAUSE)


@kernel_part
def next_turns(tables: Tables, state: LineState, riders: Rows2[Rider], lines: Ints1) -> tuple[bool, Ints1]:
    """Advance some lines until their next free robot has an object near it, or the shift is over.

    Args:
        tables: what the level says.
        state: state of the lines; turns and arms are written.
        riders: objects of all lines (N, M).
        lines: indices of the lines (K,).

    Returns:
        Whether every line came to an end within `LOOKS` looks, and the lines whose robots have an object near them.
    """
    line, seekers, count = tables.line[0], np.empty_like(lines), 0
    for n in lines:
        for look in range(LOOKS):
            r = 0
            for other in range(1, state.arms.shape[1]):
                if state.arms[n, other].free < state.arms[n, r].free:
                    r = other
            arm, turn = state.arms[n, r], state.turns[n]
            time = arm.free
            turn.clock, turn.robot = time, r
            if not time < line.duration:
                break
            until = _down_until(tables, r, time)
            if until > time:
                arm.free = until
                continue
            pause = _pause(tables, riders[n], state.accounts[n], r, time)
            if pause < 0.0:
                seekers[count] = n
                count += 1
                break
            arm.free += pause
            if look == LOOKS - 1:
                return False, seekers[:0]
    return True, seekers[:count]


@kernel
def show_objects(tables: Tables, state: LineState, riders: Rows2[Rider], lines: Ints1) -> Rows2[Seen]:
    """What camera and encoder know in some lines: the objects in sight, the most downstream first (K, W)."""
    ends, width = np.empty((len(lines), 2), dtype=np.int64), 1
    for k in range(len(lines)):
        ends[k, 0], ends[k, 1] = _range_in_sight(tables.line[0], riders[lines[k]], state.turns[lines[k]].clock)
        width = max(width, ends[k, 1] - ends[k, 0])
    seen = empty_rows((len(lines), width), SEEN)
    for k in range(len(lines)):
        n, time = lines[k], state.turns[lines[k]].clock
        ride = tables.line[0].speed * time
        for j in range(width):
            i = min(ends[k, 0] + j, riders.shape[1] - 1)
            is_free = ends[k, 0] + j < ends[k, 1] and state.accounts[n, i].since <= time
            seen[k, j].index, seen[k, j].kind = i, riders[n, i].seen
            seen[k, j].x = riders[n, i].x + ride if is_free else UNAVAILABLE_X
    return seen


@kernel
def list_candidates(tables: Tables, seen: Rows2[Seen], robots: Ints1) -> Rows1[Candidate]:
    """What robots (K,) may throw: objects near them, into each bin that takes the object, at each speed setting."""
    most, count, line = 0, 0, tables.line[0]
    for r in robots:
        station = tables.stations[r]
        settings = station.end_setting - station.first_setting
        most += (station.end_site - station.first_site) * settings * seen.shape[1]
    candidates = empty_rows(most, CANDIDATE)
    for k in range(seen.shape[0]):
        station, able = tables.stations[robots[k]], tables.can_take[robots[k]]
        for j in range(seen.shape[1]):
            place, kind = seen[k, j].x - station.base, seen[k, j].kind
            if not (able[kind] and line.near_low <= place <= line.window_high):
                continue
            for site in range(station.first_site, station.end_site):
                if not tables.accepts[site, kind]:
                    continue
                for setting in range(station.first_setting, station.end_setting):
                    candidate = candidates[count]
                    candidate.line, candidate.place, candidate.x = k, j, place
                    candidate.site, candidate.setting = site, setting
                    count += 1
    return candidates[:count]


@kernel_part
def count_coming(tables: Tables, riders: Rows1[Rider], accounts: Rows1[Account], robot: int, time: float) -> int:
    """Objects of one line that a robot takes, from the camera to the end of its window."""
    line, able = tables.line[0], tables.can_take[robot]
    ride, end, count = line.speed * time, tables.stations[robot].base + line.window_high, 0
    begin = first_below(riders, ride, min(line.sight_high, end), True)
    for j in range(begin, len(riders)):
        place = riders[j].x + ride
        if place < line.sight_low:
            break
        count += 1 if accounts[j].since <= time and able[riders[j].seen] else 0
    return count
