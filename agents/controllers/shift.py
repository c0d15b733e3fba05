"""Offsets of a throw's errors, and the actions that produce them: E numbers each."""

from __future__ import annotations

import numpy as np

from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.base.action import Correction

from ..ground.cli import UsageError
from .protocol import Actions, Outcome


def to_action(offset: Floats, correction: Correction) -> Actions:
    """Actions (N, E) that offset the planned outcome by `offset` (N, E), clipped to [-1, 1]."""
    return np.clip(offset / correction.scale, -1.0, 1.0).astype(np.float32)


def ideal_offset(outcome: Outcome, correction: Correction) -> Floats:
    """Offset (N, E) that would have brought each throw to its goal.

    The outcome is assumed to follow the offset one to one: the offset of the action minus the error. The result is
    clipped to the action range, so that an object deflected by a rim or a touch only counts as far off.
    """
    return np.clip(outcome.action * correction.scale - outcome.error, -correction.scale, correction.scale)


def is_instructive(outcome: Outcome) -> Bools:
    """Whether each throw (N,) was executed as asked and its error was measured."""
    return np.isfinite(outcome.error).all(axis=1) & ~outcome.clipped


def check_width(offset: Floats, correction: Correction, name: str) -> None:
    """Check that the learned offsets (M, E) of a controller have the number of coordinates of this cell.

    Raises:
        UsageError: the number of coordinates differs.
    """
    count, required = offset.shape[1], correction.count
    if count != required:
        raise UsageError(f"the saved state of {name!r} holds shifts of {count} numbers; they must have {required} here")
