"""Figures of a line's work shift."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Floats, Ints, take
from pnt_gym.cells.line import simulate
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.rows import LineState, Tables, Tally, Worth
from pnt_gym.cells.line.stream import Stream


def shift_figures(
    config: LineConfig, tables: Tables, state: LineState, stream: Stream, rows: Ints
) -> dict[str, NDArray[Any]]:
    """Figures of the shifts of some lines (K,), and by item (K, items) or robot (K, R) as the names say.

    An object counts as arrived when it was lifted, or has passed the last window before the end of the shift. Objects
    that are still on their way or in a hand count neither as success nor as failure.
    """
    accounts, riders = take(state.accounts, rows), take(stream.riders, rows)
    end = np.minimum(state.clock[rows], config.duration)
    tallies, worths = Tally.zeros(len(rows), len(config.cell.items)), Worth.zeros(*riders.shape)
    picks, minutes = np.zeros((len(rows), len(config.robots)), dtype=np.int64), end / 60.0
    simulate.count_fates(tables, end, riders, accounts, tallies, picks, worths)
    by_item = {name: tallies[name].copy() for name in Tally.fields}
    of_all = {name: count.sum(axis=1) for name, count in by_item.items()}
    value = {name: np.ascontiguousarray(worths[name]).sum(axis=1) for name in Worth.fields}
    arrived = by_item["in_right"] + by_item["in_wrong"] + by_item["on_floor"] + by_item["passed"]
    return {
        "shift_value_per_min": value["sorted"] / minutes,
        "shift_sorted_per_min": of_all["in_right"] / minutes,
        "shift_attempts": accounts["attempts"].sum(axis=1),
        "shift_objects": arrived.sum(axis=1),
        "shift_sorted": of_all["in_right"],
        "shift_misplaced": of_all["in_wrong"],
        "shift_on_floor": of_all["on_floor"],
        "shift_passed": of_all["passed"],
        "shift_out_of_reach": of_all["unreached"],
        "shift_recovery": _ratio(of_all["in_right"], arrived.sum(axis=1)),
        "shift_value_recovery": _ratio(value["sorted"], value["arrived"]),
        "shift_purity": _ratio(of_all["in_right"], of_all["in_right"] + of_all["in_wrong"]),
        "shift_recovery_by_item": _ratio(by_item["in_right"], arrived),
        "shift_sorted_by_item": by_item["in_right"],
        "shift_misplaced_by_item": by_item["in_wrong"],
        "shift_on_floor_by_item": by_item["on_floor"],
        "shift_passed_by_item": by_item["passed"],
        "shift_passed_tried_by_item": by_item["tried"],
        "shift_out_of_reach_by_item": by_item["unreached"],
        "shift_passed_value_per_min": value["passed"] / minutes,
        "shift_passed_tried": _ratio(of_all["tried"], of_all["passed"]),
        "shift_picks_by_robot": picks,
        "shift_utilisation": np.minimum(state.arms["busy"][rows] / end[:, None], 1.0),
    }


def _ratio(part: Ints | Floats, whole: Ints | Floats) -> Floats:
    """Parts divided by wholes (K, ...); NaN where a whole is 0."""
    return np.divide(part, whole, out=np.full(whole.shape, np.nan), where=whole > 0)
