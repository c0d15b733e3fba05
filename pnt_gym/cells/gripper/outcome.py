"""What became of throws, and whether they did what they should."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.base.plant import Landed
from pnt_gym.cells.gripper.config import GripperConfig
from pnt_gym.cells.gripper.flown import Flown
from pnt_gym.cells.gripper.motion import TossPlans

LIFT: Final = 0.5
"""An object counts as picked that has been lifted by this share of the platform's own rise."""


@final
@dataclass(frozen=True)
class Outcome(Landed):
    """N throws; the bin is a compartment, a drop is along x.

    The cycle is from closing until the object has passed the rim plane and the robot is back above the pick.
    """

    picked: Bools
    """The claws still held the object, lifted, when they were told to open (N,)."""
    slip: Floats
    """How far the object moved along the pads from leaving the table until they were told to open (N,) [m]."""
    release_delay: Floats
    """When the object came free, after the planned moment of an uncorrected throw (N,) [s]."""


def judge(flown: Flown, plans: TossPlans, config: GripperConfig, return_time: Floats) -> Outcome:
    """What became of N throws.

    Args:
        flown: the throws.
        plans: what was planned.
        config: the cell.
        return_time: from the end of the throw back above the pick (N,) [s].
    """
    tray, arrival = config.tray, flown.release_time + plans.flight_time
    opening = np.broadcast_to(np.array(tray.opening), (len(arrival), 2))
    landed = flown.flight.landed(plans.target, opening, tray.depth, plans.heading)
    return Outcome(
        **landed,
        landing_error=np.hypot(landed["landing_along"], landed["landing_across"]),
        picked=flown.lifted >= LIFT * (plans.release[:, 2] - plans.pick[:, 2]),
        slip=flown.slip,
        release_delay=flown.release_time - plans.release_time,
        cycle_time=np.maximum(arrival, plans.stop_time + return_time),
        peak_torque=flown.peak_torque,
    )
