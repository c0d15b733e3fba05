"""Choices among the planned throws of robots, line by line. Compiled; see `pnt_gym.compiled`."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from pnt_gym.cells.line.rows import IDLE_TIME, ChanceTable, Choice, LineState, Seen, Tables
from pnt_gym.compiled import kernel, kernel_part
from pnt_gym.rows import Floats2, Ints1, Rows1, Rows2

NEAR: Final = 0.25
"""Objects within this distance along the belt from where a hand stops count as near it [m]."""


@kernel_part
def landing_chance(table: ChanceTable, kind: int, choice: Choice) -> float:
    """Chance that a held object ends in its bin, at the nearest speed setting and in the class of the distance."""
    setting, percent = 0, choice.percent
    distance = math.sqrt(choice.away[0] * choice.away[0] + choice.away[1] * choice.away[1])
    for p in range(1, len(table.percent)):
        if abs(percent - table.percent[p]) < abs(percent - table.percent[setting]):
            setting = p
    part = 0
    while part < len(table.edges) and table.edges[part] < distance:
        part += 1
    return table.landed[kind, setting, part]


@kernel_part
def _write_features(tables: Tables, robot: int, seen: Rows1[Seen], places: Floats2, choice: Choice) -> None:
    """Write the features of a choice that depend on the other objects in sight.

    Args:
        tables: what the level says.
        robot: deciding robot.
        seen: objects in sight (W,).
        places: positions of the objects that each robot takes, infinite for the other objects (R, W) [m].
        choice: written.
    """
    line, stations, x, kind = tables.line[0], tables.stations, seen[choice.place].x, seen[choice.place].kind
    way, stop, heirs, heir = line.speed * choice.cycle, stations[robot].base + choice.stop[0], 0, -1
    for r in range(robot + 1, len(stations)):
        if tables.can_take[r, kind]:
            heirs += 1
            heir = r if heir < 0 else heir
    # Both counts become vector instructions. The object itself does not count.
    crowd, own = 0, places[robot]
    for j in range(len(own)):
        crowd += 1 if abs(own[j] + way - stop) <= NEAR else 0
    choice.crowd = crowd - (abs(x + way - stop) <= NEAR)
    choice.heirs, choice.queue, choice.reaches = heirs, 0.0, 0.0
    if heir >= 0:
        window, queue, other = stations[heir].base + line.window_low, 0, places[heir]
        for j in range(len(other)):
            queue += 1 if (other[j] >= x) & (other[j] <= window) else 0
        choice.queue = queue
        choice.reaches = max(window - x, 0.0) / line.speed


@kernel
def write_choices(tables: Tables, state: LineState, lines: Ints1, seen: Rows2[Seen], planned: Rows1[Choice]) -> Ints1:
    """Write the best planned throws of some lines to their choices, by expected value less the price of their time.

    Args:
        tables: what the level says.
        state: state of the lines; choices are written, the accounts of objects that have a plan, and the arms of robots
            without a choice.
        lines: indices of the lines (K,).
        seen: objects in sight (K, W).
        planned: planned throws in the order of the lines (G,).

    Returns:
        The lines without a choice, whose robots look again later.
    """
    most, robots = state.choices.shape[1], len(tables.stations)
    scores, best, places = np.empty(most), np.empty(most, dtype=np.int64), np.empty((robots, seen.shape[1]))
    left, lefts, begin = np.empty_like(lines), 0, 0
    for k in range(len(lines)):
        n, robot, count = lines[k], state.turns[lines[k]].robot, 0
        while begin < len(planned) and planned[begin].line == k:
            choice = planned[begin]
            state.accounts[n, choice.index].planned = True
            score = choice.value * choice.chance - tables.line[0].price * choice.cycle
            # Among the best so far the throw goes behind those of the same score.
            if count < most or score > scores[count - 1]:
                count = min(count + 1, most)
                rank = count - 1
                while rank > 0 and score > scores[rank - 1]:
                    scores[rank], best[rank] = scores[rank - 1], best[rank - 1]
                    rank -= 1
                scores[rank], best[rank] = score, begin
            begin += 1
        # Objects that a robot does not take lie at infinity.
        for r in range(robot, robots if count > 0 else 0):
            for j in range(seen.shape[1]):
                places[r, j] = seen[k, j].x if tables.can_take[r, seen[k, j].kind] else math.inf
        for c in range(most):
            if c < count:
                state.choices[n, c] = planned[best[c]]
                state.choices[n, c].line = 0  # a state's choice is of its own line
                _write_features(tables, robot, seen[k], places, state.choices[n, c])
            else:
                state.choices[n, c] = tables.blank[0]
        if count == 0:
            # An object is near, so a robot that cannot take one looks again after the shortest time.
            state.arms[n, robot].free += IDLE_TIME
            left[lefts] = n
            lefts += 1
    return left[:lefts]
