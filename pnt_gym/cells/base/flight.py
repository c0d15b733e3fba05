"""Flight and landing of N thrown objects, as read from what a plant recorded."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, NamedTuple, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, in_order
from pnt_gym.cells.base import recorded
from pnt_gym.cells.base.sorting import SortingReward
from pnt_gym.rows import Bools1, Bools2, Floats2, Floats3, Ints1

REWARD_TERMS: Final = ("landing", "success", "time")
"""Names of the reward terms of a throw into an opening."""
CONTACT_DEPTH: Final = 0.003
"""Largest depth at which flat objects rest below a surface, because contacts are soft [m]."""


@dataclass(frozen=True)
class Landed:
    """Abstract: outcome of N throws into openings; every field has shape (N,) unless noted."""

    landing: Floats
    """Where the free flight crosses the rim plane, x, y (N, 2) [m]; see `ObjectFlight.touchdown`."""
    landing_along: Floats
    """Landing relative to the target, along the throw [m]."""
    landing_across: Floats
    """Landing relative to the target, to the left of the throw [m]."""
    landing_error: Floats
    """Distance of the landing from the target [m]."""
    in_opening: Bools
    """The landing lies inside the opening."""
    in_bin: Bools
    """At the end the object lies in its bin: inside the walls, below the rim, too slow to leave."""
    is_success: Bools
    """The landing lies in the opening and the object in the bin."""
    rim: Bools
    """The landing lies in the opening but the object not in the bin: it hangs on the rim or bounced out."""
    recontact: Bools
    """The hand touched the object after the release."""
    final: Floats
    """Position of the object at the end (N, 3) [m]."""
    cycle_time: Floats
    """Time from one throw to the next, as the robot's subclass defines it [s]."""
    peak_torque: Floats
    """Largest motor torque [N m]."""

    def rewards(self, weights: SortingReward) -> dict[str, Floats]:
        """The terms `REWARD_TERMS` by name, times their weights; before weighting every term lies in [0, 1]."""
        # A throw without a landing, of which the error is NaN, gets 0.
        landing = np.fmax(1.0 - self.landing_error / weights.landing_scale, 0.0)
        time = np.maximum(1.0 - self.cycle_time / weights.time_scale, 0.0)
        worth = weights.landing * landing, weights.success * self.is_success.astype(np.float64), weights.time * time
        return dict(zip(REWARD_TERMS, worth, strict=True))


@final
class ObjectFlight(NamedTuple):
    """Motion and contacts of N thrown objects, M steps each."""

    position: Floats3
    """Position of the object at the start of each step (N, M, 3) [m]."""
    velocity: Floats3
    """Velocity of the object at the start of each step (N, M, 3) [m/s]."""
    hand_touch: Bools2
    """Whether the hand touches the object (N, M)."""
    any_touch: Bools2
    """Whether any body touches the object (N, M)."""
    release_step: Ints1
    """First step without grip (N,)."""
    last_step: Ints1
    """Last step that counts (N,)."""

    @property
    def free(self) -> Bools:
        """Steps after the release that count, (N, M)."""
        steps = np.arange(self.position.shape[1], dtype=np.int64)
        return (steps > self.release_step[:, None]) & (steps <= self.last_step[:, None])

    def final(self) -> tuple[Floats, Floats]:
        """Position and velocity at the last step that counts, (N, 3) each."""
        rows = np.arange(len(self.position))
        return self.position[rows, self.last_step], self.velocity[rows, self.last_step]

    def touchdown(self, plane_z: Floats) -> Touchdown:
        """Landing where the free flights cross the height plane_z (N,) [m], going down, and last state of the objects.

        The flight of an object that first touches a rim, a wall or the belt is continued ballistically from that
        moment, so the landing measures the throw and not the bin.
        """
        return recorded.touchdown(ObjectFlight(*in_order(*self)), *in_order(plane_z))


@final
class Touchdown(NamedTuple):
    """Landing and last state of N thrown objects."""

    landing: Floats2
    """Where the free flight crosses the rim plane, x, y (N, 2) [m]; see `ObjectFlight.touchdown`."""
    position: Floats2
    """Last position (N, 3) [m]."""
    velocity: Floats2
    """Last velocity (N, 3) [m/s]."""
    recontact: Bools1
    """The hand touched the object after the release (N,)."""

    def lies_in(self, centre: Floats, opening: Floats, rim: Floats, bottom: Floats) -> Bools:
        """Whether the objects lie in their bins for good at the end (N,).

        An object inside the walls and below the rim stays if its upward speed does not lift the object to the rim.

        Args:
            centre: centre of the opening (N, 2) [m], or (1, 2) for all.
            opening: inner size (N, 2), or (1, 2) for all [m].
            rim: height of the rim (N,) [m].
            bottom: height of the inner bottom (N,) [m]; an object on the bottom may lie lower by up to `CONTACT_DEPTH`.
        """
        return recorded.lies_in(Touchdown(*in_order(*self)), *in_order(centre, opening, rim, bottom))

    def landing_fields(self, target: Floats, opening: Floats, depth: float | Floats, along: Floats) -> dict[str, Any]:
        """Fields of `Landed` that follow from the flights, by name: all except error, cycle time and torque.

        Args:
            target: centre of each opening (N, 3) [m].
            opening: inner size along x and y (N, 2), or (1, 2) for all [m].
            depth: depth of the bins below the opening, one number or (N,) [m].
            along: horizontal unit vectors of the throws (N, 2+).
        """
        x, y = (self.landing - target[:, :2]).T
        in_opening = (np.abs(x) <= opening[:, 0] / 2.0) & (np.abs(y) <= opening[:, 1] / 2.0)
        in_bin = self.lies_in(target[:, :2], opening, target[:, 2], target[:, 2] - depth)
        return {
            "landing": self.landing,
            "landing_along": x * along[:, 0] + y * along[:, 1],
            "landing_across": y * along[:, 0] - x * along[:, 1],
            "in_opening": in_opening,
            "in_bin": in_bin,
            "is_success": in_opening & in_bin,
            "rim": in_opening & ~in_bin,
            "recontact": self.recontact,
            "final": self.position,
        }
