"""Shifts of what a throw is judged by, and the actions that ask for them: E numbers each."""

from __future__ import annotations

import numpy as np

from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.base.action import Correction

from ..ground.cli import UsageError
from .protocol import Actions, Outcome


def to_action(shift: Floats, correction: Correction) -> Actions:
    """Actions (N, E) that move the planned outcome by `shift` (N, E), as far as [-1, 1] goes."""
    return np.clip(shift / correction.scale, -1.0, 1.0).astype(np.float32)


def ideal_shift(outcome: Outcome, correction: Correction) -> Floats:
    """Shift (N, E) that would have brought each throw to its goal.

    It takes the outcome to follow the shift one to one: what was asked for minus the error that came out,
    held inside the action range so that an object thrown off by a rim or a touch counts as far off, not as a
    lesson in metres.
    """
    return np.clip(outcome.action * correction.scale - outcome.error, -correction.scale, correction.scale)


def instructive(outcome: Outcome) -> Bools:
    """Throws (N,) that were executed as asked and whose error was measured."""
    return np.isfinite(outcome.error).all(axis=1) & ~outcome.clipped


def check_width(shift: Floats, correction: Correction, name: str) -> None:
    """Make sure that shifts (M, E) that a controller learned have the numbers of this cell's.

    Raises:
        UsageError: they have another number of coordinates.
    """
    found, needed = shift.shape[1], correction.count
    if found != needed:
        raise UsageError(f"what {name!r} learned are shifts of {found} numbers; here they have {needed}")
