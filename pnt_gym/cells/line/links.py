"""Which moments of a robot may follow each other. Compiled.

A hand that is free earlier, or nearer to an object, lifts the object no later: a way that waits first is a way, too.
So a link leads to the first moment that the best of a moment's lifts can reach, and any later moment of the same object
may follow as well.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple

import numpy as np

from pnt_gym.cells.line.moments import Moment, Passage
from pnt_gym.cells.line.plan import write_hunt
from pnt_gym.cells.line.rows import Rider, Tables
from pnt_gym.compiled import empty_rows, kernel, kernel_part
from pnt_gym.planning.motion.hunt import meet
from pnt_gym.planning.motion.rows import Hunt
from pnt_gym.rows import Ints2, Rows1, Shorts1

AHEAD: Final = 2.0
"""From this time after a hand is free on, its place does not count for the objects that come into the window [s]."""
MARGIN: Final = 0.3
"""Margin of the search for objects near a window [m]."""
LONGEST: Final = 20.0
"""Longest way of a hand to an object, its wait included [s]."""
HUNT: Final = Hunt.dtype


THROWN, EMPTY = range(2)
"""Ends of a moment: a throw, or an attempt whose cup did not seal."""


class Links(NamedTuple):
    """Moments that may follow each of N moments, by its end."""

    first: Ints2
    """Place of each moment's first link among all links; the last entry is that of the next end (2, N + 1)."""
    target: Shorts1
    """Rows of the moments that follow (L,); short, since the time of a search is that of reading them."""
    far: Ints2
    """Step from which on passages begin whose moments follow wherever the hand is; -1 for none (2, N)."""


@kernel_part
def first_below(riders: Rows1[Rider], passages: Rows1[Passage], robot: int, border: float, is_inclusive: bool) -> int:
    """Index of the first passage of a robot whose object begins upstream of a border, or on it if ``is_inclusive``."""
    begin, end = 0, len(passages)
    while begin < end:
        middle = (begin + end) // 2
        own, x = passages[middle].robot, riders[passages[middle].index].x
        if own < robot or (own == robot and (x > border or (x == border and not is_inclusive))):
            begin = middle + 1
        else:
            end = middle
    return begin


@kernel_part
def _least_time(hunt: Hunt, time: float, spread: float) -> float:
    """Time of a meeting [s], less what a hand gains that is nearer by a distance [m].

    The time of a stroke is a concave function of its length, so that a share of the length saves at most that share of
    the time. The object moves towards the window meanwhile, which at most doubles the gain.
    """
    square = 0.0
    for axis in range(3):
        square += (hunt.place[axis] + hunt.belt[axis] * time - hunt.hand[axis]) ** 2
    share = min(2.0 * spread / max(math.sqrt(square), spread), 1.0)
    return max(hunt.earliest, time * (1.0 - share))


@kernel_part
def _link(
    tables: Tables,
    riders: Rows1[Rider],
    passages: Rows1[Passage],
    moment: Moment,
    row: int,
    end: int,
    step: float,
    targets: Shorts1,
) -> int:
    """Write the rows of what may follow an end of a moment of the passage in a row; returns their number."""
    passage, line = passages[row], tables.line[0]
    is_empty, base = end == EMPTY, tables.stations[passage.robot].base
    time = moment.empty_free if is_empty else moment.free
    # The objects that link to the time begin between these two places.
    near = base + line.window_high + MARGIN - line.speed * time
    far = base + line.window_low - MARGIN - line.speed * (time + AHEAD)
    low = first_below(riders, passages, passage.robot, near, True)
    high = first_below(riders, passages, passage.robot, far, False)
    hunts, others, count = empty_rows(high - low, HUNT), np.empty(high - low, dtype=np.int64), 0
    for q in range(low, high):
        other = passages[q]
        is_gone = other.index == passage.index and not is_empty
        if not is_gone and time <= other.end and other.begin <= time + AHEAD + step:
            hand, setting = moment.empty_stop if is_empty else moment.stop, tables.settings[other.setting]
            x = riders[other.index].x + line.speed * time - base
            write_hunt(line, setting, riders[other.index], x, hand, hunts[count])
            hunts[count].earliest, others[count] = max(setting.least_time, 0.0), q
            count += 1
    meetings, links = meet(hunts[:count], 0, LONGEST), 0
    for h in range(count):
        if meetings[h].feasible:
            other = passages[others[h]]
            lift = time + _least_time(hunts[h], meetings[h].time, moment.spread) + line.dwell
            place = max(math.floor(lift / step) - other.first_step, 0)
            if place < other.count:
                targets[links] = other.first_row + place
                links += 1
    return links


@kernel
def link_moments(
    tables: Tables, riders: Rows1[Rider], passages: Rows1[Passage], moments: Rows1[Moment], step: float
) -> Links:
    """Find the moments that may follow each moment.

    Args:
        tables: what the level says.
        riders: the objects (M,).
        passages: the passages.
        moments: their moments (N,).
        step: length of a step [s].
    """
    first, far = np.zeros((2, len(moments) + 1), dtype=np.int64), np.full((2, len(moments)), -1)
    target, count = np.empty(16 * len(moments), dtype=np.int32), 0
    for end in range(2):
        for row in range(len(passages)):
            passage = passages[row]
            for n in range(passage.first_row, passage.first_row + passage.count):
                first[end, n] = count
                has_end = passage.seal < 1.0 if end == EMPTY else passage.seal > 0.0
                if not (has_end and moments[n].can_throw):
                    continue
                if count + len(passages) > len(target):
                    target = np.append(target, np.empty_like(target))
                count += _link(tables, riders, passages, moments[n], row, end, step, target[count:])
                free = moments[n].empty_free if end == EMPTY else moments[n].free
                far[end, n] = math.floor((free + AHEAD) / step)
        first[end, len(moments)] = count
    return Links(first, target[:count].copy(), far)
