"""What became of throws at the conveyor, and whether they did what they should."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.base.plant import Landed, Touchdown
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.cup.hold import Grips


@final
@dataclass(frozen=True)
class Effort:
    """What N motions ask of the motors: as simulated, and as planned where the robot is not."""

    torque: Floats
    """The largest of any motor (N,) [N m]."""
    energy: Floats
    """Positive mechanical work of all motors (N,) [J], see `cells.base.energy`."""

    def then(self, other: Effort) -> Effort:
        """Of two motions, one after the other."""
        return Effort(np.maximum(self.torque, other.torque), self.energy + other.energy)


@final
@dataclass(frozen=True)
class Flown:
    """N throws as the simulator ran them, before they are judged."""

    touchdown: Touchdown
    tracking_error: Floats
    """Distance of the hand from its reference at the moment of release (N,) [m]."""
    effort: Effort
    """What the motors did."""
    grips: Grips
    """How the cups held."""


@dataclass(frozen=True)
class Told:
    """What is known of N throws without simulating them."""

    wait_time: Floats
    """Part of the cycle spent waiting for the next object (N,) [s]."""
    passed: Ints
    """Objects that were let go since the throw before (N,)."""
    placed: Bools
    """The object is put down at its bin, not thrown (N,)."""
    disturbed: Bools
    """The object sweeps through another one on the belt (N,)."""

    @classmethod
    def alone(cls, count: int) -> Self:
        """Throws without a wait and without a belt."""
        never = np.zeros(count, dtype=np.bool_)
        return cls(np.zeros(count), np.zeros(count, dtype=np.int64), never, never)


@final
@dataclass(frozen=True)
class Outcome(Landed, Told):
    """N throws as the simulator measured them; the cycle is from lift to lift, dwell included."""

    tracking_error: Floats
    """Distance of the hand from its reference at the moment of release (N,) [m]."""
    picked: Bools
    """The cup sealed; else the object rides on, and nothing is known of its landing (N,)."""
    dropped: Bools
    """The object was lost on the way to its release (N,)."""
    grip_margin: Floats
    """How many times the load the cup could hold, at the worst moment until its release (N,)."""
    energy: Floats
    """Positive mechanical work of the motors in the cycle (N,) [J], see `cells.base.energy`."""
    ended_in: Ints
    """Index of the bin in which the object lies at the end, 0 for one that is drawn per throw; -1 in none (N,)."""
    belongs: Bools
    """That bin takes what the object is (N,)."""

    @property
    def sorted(self) -> Bools:
        """A success, and in a bin that takes what the object is (N,)."""
        return self.is_success & self.belongs


def judge(
    flown: Flown, context: Context, config: ConveyorConfig, accepts: Bools, cycle_time: Floats, told: Told
) -> Outcome:
    """What became of N throws.

    Args:
        flown: the throws.
        context: the picks that were thrown.
        config: the cell.
        accepts: which kinds of objects (rows) its fixed bins (columns) take, as `config.acceptance()`.
        cycle_time: from lift to lift, dwell included (N,) [s].
        told: what is known without simulating them.
    """
    landed = flown.touchdown.landed(context.target, context.opening, context.bin_depth, context.direction)
    ended_in, objects = bins_of(flown.touchdown, context, config, landed["in_bin"]), context.objects
    # A bin that is drawn for a throw takes what was seen.
    fits = accepts[objects.kind, ended_in] if config.bins.fixed else objects.kind == objects.measured.kind
    return Outcome(
        **landed,
        landing_error=np.sqrt(landed["landing_along"] ** 2 + landed["landing_across"] ** 2),
        cycle_time=cycle_time,
        peak_torque=flown.effort.torque,
        tracking_error=flown.tracking_error,
        picked=flown.grips.picked,
        dropped=flown.grips.dropped,
        grip_margin=flown.grips.margin,
        energy=flown.effort.energy,
        ended_in=ended_in,
        belongs=(ended_in >= 0) & fits,
        **vars(told),
    )


def bins_of(touchdown: Touchdown, context: Context, config: ConveyorConfig, in_bin: Bools) -> Ints:
    """In which bins objects lie at the end (N,), -1 for none; `in_bin` (N,) says whether in that of the throw."""
    found, bins = np.where(in_bin, context.bin, -1), config.bins
    rim = np.full(len(found), bins.rim)
    for index, fixed in enumerate(bins.fixed):
        centre, opening = np.array([fixed.x, fixed.y]), np.array(fixed.size)
        found[touchdown.lies_in(centre, opening, rim, rim - context.depth[:, index])] = index
    return found
