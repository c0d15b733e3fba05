"""Lines from decision to decision in one call of machine code, for straight movers; see `pnt_gym.compiled`.

The stages are those that `Turns`, `Chooser` and `StraightPlanner` call one by one for other robots.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.line.choice_kernel import CHOICES, ORDER, ChoiceArrays, OrderArrays, choose_options
from pnt_gym.cells.line.meeting_kernel import meet_candidates
from pnt_gym.cells.line.throwing_kernel import finish_short_throws, plan_throws
from pnt_gym.cells.line.turn_kernel import DURATION, IDLE, list_candidates, next_turns, show_objects
from pnt_gym.compiled import compile_for, kernel_part

# Tuples of arrays. Of a line: numbers and tables as `turn_kernel` names them, in the order of its arguments; ranges and
# items of the bins; index of each bin among its robot's bins; numbers, settings and bins' centres of `meeting_kernel`.
LINE = (
    "Tuple((f8[::1], b1[:, ::1], f8[::1], i8[::1], f8[:, ::1], i8[:, ::1], b1[:, ::1], i8[::1], f8[::1],"
    "f8[:, ::1], f8[:, ::1]))"
)
# Of a state: clock, deciding robot, times at which robots are free and are expected to be free, hands.
STATE = "Tuple((f8[::1], i8[::1], f8[:, ::1], f8[:, ::1], f8[:, :, ::1]))"
# Of objects: positions, times from which they may be taken, values, classified items, extents, depth, place across.
OBJECTS = "f8[:, :], f8[:, :], f8[:, :], i8[:, :], f8[:, :, :], f8[:, :], f8[:, :]"
# Of sights with options: lines; objects, positions and items in sight; line, object and bin of each option, numbers of
# the options; short throws and their numbers.
OPTIONS = "Tuple((i8[::1], i8[:, ::1], f8[:, ::1], i8[:, ::1], i8[:, ::1], f8[:, ::1], i8[::1], f8[:, ::1]))"
OptionArrays: TypeAlias = tuple[Ints, Ints, Floats, Ints, Ints, Floats, Ints, Floats]
LineArrays: TypeAlias = tuple[Floats, Bools, Floats, Ints, Floats, Ints, Bools, Ints, Floats, Floats, Floats]
StateArrays: TypeAlias = tuple[Floats, Ints, Floats, Floats, Floats]


@kernel_part
def _plan_options(
    line: LineArrays,
    state: StateArrays,
    lines: Ints,
    ends: Ints,
    x: Floats,
    since: Floats,
    kinds: Ints,
    size: Floats,
    known_depth: Floats,
    lane_y: Floats,
) -> OptionArrays:
    """The options of the deciding robots of some lines, as `Chooser.sight` and `StraightPlanner.plan`."""
    numbers, can_take, bases, _, _, ranges, accepts, site_bins, cell, settings, sites = line
    clock, robots, _, _, hands = state
    count, width = len(lines), 1
    for k in range(count):
        width = max(width, ends[k, 1] - ends[k, 0])
    index, seen_kinds = np.empty((count, width), dtype=np.int64), np.empty((count, width), dtype=np.int64)
    seen_x, hand, robot = np.empty((count, width)), np.empty((count, 3)), np.empty(count, dtype=np.int64)
    show_objects(numbers, lines, clock, x, since, kinds, ends, index, seen_x, seen_kinds)
    most = 0
    for k in range(count):
        robot[k] = robots[lines[k]]
        hand[k] = hands[lines[k], robot[k]]
        begin, end, settings_count = ranges[robot[k], 0], ranges[robot[k], 1], ranges[robot[k], 3] - ranges[robot[k], 2]
        most = max(most, (end - begin) * settings_count)
    candidates, places = np.empty((4, most * count * width), dtype=np.int64), np.empty(most * count * width)
    count = list_candidates(numbers, seen_x, seen_kinds, robot, can_take, bases, ranges, accepts, candidates, places)
    candidates, places = candidates[:, :count], places[:count]
    met, times, picks, acceleration, waits = meet_candidates(
        cell, settings, candidates, places, lines, index, hand, size, known_depth, lane_y
    )
    chosen, options, short, columns = plan_throws(
        cell, settings, sites, candidates, met, times, picks, acceleration, waits
    )
    owners = np.empty((3, len(chosen)), dtype=np.int64)
    for g in range(len(chosen)):
        c = chosen[g]
        owners[0, g], owners[1, g], owners[2, g] = candidates[0, c], candidates[1, c], site_bins[candidates[2, c]]
    return lines, index, seen_x, seen_kinds, owners, options, short, columns


@kernel_part
def _choose(
    line: LineArrays,
    order: OrderArrays,
    state: StateArrays,
    choices: ChoiceArrays,
    worth: Floats,
    plan: OptionArrays,
) -> Ints:
    """Write the choices of the lines of a plan; returns the lines without one, whose robots look again later."""
    lines, index, x, kinds, owners, options, _, _ = plan
    robots, free = state[1], state[2]
    has_choice, robot, left = np.empty(len(lines), dtype=np.bool_), robots[lines], np.empty_like(lines)
    choose_options(order, line[1], line[2], lines, robot, index, x, kinds, owners, options, worth, has_choice, choices)
    count = 0
    for k in range(len(lines)):
        if not has_choice[k]:
            # An object is near, so a robot that cannot take one looks again after the shortest time.
            free[lines[k], robot[k]] += line[0][IDLE]
            left[count] = lines[k]
            count += 1
    return left[:count]


@kernel_part
def _finish(line: LineArrays, state: StateArrays, choices: ChoiceArrays, lines: Ints) -> None:
    """Remove the choices of lines whose shifts are over; no robot is expected before it is free."""
    clock, free, expected, real, duration = state[0], state[2], state[3], choices[0], line[0][DURATION]
    for n in lines:
        if clock[n] >= duration:
            real[n] = False
        for r in range(free.shape[1]):
            expected[n, r] = max(expected[n, r], free[n, r])


@compile_for(f"Tuple((b1, {OPTIONS}))({LINE}, {ORDER}, {STATE}, {CHOICES}, {OBJECTS}, i8[::1], i8)")
def next_decisions(
    line: LineArrays,
    order: OrderArrays,
    state: StateArrays,
    choices: ChoiceArrays,
    x: Floats,
    since: Floats,
    worth: Floats,
    kinds: Ints,
    size: Floats,
    known_depth: Floats,
    lane_y: Floats,
    lines: Ints,
    looks: int,
) -> tuple[bool, OptionArrays]:
    """Advance some lines to their next decisions, or to the end of their shifts, or until numpy's roots are needed.

    Args:
        line: tables of a line.
        order: tables of the order of choices.
        state: arrays of the states of all lines, written.
        choices: arrays of the choices of all lines, written.
        x: positions of the objects when the work shift begins (N, M) [m].
        since: times from which the objects may be taken (N, M) [s].
        worth: values of the objects (N, M).
        kinds: items as which these are classified (N, M).
        size: extents of the objects (N, M, 3) [m].
        known_depth: known depth of the centre of mass (N, M) [m].
        lane_y: positions across the belt (N, M) [m].
        lines: indices of the lines (K,).
        looks: looks without a result in a row before a line is declared impossible.

    Returns:
        Whether every line came to an end, and the options of the lines that wait for the times of short throws.
    """
    numbers, can_take, bases, down_robots, down_times = line[0], line[1], line[2], line[3], line[4]
    clock, robot, free, seekers = state[0], state[1], state[2], lines
    for _ in range(looks):
        has_candidates, ends = np.empty(len(seekers), dtype=np.bool_), np.empty((len(seekers), 2), dtype=np.int64)
        if not next_turns(
            numbers, seekers, clock, robot, free, x, since, kinds, can_take, bases, down_robots, down_times,
            has_candidates, ends,
        ):  # fmt: skip
            break
        seekers, ends = seekers[has_candidates], ends[has_candidates]
        plan = _plan_options(line, state, seekers, ends, x, since, kinds, size, known_depth, lane_y)
        if len(seekers) == 0 or len(plan[6]) > 0:
            _finish(line, state, choices, lines)
            return True, plan
        seekers = _choose(line, order, state, choices, worth, plan)
    nothing = np.empty((0, 2), dtype=np.int64)
    return False, _plan_options(line, state, lines[:0], nothing, x, since, kinds, size, known_depth, lane_y)


@compile_for(f"i8[::1]({LINE}, {ORDER}, {STATE}, {CHOICES}, f8[:, :], {OPTIONS}, f8[:, :])")
def choose_after_roots(
    line: LineArrays,
    order: OrderArrays,
    state: StateArrays,
    choices: ChoiceArrays,
    worth: Floats,
    plan: OptionArrays,
    roots: Floats,
) -> Ints:
    """Write choices among options with short throws; returns the lines that find no choice and look again.

    Args:
        line: see `next_decisions`.
        order: see `next_decisions`.
        state: see `next_decisions`.
        choices: see `next_decisions`.
        worth: see `next_decisions`.
        plan: options of the waiting lines.
        roots: cube roots of the first two rows of the numbers of the short throws (2, S).
    """
    finish_short_throws(line[8], plan[6], plan[7], roots, plan[5])
    return _choose(line, order, state, choices, worth, plan)
