"""Figures of a line's work shift."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Floats, Ints, take
from pnt_gym.cells.line import simulate
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.rows import LineState
from pnt_gym.cells.line.stream import Stream


def shift_figures(config: LineConfig, state: LineState, stream: Stream, rows: Ints) -> dict[str, NDArray[Any]]:
    """Figures of the shifts of some lines (K,), and by item (K, items) or robot (K, R) as the names say.

    An object counts as arrived when it was lifted, or has passed the last window before the end of the shift. Objects
    that are still on their way or in a hand count neither as success nor as failure.
    """
    accounts, riders = take(state.accounts, rows), take(stream.riders, rows)
    end = np.minimum(state.clock[rows], config.duration)
    fates = np.zeros((5, len(rows), len(config.cell.items)), dtype=np.int64)
    picks, worths = np.zeros((len(rows), len(config.robots)), dtype=np.int64), np.zeros((3, *riders.shape))
    simulate.count_fates(config.cell.belt.speed * end, config.reach[1], riders, accounts, fates, picks, worths)
    (in_right, in_wrong, on_floor, passed, tried), minutes = fates, end / 60.0
    value, arrived_value, passed_value = worths.sum(axis=-1)
    objects, arrived = fates.sum(axis=-1), fates[:4].sum(axis=0)
    return {
        "shift_value_per_min": value / minutes,
        "shift_sorted_per_min": objects[0] / minutes,
        "shift_attempts": accounts["attempts"].sum(axis=1),
        "shift_objects": arrived.sum(axis=-1),
        "shift_sorted": objects[0],
        "shift_misplaced": objects[1],
        "shift_on_floor": objects[2],
        "shift_passed": objects[3],
        "shift_recovery": _ratio(objects[0], arrived.sum(axis=-1)),
        "shift_value_recovery": _ratio(value, arrived_value),
        "shift_purity": _ratio(objects[0], objects[0] + objects[1]),
        "shift_recovery_by_item": _ratio(in_right, arrived),
        "shift_sorted_by_item": in_right,
        "shift_misplaced_by_item": in_wrong,
        "shift_on_floor_by_item": on_floor,
        "shift_passed_by_item": passed,
        "shift_passed_tried_by_item": tried,
        "shift_passed_value_per_min": passed_value / minutes,
        "shift_passed_tried": _ratio(objects[4], objects[3]),
        "shift_picks_by_robot": picks,
        "shift_utilisation": np.minimum(state.arms["busy"][rows] / end[:, None], 1.0),
    }


def _ratio(part: Ints | Floats, whole: Ints | Floats) -> Floats:
    """Parts divided by wholes (K, ...); NaN where a whole is 0."""
    return np.divide(part, whole, out=np.full(whole.shape, np.nan), where=whole > 0)
