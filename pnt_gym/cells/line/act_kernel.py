"""Results of decisions by a table of throws, and the ends of cycles, in machine code; see `pnt_gym.compiled`."""

from __future__ import annotations

import math

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.line.chance_kernel import landing_chance
from pnt_gym.cells.line.throwing_kernel import fading_time
from pnt_gym.compiled import compile_for, kernel_part

# Columns of the numbers of a choice, as `PicksAndThrows` has them.
PERCENT, PICK, AWAY, LIFT, WAIT, THROWING, STOP = 0, 1, 4, 6, 7, 9, 10
# Limits of the hand at full performance [m/s, m/s2, m/s3]; speed of the belt [m/s]; whether hands ride with it; speed
# and share of the fading; time after which a robot without a choice looks again [s]; length of a work shift [s].
VELOCITY, ACCELERATION, JERK, SPEED, RIDES, USUAL_SPEED, MOST_SHARE, IDLE, DURATION = range(9)


@kernel_part
def _redrawn(draw: float, attempts: int, stretch: float) -> float:
    """Uniform draw of a later attempt, as `stream.redraw`."""
    if draw < 1.0:
        for _ in range(attempts):
            draw = draw * stretch % 1.0
    return draw


@compile_for(
    "void(i8[:], i8[:], b1[:, :], i8[:, :], i8[:, :], f8[:, :, :], i8[:, :], f8[:, :], f8[:, :], i8[:, :], f8,"
    "b1[:, :, :], f8[:], f8[:], f8[:], f8[:, :, :], b1[:, ::1], i8[::1])"
)
def throw_by_table(
    robot: Ints,
    choice: Ints,
    real: Bools,
    index: Ints,
    bins: Ints,
    numbers: Floats,
    kinds: Ints,
    draws: Floats,
    luck: Floats,
    attempts: Ints,
    stretch: float,
    accepts: Bools,
    settings: Floats,
    edges: Floats,
    picked: Floats,
    landed: Floats,
    results: Bools,
    ended_in: Ints,
) -> None:
    """Write the results of the choices of N robots, as `TableThrows.predict`; nothing happens without a choice.

    Args:
        robot: deciding robots (N,).
        choice: index of each robot's choice (N,).
        real: whether each choice exists (N, choices).
        index: objects of the choices (N, choices).
        bins: bins of the choices (N, choices).
        numbers: numbers of the choices (N, choices, columns).
        kinds: true items of all objects (N, M).
        draws: uniform draws of whether the cups seal (N, M).
        luck: uniform draws of where the throws end (N, M).
        attempts: earlier attempts to pick each object (N, M).
        stretch: factor between the draws of two attempts.
        accepts: whether bin B of robot R takes item K (R, K, B).
        settings: speed settings of the table of throws (P,) [%].
        edges: borders between the table's classes of distance (D - 1,) [m].
        picked: shares of cups that seal (K,).
        landed: shares of throws that end in their bins (K, P, D).
        results: written, whether the cup seals, the object ends in its bin, and the bin takes the object (3, N).
        ended_in: written, bin of the object, -1 for none (N,).
    """
    for n in range(len(robot)):
        results[:, n], ended_in[n], c = False, -1, choice[n]
        if not real[n, c]:
            continue
        i, into = index[n, c], bins[n, c]
        kind, tries, x, y = kinds[n, i], attempts[n, i], numbers[n, c, AWAY], numbers[n, c, AWAY + 1]
        chance = landing_chance(kind, numbers[n, c, PERCENT], math.sqrt(x * x + y * y), settings, edges, landed)
        results[0, n] = _redrawn(draws[n, i], tries, stretch) >= 1.0 - picked[kind]
        results[1, n] = results[0, n] and _redrawn(luck[n, i], tries, stretch) < chance
        results[2, n] = results[1, n] and accepts[robot[n], kind, into]
        if results[1, n]:
            ended_in[n] = into


@kernel_part
def _stop_time(line: Floats, percent: float) -> float:
    """Time until an empty hand that rides with the belt stands still, as `stop_motion` [s]."""
    velocity, peak = line[VELOCITY] * percent / 100.0, line[ACCELERATION] * percent / 100.0
    jerk = line[JERK] * percent / 100.0
    shortest = 2.0 * line[SPEED] / (line[MOST_SHARE] * peak)
    return fading_time(line[SPEED], line[USUAL_SPEED], velocity, peak, jerk, shortest)


@kernel_part
def _end_cycle(line: Floats, decision: Floats, picked: bool, hand: Floats) -> float:
    """Write the place at which a hand is free after a decision; returns the time until then [s]."""
    hand[:] = decision[STOP : STOP + 3]
    if picked:
        return decision[LIFT] + decision[THROWING]
    stop_time = _stop_time(line, decision[PERCENT]) if line[RIDES] > 0.0 else 0.0
    hand[:] = decision[PICK : PICK + 3]
    if line[RIDES] > 0.0:
        # The velocity of the belt fades evenly on average: its way is s T / 2.
        hand[0] += line[SPEED] * stop_time / 2.0
    return decision[LIFT] + stop_time


@compile_for(
    "void(f8[:], i8[:], i8[:], i8[:], b1[:, :], i8[:, :], f8[:, :, :], b1[:], b1[:], i8[:], f8[:], f8[:, :],"
    "f8[:, ::1], f8[:, ::1], f8[:, ::1], f8[:, :, ::1], f8[:, :], i8[:, :], i8[:, :], i8[:, :], i8[:, :],"
    "f8[:], i8[:, ::1], f8[:, ::1])"
)
def end_cycles(
    line: Floats,
    fates: Ints,
    robot: Ints,
    choice: Ints,
    real: Bools,
    index: Ints,
    numbers: Floats,
    picked: Bools,
    belongs: Bools,
    bins: Ints,
    clock: Floats,
    worth: Floats,
    free: Floats,
    expected: Floats,
    busy: Floats,
    hand: Floats,
    since: Floats,
    attempts: Ints,
    fate: Ints,
    taker: Ints,
    ended_in: Ints,
    old_since: Floats,
    old: Ints,
    results: Floats,
) -> None:
    """Write when and where the hands of N robots are free after their choices, and enter the attempts in the books.

    Args:
        line: numbers of the line by the names above.
        fates: values of the fates of an object that is sorted, in a wrong bin, on the floor, and in a hand (4,).
        robot: deciding robots (N,).
        choice: index of each robot's choice (N,).
        real: whether each choice exists (N, choices).
        index: objects of the choices (N, choices).
        numbers: numbers of the choices (N, choices, columns).
        picked: whether each cup sealed (N,).
        belongs: whether the objects lie in bins that take them (N,).
        bins: bins in which the objects lie, -1 for none (N,).
        clock: times of the decisions (N,) [s].
        worth: values of all objects (N, M).
        free: written, times at which the robots are free (N, R) [s].
        expected: written, the same as planned (N, R) [s].
        busy: written, working times (N, R) [s].
        hand: written, places of the hands when they are free (N, R, 3) [m].
        since: written, times from which all objects may be taken (N, M) [s].
        attempts: written, attempts to pick each object (N, M).
        fate: written, fates of all objects (N, M).
        taker: written, robots that took the objects (N, M).
        ended_in: written, bins of the objects (N, M).
        old_since: written, entry of the chosen object before (N,) [s].
        old: written, the other entries of the chosen object before, in the order above (4, N).
        results: written, times at which the deciding robots are free [s], and values brought into bins (2, N).
    """
    for n in range(len(robot)):
        r, decision, i = robot[n], numbers[n, choice[n]], index[n, choice[n]]
        old_since[n], old[0, n], old[1, n] = since[n, i], attempts[n, i], fate[n, i]
        old[2, n], old[3, n], results[1, n] = taker[n, i], ended_in[n, i], 0.0
        if not real[n, choice[n]]:
            free[n, r] = expected[n, r] = results[0, n] = clock[n] + line[IDLE]
            continue
        cycle = _end_cycle(line, decision, picked[n], hand[n, r])
        end = clock[n] + cycle
        free[n, r] = results[0, n] = end
        expected[n, r] = clock[n] + (decision[LIFT] + decision[THROWING])
        busy[n, r] += cycle - decision[WAIT]
        attempts[n, i] += 1
        since[n, i] = clock[n] + decision[LIFT]
        if picked[n]:
            since[n, i], taker[n, i], fate[n, i] = math.inf, r, fates[3]
            if end <= line[DURATION]:
                fate[n, i] = fates[0] if belongs[n] else fates[1] if bins[n] >= 0 else fates[2]
                ended_in[n, i] = bins[n]
        if end <= line[DURATION] and belongs[n]:
            results[1, n] = worth[n, i]
