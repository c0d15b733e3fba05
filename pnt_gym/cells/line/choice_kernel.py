"""Choices among the options of robots, line by line in machine code; see `pnt_gym.compiled`."""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.line.chance_kernel import landing_chance
from pnt_gym.compiled import compile_for, kernel_part

# Rows of the numbers of choices and options, in the order of the fields of `Choices`: percentage; pick; way to the bin;
# lift, wait, leave and throwing; stop; the other rows only choices have.
PERCENT, PICK, AWAY, LIFT, WAIT, LEAVE, THROWING, STOP = 0, 1, 4, 6, 7, 8, 9, 10
VALUE, CHANCE, CROWD, HEIRS, REACHES, QUEUE = range(13, 19)
OPTION_ROWS, CHOICE_ROWS = 13, 19
# Numbers of a line: price of a second; speed of the belt [m/s]; upstream end of windows [m]; distance of objects near
# the stop of a hand [m].
PRICE, SPEED, WINDOW, NEAR = range(4)
# Tables of the order of choices: numbers of a line; settings, edges, seals and landings of the table; numbers,
# and object and bin, of a choice that does not exist.
ORDER = "Tuple((f8[::1], f8[::1], f8[::1], f8[::1], f8[:, :, ::1], f8[::1], i8[::1]))"
OrderArrays: TypeAlias = tuple[Floats, Floats, Floats, Floats, Floats, Floats, Ints]
# Choices of all lines (N, choices): whether each exists, object, bin; numbers (N, choices, CHOICE_ROWS).
CHOICES = "Tuple((b1[:, ::1], i8[:, ::1], i8[:, ::1], f8[:, :, ::1]))"
ChoiceArrays: TypeAlias = tuple[Bools, Ints, Ints, Floats]


@kernel_part
def _available(x: Floats, kinds: Ints, can_take: Bools, places: Floats) -> None:
    """Write the positions of objects that a robot takes; other objects lie at infinity."""
    for j in range(len(x)):
        places[j] = x[j] if can_take[kinds[j]] else math.inf


@kernel_part
def _count_near(places: Floats, way: float, stop: float, near: float) -> int:
    """Objects that lie near a place after a way; the loop becomes vector instructions."""
    count = 0
    for j in range(len(places)):
        count += 1 if abs(places[j] + way - stop) <= near else 0
    return count


@kernel_part
def _count_between(places: Floats, low: float, high: float) -> int:
    """Objects from one place to another; the loop becomes vector instructions."""
    count = 0
    for j in range(len(places)):
        count += 1 if (places[j] >= low) & (places[j] <= high) else 0
    return count


@kernel_part
def _write_features(
    numbers: Floats, x: float, kind: int, robot: int, places: Floats, can_take: Bools, bases: Floats, choice: Floats
) -> None:
    """Write the features of a choice that depend on the other objects in sight.

    Args:
        numbers: numbers of the line by the names above.
        x: position of the object [m].
        kind: item as which the object is classified.
        robot: deciding robot.
        places: positions of the objects that each robot takes, infinite for the other objects (R, W) [m].
        can_take: whether each robot takes each item (R, items).
        bases: positions of the robots (R,) [m].
        choice: written.
    """
    speed, heirs, heir = numbers[SPEED], 0, -1
    way, stop = speed * (choice[LIFT] + choice[THROWING]), bases[robot] + choice[STOP]
    for r in range(robot + 1, len(bases)):
        if can_take[r, kind]:
            heirs += 1
            heir = r if heir < 0 else heir
    # The object itself does not count.
    crowd = _count_near(places[robot], way, stop, numbers[NEAR]) - (abs(x + way - stop) <= numbers[NEAR])
    choice[CROWD], choice[HEIRS], choice[QUEUE], choice[REACHES] = crowd, heirs, 0.0, 0.0
    if heir >= 0:
        window = bases[heir] + numbers[WINDOW]
        choice[QUEUE], choice[REACHES] = _count_between(places[heir], x, window), max(window - x, 0.0) / speed


@kernel_part
def _place_by_score(scores: Floats, options: Ints, count: int, score: float, option: int) -> int:
    """Insert an option among the best so far, after those of the same score; returns the number of the best."""
    if count == len(scores) and not score > scores[count - 1]:
        return count
    count = min(count + 1, len(scores))
    k = count - 1
    while k > 0 and score > scores[k - 1]:
        scores[k], options[k] = scores[k - 1], options[k - 1]
        k -= 1
    scores[k], options[k] = score, option
    return count


@compile_for(
    f"void({ORDER}, b1[:, ::1], f8[::1], i8[::1], i8[::1], i8[:, ::1], f8[:, ::1], i8[:, ::1], i8[:, ::1], f8[:, :],"
    f"f8[:, :], b1[::1], {CHOICES})"
)
def choose_options(
    order: OrderArrays,
    can_take: Bools,
    bases: Floats,
    lines: Ints,
    robot: Ints,
    index: Ints,
    x: Floats,
    kinds: Ints,
    owners: Ints,
    options: Floats,
    worth: Floats,
    has_choice: Bools,
    choices: ChoiceArrays,
) -> None:
    """Write the best options of some lines to their choices, by expected value less the price of their time.

    Args:
        order: tables as named above.
        can_take: whether each robot takes each item (R, items).
        bases: positions of the robots (R,) [m].
        lines: indices of the lines (K,).
        robot: deciding robots (K,).
        index: indices of the objects in sight (K, W).
        x: positions of these (K, W) [m].
        kinds: items as which these are classified (K, W).
        owners: of each option, line among the K lines, not decreasing, object among those in sight, and bin (3, C).
        options: numbers of the options by the columns above (C, OPTION_ROWS).
        worth: values of all objects (N, M).
        has_choice: written, whether a choice exists (K,).
        choices: written at the lines, as named above.
    """
    numbers, settings, edges, picked, landed, blank, blank_integers = order
    real, chosen_index, chosen_bin, choice_numbers = choices
    rows, places, bins = owners[0], owners[1], owners[2]
    most, robots = real.shape[1], len(bases)
    scores, best = np.empty(most), np.empty(most, dtype=np.int64)
    chances, available, begin = np.empty(len(rows)), np.empty((robots, x.shape[1])), 0
    for k in range(len(lines)):
        line, count = lines[k], 0
        while begin < len(rows) and rows[begin] == k:
            option, kind = options[begin], kinds[k, places[begin]]
            distance = math.sqrt(option[AWAY] * option[AWAY] + option[AWAY + 1] * option[AWAY + 1])
            chances[begin] = picked[kind] * landing_chance(kind, option[PERCENT], distance, settings, edges, landed)
            value = worth[line, index[k, places[begin]]] * chances[begin]
            score = value - numbers[PRICE] * (option[LIFT] + option[THROWING])
            count = _place_by_score(scores, best, count, score, begin)
            begin += 1
        has_choice[k] = count > 0
        for r in range(robot[k], robots if count > 0 else 0):
            _available(x[k], kinds[k], can_take[r], available[r])
        for n in range(most):
            real[line, n], choice = n < count, choice_numbers[line, n]
            if n >= count:
                chosen_index[line, n], chosen_bin[line, n], choice[:] = blank_integers[0], blank_integers[1], blank
                continue
            c = best[n]
            place = places[c]
            chosen_index[line, n], chosen_bin[line, n] = index[k, place], bins[c]
            choice[:OPTION_ROWS] = options[c]
            choice[VALUE], choice[CHANCE] = worth[line, index[k, place]], chances[c]
            _write_features(numbers, x[k, place], kinds[k, place], robot[k], available, can_take, bases, choice)
