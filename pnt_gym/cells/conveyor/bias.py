"""Constants by which a cell is off its data sheet, applied to picks: camera, encoder, drag and delay."""

from __future__ import annotations

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.sorting import Belt
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context, HiddenDrift
from pnt_gym.cells.conveyor.objects.drawing import spin_at_grasp


def constant_bias(config: ConveyorConfig, count: int) -> HiddenDrift:
    """The constants of the level's section `bias` as hidden values of N cells, scaled by the mismatch."""
    bias, m = config.bias, config.mismatch
    return HiddenDrift.zero(count)._replace(
        delay=np.full(count, m * bias.delay),
        camera=np.tile(m * np.array(bias.camera), (count, 1)),
        encoder=np.full(count, m * bias.encoder),
    )


def unseen_grasp(hidden: HiddenDrift, pick: Floats, belt: Belt) -> Floats:
    """Grasp offset that camera and encoder add to objects at picks (N, 3), which no sensor measures (N, 2) [m]."""
    offset = hidden.camera.copy()
    offset[:, 0] += hidden.encoder * (pick[:, 0] - belt.camera_x)
    return offset


def apply_bias(context: Context, config: ConveyorConfig) -> Context:
    """Picks whose objects have the constants of the section `bias`; measurements and plans do not change."""
    if not config.bias.applies:
        return context
    objects, hidden = context.objects, constant_bias(config, len(context.pick))
    unseen = unseen_grasp(hidden, context.pick, config.belt)
    changed = objects.replace(
        drag=objects.drag * (1.0 + config.mismatch * config.bias.drag),
        delay=np.maximum(objects.delay + hidden.delay, 0.0),
        spin=spin_at_grasp(objects, objects.grasp + unseen, config),
    )
    return context.replace(objects=changed, drift=hidden, unseen=unseen)
