"""Figures of a line's work shift."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Floats, Ints
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.state import Fate, LineState
from pnt_gym.cells.line.stream import Stream


def shift_figures(config: LineConfig, state: LineState, stream: Stream, rows: Ints) -> dict[str, NDArray[Any]]:
    """Figures of the shifts of some lines (K,), and by item (K, items) or robot (K, R) as the names say.

    An object counts as arrived when it was lifted, or has passed the last window before the end of the shift. Objects
    that are still on their way or in a hand count neither as success nor as failure.
    """
    books, kind = state.books.at(rows), stream.objects.kind[rows]
    worth, x, fate = stream.worth[rows], stream.x[rows], books.fate
    end = np.minimum(state.clock[rows], config.duration)
    gone = x + config.cell.belt.speed * end[:, None] > config.reach[1]
    on_belt = fate == Fate.RIDES
    sorted_, binned = fate == Fate.SORTED, (fate == Fate.SORTED) | (fate == Fate.MISPLACED)
    # Streams start at the end of the last window: objects downstream of it at the begin are not part of the shift.
    passed, arrived = on_belt & gone, (on_belt & gone) | binned | (fate == Fate.FLOOR)
    minutes = end / 60.0
    value = np.where(sorted_, worth, 0.0).sum(axis=1)
    items = np.arange(len(config.cell.items))
    of_item = kind[..., None] == items
    robots = np.arange(len(config.robots))
    taken_by = (books.taker[..., None] == robots) & (fate != Fate.HELD)[..., None]
    return {
        "shift_value_per_min": value / minutes,
        "shift_sorted_per_min": sorted_.sum(axis=1) / minutes,
        "shift_attempts": books.attempts.sum(axis=1),
        "shift_objects": arrived.sum(axis=1),
        "shift_sorted": sorted_.sum(axis=1),
        "shift_misplaced": (binned & ~sorted_).sum(axis=1),
        "shift_on_floor": (fate == Fate.FLOOR).sum(axis=1),
        "shift_passed": passed.sum(axis=1),
        "shift_recovery": _ratio(sorted_, arrived),
        "shift_value_recovery": _ratio(sorted_ * worth, arrived * worth),
        "shift_purity": _ratio(sorted_, binned),
        "shift_recovery_by_item": _ratio(sorted_[..., None] & of_item, arrived[..., None] & of_item),
        "shift_sorted_by_item": (sorted_[..., None] & of_item).sum(axis=1),
        "shift_misplaced_by_item": ((binned & ~sorted_)[..., None] & of_item).sum(axis=1),
        "shift_on_floor_by_item": ((fate == Fate.FLOOR)[..., None] & of_item).sum(axis=1),
        "shift_passed_by_item": (passed[..., None] & of_item).sum(axis=1),
        "shift_passed_tried_by_item": ((passed & (books.attempts > 0))[..., None] & of_item).sum(axis=1),
        "shift_passed_value_per_min": np.where(passed, worth, 0.0).sum(axis=1) / minutes,
        "shift_passed_tried": _ratio(passed & (books.attempts > 0), passed),
        "shift_picks_by_robot": taken_by.sum(axis=1),
        "shift_utilisation": np.minimum(state.busy[rows] / end[:, None], 1.0),
    }


def _ratio(part: Any, whole: Any) -> Floats:
    """Sums over objects (K, M, ...) of a part, divided by the sums of the whole; NaN where the whole is 0."""
    total = whole.sum(axis=1, dtype=np.float64)
    return np.divide(part.sum(axis=1, dtype=np.float64), total, out=np.full_like(total, np.nan), where=total > 0.0)
