"""What became of throws, and whether they did what they should."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.gripper.config import GripperConfig
from pnt_gym.cells.gripper.flown import Flown
from pnt_gym.cells.gripper.motion import TossPlans

LIFT: Final = 0.5
"""An object counts as picked that has been lifted by this share of the platform's own rise."""


@final
@dataclass(frozen=True)
class Outcome:
    """N throws; every field has shape (N,) unless noted."""

    landing: Floats
    """Where the free flight crosses the rim plane, x, y (N, 2) [m]; one that touches something first is carried on
    ballistically from there."""
    landing_along: Floats
    """Landing from the target, along the throw [m]; along x for a drop."""
    landing_across: Floats
    """Landing from the target, to the left of the throw [m]."""
    landing_error: Floats
    """Distance of the landing from the target [m]."""
    in_opening: Bools
    """The landing lies inside the opening of its compartment."""
    in_bin: Bools
    """At the end the object lies in its compartment, for good."""
    is_success: Bools
    """It crossed the opening and lies in the compartment."""
    rim: Bools
    """In the opening, but at the end not in the compartment."""
    picked: Bools
    """The claws still held the object, lifted, when they were told to open."""
    slip: Floats
    """How far the object moved along the pads from leaving the table until they were told to open [m]."""
    release_delay: Floats
    """When the object came free, after the planned moment of an uncorrected throw [s]."""
    recontact: Bools
    """A pad met the object again after it had come free."""
    cycle_time: Floats
    """From closing until the object has passed the rim plane and the robot is back above the pick [s]."""
    peak_torque: Floats
    """Largest motor torque [N m]."""
    final: Floats
    """Position of the object at the end (N, 3) [m]."""


def judge(flown: Flown, plans: TossPlans, config: GripperConfig, return_time: Floats) -> Outcome:
    """What became of N throws.

    Args:
        flown: the throws.
        plans: what was planned.
        config: the cell.
        return_time: from the end of the throw back above the pick (N,) [s].
    """
    flight, target, tray = flown.flight, plans.target, config.tray
    count = len(target)
    landing = flight.landing(target[:, 2])
    miss = landing - target[:, :2]
    ahead = plans.heading
    along = miss[:, 0] * ahead[:, 0] + miss[:, 1] * ahead[:, 1]
    across = miss[:, 1] * ahead[:, 0] - miss[:, 0] * ahead[:, 1]
    opening = np.broadcast_to(np.array(tray.opening), (count, 2))
    in_opening = np.asarray((np.abs(miss) <= opening / 2.0).all(axis=1))
    lies = flight.lies_in(target[:, :2], opening, tray.rim, tray.rim - tray.depth)
    rise = plans.release[:, 2] - plans.pick[:, 2]
    arrival = flown.release_time + plans.flight_time
    return Outcome(
        landing=landing,
        landing_along=along,
        landing_across=across,
        landing_error=np.hypot(along, across),
        in_opening=in_opening,
        in_bin=lies,
        is_success=in_opening & lies,
        rim=in_opening & ~lies,
        picked=flown.lifted >= LIFT * rise,
        slip=flown.slip,
        release_delay=flown.release_time - plans.release_time,
        recontact=flight.recontact(),
        cycle_time=np.maximum(arrival, plans.stop_time + return_time),
        peak_torque=flown.peak_torque,
        final=flight.final()[0],
    )
