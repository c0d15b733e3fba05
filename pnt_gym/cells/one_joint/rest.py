"""Whether parts lie right: at rest in their pallet, or on the part before."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.one_joint.pallets import Pallet, stacked


@final
@dataclass(frozen=True)
class SeatTolerance:
    """How a part may lie to be in its place, and how still."""

    position: float
    """Of the centre of mass, from the exact seat [m]."""
    angle: float
    """[rad]"""
    speed: float = 0.02
    """A part at rest creeps by less than 1 mm/s; one that hops or slides is faster [m/s]."""
    spin: float = 0.30
    """[rad/s]"""


IN_POCKET: Final = SeatTolerance(position=0.008, angle=float(np.deg2rad(5.0)))
"""A pocket leaves a part 6 mm to one side of the goal and 4 mm to the other; a part that lies on the lip is more than
8 mm off, and one that lies on the back board more than 10 deg."""
ON_STEM: Final = SeatTolerance(position=0.007, angle=float(np.deg2rad(5.0)))
"""A slot has 5 mm of play to either side; a part whose slot or stem is not engaged lies more than 10 mm higher."""


def lies_at(pose: Floats, velocity: Floats, seat: Floats, tolerance: SeatTolerance) -> Bools:
    """Whether parts rest in their seats (N,).

    Args:
        pose: x, y [m], phi [rad] (N, 3); whole turns do not matter.
        velocity: their rates (N, 3).
        seat: pose of a part that lies exactly right (3,) or (N, 3).
        tolerance: what still counts.
    """
    miss = pose - seat
    turn = np.abs((miss[:, 2] + np.pi) % (2.0 * np.pi) - np.pi)
    near = (np.hypot(miss[:, 0], miss[:, 1]) <= tolerance.position) & (turn <= tolerance.angle)
    still = np.hypot(velocity[:, 0], velocity[:, 1]) <= tolerance.speed
    return near & still & (np.abs(velocity[:, 2]) <= tolerance.spin)


def lies_in_pocket(pose: Floats, velocity: Floats, pallet: Pallet, tolerance: SeatTolerance = IN_POCKET) -> Bools:
    """Whether parts rest in a pallet (N,); see `lies_at`."""
    return lies_at(pose, velocity, pallet.pose, tolerance)


def are_joined(lower: Floats, upper: Floats, velocity: Floats, tolerance: SeatTolerance = ON_STEM) -> Bools:
    """Whether Ts rest with their stem in the upper slot of Hs (N,).

    Args:
        lower: poses of the Hs (N, 3).
        upper: poses of the Ts (N, 3).
        velocity: rates of the Ts (N, 3).
        tolerance: of the T from its seat on the H as it lies.
    """
    return lies_at(upper, velocity, stacked(lower), tolerance)
