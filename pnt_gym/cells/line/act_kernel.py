"""Results of decisions by a table of throws, and the ends of cycles, in machine code; see `pnt_gym.compiled`."""

from __future__ import annotations

import math

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.compiled import compile_for, kernel_part

# Columns of the numbers of a choice, as `PicksAndThrows` has them.
PERCENT, PICK, AWAY, LIFT, WAIT, THROWING, STOP = 0, 1, 4, 6, 7, 9, 10
# Limits of the hand at full performance [m/s, m/s2, m/s3]; speed of the belt [m/s]; whether hands ride with it; speed
# and share of the fading; time after which a robot without a choice looks again [s].
VELOCITY, ACCELERATION, JERK, SPEED, RIDES, USUAL_SPEED, MOST_SHARE, IDLE = range(8)


@kernel_part
def _redrawn(draw: float, attempts: int, stretch: float) -> float:
    """Uniform draw of a later attempt, as `stream.redraw`."""
    if draw < 1.0:
        for _ in range(attempts):
            draw = draw * stretch % 1.0
    return draw


@kernel_part
def _landing_chance(
    kind: int, percent: float, distance: float, settings: Floats, edges: Floats, landed: Floats
) -> float:
    """Chance that a held object ends in its bin, as `Chances.landing_chance`."""
    setting = 0
    for p in range(1, len(settings)):
        if abs(percent - settings[p]) < abs(percent - settings[setting]):
            setting = p
    part = 0
    while part < len(edges) and edges[part] < distance:
        part += 1
    return landed[kind, setting, part]


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
        chance = _landing_chance(kind, numbers[n, c, PERCENT], math.sqrt(x * x + y * y), settings, edges, landed)
        results[0, n] = _redrawn(draws[n, i], tries, stretch) >= 1.0 - picked[kind]
        results[1, n] = results[0, n] and _redrawn(luck[n, i], tries, stretch) < chance
        results[2, n] = results[1, n] and accepts[robot[n], kind, into]
        if results[1, n]:
            ended_in[n] = into


@kernel_part
def _fading_time(line: Floats, percent: float) -> float:
    """Time until an empty hand that rides with the belt stands still, as `stop_motion` [s]."""
    velocity, peak = line[VELOCITY] * percent / 100.0, line[ACCELERATION] * percent / 100.0
    jerk, speed = line[JERK] * percent / 100.0, line[SPEED]
    # The bounds of `planning.motion.riding`: T <= (V + s) / A + A / J, and a peak of at most a share of A.
    longest = (velocity + speed) / peak + peak / jerk
    usual = (line[USUAL_SPEED] + speed) / peak + peak / jerk
    return min(longest, max(usual, 2.0 * speed / (line[MOST_SHARE] * peak)))


@compile_for(
    "void(f8[:], i8[:], i8[:], b1[:, :], f8[:, :, :], b1[:], f8[:], f8[:, ::1], f8[:, ::1], f8[:, ::1], f8[:, :, ::1],"
    "f8[::1], f8[::1])"
)
def end_cycles(
    line: Floats,
    robot: Ints,
    choice: Ints,
    real: Bools,
    numbers: Floats,
    picked: Bools,
    clock: Floats,
    free: Floats,
    expected: Floats,
    busy: Floats,
    hand: Floats,
    lifts: Floats,
    ends: Floats,
) -> None:
    """Write when and where the hands of N robots are free after their choices.

    Args:
        line: numbers of the line by the names above.
        robot: deciding robots (N,).
        choice: index of each robot's choice (N,).
        real: whether each choice exists (N, choices).
        numbers: numbers of the choices (N, choices, columns).
        picked: whether each cup sealed (N,).
        clock: times of the decisions (N,) [s].
        free: written, times at which the robots are free (N, R) [s].
        expected: written, the same as planned (N, R) [s].
        busy: written, working times (N, R) [s].
        hand: written, places of the hands when they are free (N, R, 3) [m].
        lifts: written, times of the lifts (N,) [s].
        ends: written, times at which the deciding robots are free (N,) [s].
    """
    for n in range(len(robot)):
        r, decision = robot[n], numbers[n, choice[n]]
        lifts[n] = clock[n] + decision[LIFT]
        if not real[n, choice[n]]:
            free[n, r] = ends[n] = clock[n] + line[IDLE]
            expected[n, r] = clock[n] + line[IDLE]
            continue
        planned = decision[LIFT] + decision[THROWING]
        cycle = planned
        hand[n, r] = decision[STOP : STOP + 3]
        if not picked[n]:
            stop_time = _fading_time(line, decision[PERCENT]) if line[RIDES] > 0.0 else 0.0
            cycle = decision[LIFT] + stop_time
            hand[n, r] = decision[PICK : PICK + 3]
            if line[RIDES] > 0.0:
                # The velocity of the belt fades evenly on average: its way is s T / 2.
                hand[n, r, 0] += line[SPEED] * stop_time / 2.0
        free[n, r] = ends[n] = clock[n] + cycle
        expected[n, r] = clock[n] + planned
        busy[n, r] += cycle - decision[WAIT]


@compile_for(
    "void(i8[:], i8[:], i8[:], i8[:], b1[:], b1[:], i8[:], f8[:], b1[:], i8[:, :], i8[:, :], i8[:, :], i8[:, :], f8[:],"
    "i8[:], i8[:], i8[:], i8[:])"
)
def account_attempts(
    fates: Ints,
    rows: Ints,
    index: Ints,
    robot: Ints,
    picked: Bools,
    belongs: Bools,
    bins: Ints,
    lifts: Floats,
    in_time: Bools,
    attempts: Ints,
    fate: Ints,
    taker: Ints,
    ended_in: Ints,
    new_since: Floats,
    new_attempts: Ints,
    new_fate: Ints,
    new_taker: Ints,
    new_ended_in: Ints,
) -> None:
    """Write the entries of the books for one attempt in each of some lines.

    Args:
        fates: values of the fates of an object that is sorted, in a wrong bin, on the floor, and in a hand (4,).
        rows: indices of the lines (K,).
        index: objects of the attempts (K,).
        robot: deciding robots (N,).
        picked: whether the cups sealed (N,).
        belongs: whether the objects lie in bins that take them (N,).
        bins: bins in which the objects lie, -1 for none (N,).
        lifts: times of the lifts (N,) [s].
        in_time: whether the cycles end within the work shift (N,).
        attempts: entries before of all objects (N, M).
        fate: the same.
        taker: the same.
        ended_in: the same.
        new_since: written, times from which the objects may be taken (K,) [s].
        new_attempts: written, attempts (K,).
        new_fate: written, fates (K,).
        new_taker: written, robots that took the objects (K,).
        new_ended_in: written, bins of the objects (K,).
    """
    for k in range(len(rows)):
        n, i = rows[k], index[k]
        new_since[k], new_attempts[k] = lifts[n], attempts[n, i] + 1
        new_fate[k], new_taker[k], new_ended_in[k] = fate[n, i], taker[n, i], ended_in[n, i]
        if picked[n]:
            new_since[k], new_taker[k], new_fate[k] = math.inf, robot[n], fates[3]
            if in_time[n]:
                new_fate[k] = fates[0] if belongs[n] else fates[1] if bins[n] >= 0 else fates[2]
                new_ended_in[k] = bins[n]
