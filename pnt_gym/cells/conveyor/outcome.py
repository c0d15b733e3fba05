"""What became of throws at the conveyor, and whether they did what they should."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.base.plant import ObjectFlight
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context


@final
@dataclass(frozen=True)
class Flown:
    """N throws as the simulator ran them, before they are judged."""

    flight: ObjectFlight
    hand: Floats
    """Cup tip (N, M, 3) at the start of each step [m]."""
    start: Floats
    """Time on the path's own clock at the first step (N,) [s]."""
    tracking_error: Floats
    """Distance of the hand from its reference at the moment of release (N,) [m]."""
    peak_torque: Floats
    """Largest motor torque (N,) [N m]."""


@final
@dataclass(frozen=True)
class Outcome:
    """N throws as the simulator measured them; every field has shape (N,) unless noted."""

    landing: Floats
    """Where the free flight crosses the rim plane, x, y (N, 2) [m]; see `ObjectFlight.landing`."""
    landing_along: Floats
    """Landing from the target, along the throw [m]."""
    landing_across: Floats
    """Landing from the target, to the left of the throw [m]."""
    landing_error: Floats
    """Distance of the landing from the target [m]."""
    in_opening: Bools
    """The landing lies inside the opening."""
    in_bin: Bools
    """At the end the object lies in its bin: inside the walls, below the rim, too slow to leave."""
    is_success: Bools
    """In the opening and in the bin."""
    rim: Bools
    """In the opening but not in the bin: hanging on the rim or bounced out."""
    recontact: Bools
    """The cup touched the object after the release."""
    final: Floats
    """Position of the object at the end (N, 3) [m]."""
    cycle_time: Floats
    """From lift to lift, dwell included [s]."""
    wait_time: Floats
    """Part of the cycle spent waiting above the belt for the next object [s]."""
    peak_torque: Floats
    """Largest motor torque [N m]."""
    tracking_error: Floats
    """Distance of the hand from its reference at the moment of release [m]."""


def judge(flown: Flown, context: Context, config: ConveyorConfig, cycle_time: Floats, wait_time: Floats) -> Outcome:
    """What became of N throws.

    Args:
        flown: the throws.
        context: the picks that were thrown.
        config: the cell.
        cycle_time: from lift to lift, dwell included (N,) [s].
        wait_time: part of it spent waiting for the next object (N,) [s].
    """
    target, opening, bins, flight = context.target, context.opening, config.bins, flown.flight
    landing = flight.landing(target[:, 2])
    miss = landing - target[:, :2]
    along, across = context.to_throw_frame(miss)
    in_opening: Bools = np.asarray((np.abs(miss) <= opening / 2).all(axis=1))
    in_bin = flight.lies_in(target[:, :2], opening, bins.rim, bins.rim - bins.depth)
    return Outcome(
        landing=landing,
        landing_along=along,
        landing_across=across,
        landing_error=np.sqrt(along**2 + across**2),
        in_opening=in_opening,
        in_bin=in_bin,
        is_success=in_opening & in_bin,
        rim=in_opening & ~in_bin,
        recontact=flight.recontact(),
        final=flight.final()[0],
        cycle_time=cycle_time,
        wait_time=wait_time,
        peak_torque=flown.peak_torque,
        tracking_error=flown.tracking_error,
    )
