"""Landing shifts in metres and the actions that ask for them."""

from __future__ import annotations

import numpy as np

from agents.controllers.protocol import Actions, Outcome
from pnt_gym.config import CellConfig
from pnt_gym.planning.arrays import Bools, Floats


def action_scale(config: CellConfig) -> Floats:
    """Shift along and across the throw that an action of 1 asks for, (2,) [m]."""
    return np.array([config.action.along, config.action.across])


def to_action(shift: Floats, config: CellConfig) -> Actions:
    """Actions (N, 2) that move the drag-free landing by `shift` (N, 2) [m], as far as [-1, 1] goes."""
    return np.clip(shift / action_scale(config), -1.0, 1.0).astype(np.float32)


def ideal_shift(outcome: Outcome, config: CellConfig) -> Floats:
    """Shift (N, 2) [m] that would have landed each throw on its target.

    It takes the landing to follow the shift one to one: what was asked for minus the error that came out,
    held inside the action range so that an object thrown off by a rim or a touch counts as far off, not as a
    lesson in metres.
    """
    scale = action_scale(config)
    error = np.stack([outcome.landing_along, outcome.landing_across], axis=-1)
    return np.clip(outcome.action[:, :2] * scale - error, -scale, scale)


def instructive(outcome: Outcome) -> Bools:
    """Throws (N,) that were executed as asked and whose landing was measured."""
    measured = np.isfinite(outcome.landing_along) & np.isfinite(outcome.landing_across)
    return measured & ~outcome.clipped
