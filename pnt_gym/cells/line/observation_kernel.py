"""Observations of lines, row by row in machine code: what `observation` defines; see `pnt_gym.compiled`."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.line.turn_kernel import count_coming
from pnt_gym.compiled import compile_for, kernel_part

# Columns of the numbers of a choice, as `Choices` has them.
PERCENT, PICK, AWAY, LIFT, WAIT, LEAVE, THROWING, STOP = 0, 1, 4, 6, 7, 8, 9, 10
VALUE, CHANCE, CROWD, HEIRS, REACHES, QUEUE = range(13, 19)


@kernel_part
def _encode(value: float, centre: float, scale: float, clip: float) -> float:
    """Entry of an observation, as `FeatureTable.encode`."""
    return min(max((value - centre) / scale, -clip), clip)


@kernel_part
def _write_choice(choice: Floats, least_rate: float, values: Floats) -> None:
    """Write the features of a real choice in the order of `CHOICE_TABLE`."""
    rate = choice[VALUE] * choice[CHANCE] / (choice[LIFT] + choice[THROWING])
    values[0], values[8] = 1.0, math.log(max(rate, least_rate))
    values[1], values[2] = choice[PICK], choice[PICK + 1]
    values[3], values[4], values[5] = choice[LIFT], choice[LIFT] + choice[THROWING], choice[WAIT]
    values[6], values[7], values[9] = choice[LEAVE] - choice[LIFT], choice[VALUE], choice[CHANCE]
    values[10], values[11] = choice[PERCENT], math.hypot(choice[AWAY], choice[AWAY + 1])
    values[12], values[13] = choice[STOP], choice[STOP + 1]
    values[14], values[15], values[16], values[17] = choice[CROWD], choice[HEIRS], choice[REACHES], choice[QUEUE]


@compile_for(
    "void(f8[::1], b1[:, ::1], f8[::1], f8, f8, f8, i8[:], f8[:], i8[:], b1[:], f8[:, :, :], f8[:, :], b1[:, :],"
    "f8[:, :, :], f8[:, :], f8[:, :], i8[:, :], f8[:, ::1], f8[:, ::1], f4[:, ::1])"
)
def write_observations(
    numbers: Floats,
    can_take: Bools,
    bases: Floats,
    duration: float,
    clip: float,
    least_rate: float,
    lines: Ints,
    clock: Floats,
    robot: Ints,
    is_turn: Bools,
    hand: Floats,
    expected: Floats,
    real: Bools,
    choices: Floats,
    x: Floats,
    since: Floats,
    kinds: Ints,
    line_scale: Floats,
    choice_scale: Floats,
    observations: NDArray[np.float32],
) -> None:
    """Write the observations of robots of some lines.

    Args:
        numbers: numbers of the line as `turn_kernel` names them.
        can_take: whether each robot takes each item (R, items).
        bases: positions of the robots (R,) [m].
        duration: length of a work shift [s].
        clip: bound of every entry.
        least_rate: value per second below which choices count as equal [1/s].
        lines: indices of the lines (K,).
        clock: times of the decisions (N,) [s].
        robot: observing robots (N,).
        is_turn: whether the choices are those of the robot; otherwise none is shown (N,).
        hand: places of the hands (N, R, 3) [m].
        expected: times at which the robots are expected to be free (N, R) [s].
        real: whether each choice exists (N, choices).
        choices: numbers of the choices (N, choices, columns).
        x: positions of the objects when the work shift begins (N, M) [m].
        since: times from which the objects may be taken (N, M) [s].
        kinds: items as which these are classified (N, M).
        line_scale: centre and scale of the features of `LINE_TABLE` (2, F).
        choice_scale: centre and scale of the features of `CHOICE_TABLE` (2, G).
        observations: written (N, F + choices G).
    """
    head, width = line_scale.shape[1], choice_scale.shape[1]
    most_robots = (head - 5) // 2
    line, values = np.empty(head), np.empty(width)
    for place in range(len(lines)):
        n, count = int(lines[place]), 0
        r = int(robot[n])
        line[0] = min(clock[n] / duration, 1.0)
        for k in range(most_robots):
            line[1 + k] = k == r
            line[1 + most_robots + k] = max(expected[n, k] - clock[n], 0.0) if k < expected.shape[1] else 0.0
        for c in range(real.shape[1]):
            begin = head + c * width
            count += real[n, c]
            if not (real[n, c] and is_turn[n]):
                observations[n, begin : begin + width] = 0.0
                continue
            _write_choice(choices[n, c], least_rate, values)
            for k in range(width):
                observations[n, begin + k] = _encode(values[k], choice_scale[0, k], choice_scale[1, k], clip)
        line[head - 4], line[head - 3], line[head - 1] = hand[n, r, 0], hand[n, r, 1], count
        line[head - 2] = count_coming(numbers, x[n], since[n], kinds[n], can_take[r], float(bases[r]), float(clock[n]))
        for k in range(head):
            observations[n, k] = _encode(line[k], line_scale[0, k], line_scale[1, k], clip)
