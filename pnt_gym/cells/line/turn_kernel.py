"""Turns, sights and candidates of lines, line by line in machine code; see `pnt_gym.compiled`.

Objects stand on a belt in the order of x, the most downstream first, so that those in sight follow each other.
"""

from __future__ import annotations

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.compiled import compile_for, kernel_part

# Numbers of a line: speed of the belt [m/s]; upstream and downstream end of the sight [m]; upstream end from which an
# object comes into a robot's window in time, and the window's downstream end, from its base [m]; length of a work shift
# [s]; shortest and longest time after which a robot looks again [s]; position of objects that cannot be taken [m].
SPEED, SIGHT_LOW, SIGHT_HIGH, NEAR_LOW, NEAR_HIGH, DURATION, IDLE, LONGEST, UNAVAILABLE = range(9)
# Looks of one line without a result before the line is declared impossible.
LOOKS = 100_000


@kernel_part
def _first_below(x: Floats, ride: float, border: float, is_inclusive: bool) -> int:
    """Index of the first object of one belt that lies upstream of a border, or on it if ``is_inclusive``."""
    begin, end = 0, len(x)
    while begin < end:
        middle = (begin + end) // 2
        place = x[middle] + ride
        if place > border or (place == border and not is_inclusive):
            begin = middle + 1
        else:
            end = middle
    return begin


@kernel_part
def _down_until(robot: int, time: float, down_robots: Ints, down_times: Floats) -> float:
    """End of the standstill of a robot [s]; the present time where the robot does not stand still."""
    until = time
    for k in range(len(down_robots)):
        if down_robots[k] == robot and down_times[k, 0] <= until < down_times[k, 1]:
            until = down_times[k, 1]
    return until


@kernel_part
def _pause(
    numbers: Floats, x: Floats, since: Floats, kinds: Ints, able: Bools, base: float, time: float, begin: int, end: int
) -> float:
    """Time after which a robot looks again [s]; negative where an object that it takes is near."""
    least, ride = numbers[UNAVAILABLE], numbers[SPEED] * time
    for j in range(begin, end):
        place = x[j] + ride - base
        if since[j] <= time and able[kinds[j]] and place <= numbers[NEAR_HIGH]:
            if place >= numbers[NEAR_LOW]:
                return -1.0
            least = min(least, numbers[NEAR_LOW] - place)
    return min(max(least / numbers[SPEED], numbers[IDLE]), numbers[LONGEST])


@compile_for(
    "b1(f8[::1], i8[::1], f8[::1], i8[::1], f8[:, ::1], f8[:, :], f8[:, :], i8[:, :], b1[:, ::1], f8[::1], i8[::1],"
    "f8[:, ::1], b1[::1], i8[:, ::1])"
)
def next_turns(
    numbers: Floats,
    lines: Ints,
    clock: Floats,
    robot: Ints,
    free: Floats,
    x: Floats,
    since: Floats,
    kinds: Ints,
    can_take: Bools,
    bases: Floats,
    down_robots: Ints,
    down_times: Floats,
    has_candidates: Bools,
    ends: Ints,
) -> bool:
    """Advance lines to the next robot that has something near it, or to the end of the work shift.

    Args:
        numbers: numbers of the line by the names above.
        lines: indices of the lines that advance (K,).
        clock: times of all lines, written (N,) [s].
        robot: deciding robots, written (N,).
        free: times at which the robots are free, written (N, R) [s].
        x: positions of the objects when the work shift begins (N, M) [m].
        since: times from which the objects may be taken (N, M) [s].
        kinds: items as which the objects are classified (N, M).
        can_take: whether each robot takes each item (R, items).
        bases: positions of the robots (R,) [m].
        down_robots: robots that stand still for a while (D,).
        down_times: begins and ends of the standstills (D, 2) [s].
        has_candidates: written, whether an object is near the robot (K,); False where the work shift is over.
        ends: written, the first object in sight and the index after the last one (K, 2).

    Returns:
        Whether every line came to an end within `LOOKS` looks.
    """
    for k in range(len(lines)):
        line = lines[k]
        has_candidates[k] = False
        for look in range(LOOKS):
            r = 0
            for other in range(1, free.shape[1]):
                if free[line, other] < free[line, r]:
                    r = other
            time = free[line, r]
            clock[line], robot[line] = time, r
            if not time < numbers[DURATION]:
                break
            until = _down_until(r, time, down_robots, down_times)
            if until > time:
                free[line, r] = until
                continue
            ride = numbers[SPEED] * time
            ends[k, 0] = _first_below(x[line], ride, numbers[SIGHT_HIGH], True)
            ends[k, 1] = _first_below(x[line], ride, numbers[SIGHT_LOW], False)
            pause = _pause(
                numbers, x[line], since[line], kinds[line], can_take[r], bases[r], time, ends[k, 0], ends[k, 1]
            )
            if pause < 0.0:
                has_candidates[k] = True
                break
            free[line, r] += pause
            if look == LOOKS - 1:
                return False
    return True


@compile_for("i8(f8[::1], i8[::1], f8[::1], f8[:, :], i8[:, ::1])")
def find_ends(numbers: Floats, lines: Ints, clock: Floats, x: Floats, ends: Ints) -> int:
    """Write the ranges of the objects in sight of some lines (K, 2), as `next_turns`; returns the largest number."""
    most = 0
    for k in range(len(lines)):
        ride = numbers[SPEED] * clock[lines[k]]
        ends[k, 0] = _first_below(x[lines[k]], ride, numbers[SIGHT_HIGH], True)
        ends[k, 1] = _first_below(x[lines[k]], ride, numbers[SIGHT_LOW], False)
        most = max(most, ends[k, 1] - ends[k, 0])
    return most


@compile_for(
    "void(f8[::1], i8[::1], f8[::1], f8[:, :], f8[:, :], i8[:, :], i8[:, ::1], i8[:, ::1], f8[:, ::1], i8[:, ::1])"
)
def show_objects(
    numbers: Floats,
    lines: Ints,
    clock: Floats,
    x: Floats,
    since: Floats,
    kinds: Ints,
    ends: Ints,
    index: Ints,
    seen_x: Floats,
    seen_kinds: Ints,
) -> None:
    """Write the sights of some lines: indices, positions and items of the objects (K, W), as `Sight` has them."""
    for k in range(len(lines)):
        line, time = lines[k], clock[lines[k]]
        ride = numbers[SPEED] * time
        for j in range(index.shape[1]):
            i = min(ends[k, 0] + j, x.shape[1] - 1)
            is_free = ends[k, 0] + j < ends[k, 1] and since[line, i] <= time
            index[k, j], seen_kinds[k, j] = i, kinds[line, i]
            seen_x[k, j] = x[line, i] + ride if is_free else numbers[UNAVAILABLE]


@compile_for("i8(f8[::1], f8[:, :], i8[:, :], i8[:], b1[:, ::1], f8[::1], i8[:, ::1], b1[:, ::1], i8[:, ::1], f8[::1])")
def list_candidates(
    numbers: Floats,
    x: Floats,
    kinds: Ints,
    robot: Ints,
    can_take: Bools,
    bases: Floats,
    ranges: Ints,
    accepts: Bools,
    candidates: Ints,
    places: Floats,
) -> int:
    """Write what robots may throw: objects near them, into each bin that takes the object, at each speed setting.

    Args:
        numbers: numbers of the line by the names above.
        x: positions of the objects in sight (K, W) [m].
        kinds: items as which these are classified (K, W).
        robot: deciding robots (K,).
        can_take: whether each robot takes each item (R, items).
        bases: positions of the robots (R,) [m].
        ranges: each robot's first bin and the index after its last bin, and the same of its settings (R, 4).
        accepts: whether each bin takes each item (B, items).
        candidates: written, line among the K lines, object among the W objects, bin and setting, (4, most) each.
        places: written, position of the object from the robot's base (most,) [m].

    Returns:
        The number of candidates.
    """
    count = 0
    for k in range(x.shape[0]):
        r = robot[k]
        for j in range(x.shape[1]):
            place = x[k, j] - bases[r]
            if not (can_take[r, kinds[k, j]] and numbers[NEAR_LOW] <= place <= numbers[NEAR_HIGH]):
                continue
            for site in range(ranges[r, 0], ranges[r, 1]):
                if accepts[site, kinds[k, j]]:
                    for setting in range(ranges[r, 2], ranges[r, 3]):
                        candidates[0, count], candidates[1, count] = k, j
                        candidates[2, count], candidates[3, count] = site, setting
                        places[count] = place
                        count += 1
    return count


@kernel_part
def count_coming(numbers: Floats, x: Floats, since: Floats, kinds: Ints, able: Bools, base: float, time: float) -> int:
    """Objects of one line that a robot takes, from the camera to the end of its window."""
    ride, end, count = numbers[SPEED] * time, base + numbers[NEAR_HIGH], 0
    begin = _first_below(x, ride, min(numbers[SIGHT_HIGH], end), True)
    for j in range(begin, len(x)):
        place = x[j] + ride
        if place < numbers[SIGHT_LOW]:
            break
        count += 1 if since[j] <= time and able[kinds[j]] else 0
    return count
