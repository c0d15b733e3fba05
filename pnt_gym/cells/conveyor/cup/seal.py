"""Whether cups seal on N objects, and hold them when the dwell is over."""

from __future__ import annotations

import numpy as np

from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.objects.outline import inside_outline


def picked(thrown: Context, config: ConveyorConfig) -> Bools:
    """Which objects their cups hold (N,).

    The chance to fail scales with the mismatch, as every effect does that the planner knows nothing of.
    """
    if not config.pick.fails:
        return np.full(len(thrown.pick), True)
    fails: Floats = np.minimum(config.mismatch * (1.0 - seal_chance(thrown)), 1.0)
    return thrown.objects.pick_draw >= fails


def seal_chance(thrown: Context) -> Floats:
    """Chance that a cup seals where it truly stands on its object (N,): its kind's, less where the lip hangs over.

    All of it while the whole lip is inside the outline, nothing from where the cup's middle is the lip's radius
    outside, and linear between (assumed).
    """
    objects = thrown.objects
    inside, radius = inside_outline(objects, -thrown.grasp), objects.cup_radius
    return objects.pick_chance * np.clip((inside + radius) / (2.0 * radius), 0.0, 1.0)
