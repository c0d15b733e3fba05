"""Observations of lines, row by row: what `observation` declares. Compiled; see `pnt_gym.compiled`."""

from __future__ import annotations

import math

import numpy as np

from pnt_gym.cells.base.features import encoded
from pnt_gym.cells.line.observation import MIN_RATE, ChoiceFeatures, LineFeatures
from pnt_gym.cells.line.rows import LineState, Rider, Tables
from pnt_gym.cells.line.sight import count_coming
from pnt_gym.compiled import empty_rows, kernel, kernel_part
from pnt_gym.rows import Floats2, Ints1, Rows2, Singles2

LINE_FEATURES, CHOICE_FEATURES = LineFeatures.dtype, ChoiceFeatures.dtype
_encoded = kernel_part(encoded)


@kernel
def fill_observations(
    tables: Tables,
    state: LineState,
    riders: Rows2[Rider],
    robots: Ints1,
    lines: Ints1,
    line_scaling: Floats2,
    choice_scaling: Floats2,
    observations: Singles2,
) -> None:
    """Write the observations of robots in some lines; a robot that does not decide sees no choices.

    Args:
        tables: what the level says.
        state: state of the lines.
        riders: objects of all lines (N, M).
        robots: observing robots (N,).
        lines: indices of the lines (K,).
        line_scaling: centre and scale of the features of a line (2, F).
        choice_scaling: centre and scale of the features of a choice (2, G).
        observations: written (N, F + choices G).
    """
    of_line, of_choice = empty_rows(1, LINE_FEATURES), empty_rows(1, CHOICE_FEATURES)
    line_values, choice_values = of_line.view(np.float64), of_choice.view(np.float64)
    head, width = len(line_values), len(choice_values)
    for n in lines:
        count, robot = 0, int(robots[n])
        for c in range(state.choices.shape[1]):
            begin, choice = head + c * width, state.choices[n, c]
            count += choice.real
            if not (choice.real and robot == state.turns[n].robot):
                observations[n, begin : begin + width] = 0.0
                continue
            features = of_choice[0]
            features.real, features.lift, features.cycle, features.wait = 1.0, choice.lift, choice.cycle, choice.wait
            features.pick_x, features.pick_y = choice.pick[0], choice.pick[1]
            features.slack, features.value, features.chance = choice.leave - choice.lift, choice.value, choice.chance
            features.ln_rate = math.log(max(choice.value * choice.chance / choice.cycle, MIN_RATE))
            features.percent, features.distance = choice.percent, math.hypot(choice.away[0], choice.away[1])
            features.stop_x, features.stop_y = choice.stop[0], choice.stop[1]
            features.crowd, features.heirs = choice.crowd, choice.heirs
            features.reaches, features.queue = choice.reaches, choice.queue
            for k in range(width):
                observations[n, begin + k] = _encoded(choice_values[k], choice_scaling[0, k], choice_scaling[1, k])
        line = of_line[0]
        clock, arms = state.turns[n].clock, state.arms[n]
        line.gone = min(clock / tables.line[0].duration, 1.0)
        for k in range(len(line.turn)):
            line.turn[k] = k == robot
            line.busy[k] = max(arms[k].expected - clock, 0.0) if k < len(arms) else 0.0
        line.hand_x, line.hand_y = arms[robot].hand[0], arms[robot].hand[1]
        line.coming = count_coming(tables, riders[n], state.accounts[n], robot, clock)
        line.possible = count
        for k in range(head):
            observations[n, k] = _encoded(line_values[k], line_scaling[0, k], line_scaling[1, k])
