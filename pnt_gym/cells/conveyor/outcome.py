"""What became of throws at the conveyor, and whether they did what they should."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.base.plant import Landed, Touchdown
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.hold import Grips


@final
@dataclass(frozen=True)
class Flown:
    """N throws as the simulator ran them, before they are judged."""

    touchdown: Touchdown
    tracking_error: Floats
    """Distance of the hand from its reference at the moment of release (N,) [m]."""
    peak_torque: Floats
    """Largest motor torque (N,) [N m]: as simulated, and as planned where the robot is not."""
    grips: Grips
    """How the cups held."""


@final
@dataclass(frozen=True)
class Outcome(Landed):
    """N throws as the simulator measured them; the cycle is from lift to lift, dwell included."""

    wait_time: Floats
    """Part of the cycle spent waiting above the belt for the next object (N,) [s]."""
    tracking_error: Floats
    """Distance of the hand from its reference at the moment of release (N,) [m]."""
    dropped: Bools
    """The object was lost on the way to its release (N,)."""
    grip_margin: Floats
    """How many times the load the cup could hold, at the worst moment until its release (N,)."""


def judge(flown: Flown, context: Context, config: ConveyorConfig, cycle_time: Floats, wait_time: Floats) -> Outcome:
    """What became of N throws.

    Args:
        flown: the throws.
        context: the picks that were thrown.
        config: the cell.
        cycle_time: from lift to lift, dwell included (N,) [s].
        wait_time: part of it spent waiting for the next object (N,) [s].
    """
    landed = flown.touchdown.landed(context.target, context.opening, config.bins.depth, context.direction)
    return Outcome(
        **landed,
        landing_error=np.sqrt(landed["landing_along"] ** 2 + landed["landing_across"] ** 2),
        cycle_time=cycle_time,
        wait_time=wait_time,
        peak_torque=flown.peak_torque,
        tracking_error=flown.tracking_error,
        dropped=flown.grips.dropped,
        grip_margin=flown.grips.margin,
    )
