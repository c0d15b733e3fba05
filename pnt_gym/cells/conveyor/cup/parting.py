"""State of N objects at their release from suction cups: position, swing, spin and push."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self, final

import numpy as np

from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.base.rotations import to_body_axes, yaw_attitude
from pnt_gym.cells.conveyor.context import Context


@final
@dataclass(frozen=True)
class Parting:
    """State of N objects at the moment of release, relative to the tips of their cups."""

    centre: Floats
    """Centre of mass relative to the tip (N, 3) [m]."""
    velocity: Floats
    """Velocity relative to the hand (N, 3) [m/s]."""
    attitude: Floats
    """Attitude as quaternions, w first (N, 4)."""
    rate: Floats
    """Angular velocity in the object's axes (N, 3) [rad/s]."""
    push: Floats
    """The part of the velocity that comes from blown air, downwards (N,) [m/s]."""
    unsure: Bools
    """Whether the object touched the belt or the solid part of its cup, which only the engine simulates (N,)."""

    @classmethod
    def hanging(cls, context: Context, push: Floats) -> Self:
        """Objects that hang rigidly under their cups, and get their spin and a push (N,) [m/s] at the release."""
        o = context.objects
        velocity = np.zeros_like(context.hanging)
        velocity[:, 2] = -push
        return cls(
            centre=context.hanging,
            velocity=velocity,
            attitude=yaw_attitude(o.yaw),
            rate=to_body_axes(o.spin, o.yaw),
            push=push,
            unsure=np.zeros(len(push), dtype=np.bool_),
        )
