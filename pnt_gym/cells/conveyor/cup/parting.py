"""How N objects leave their cups: where they hang, how they swing there, and what the release gives them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self, final

import numpy as np

from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.base.rotations import in_body_axes, upright
from pnt_gym.cells.conveyor.context import Context


@final
@dataclass(frozen=True)
class Parting:
    """N objects in the moment in which they are let go, seen from the tips of their cups."""

    apart: Floats
    """Centre of mass from the tip (N, 3) [m]."""
    velocity: Floats
    """Against the hand (N, 3) [m/s]."""
    attitude: Floats
    """Quaternions, w first (N, 4)."""
    rate: Floats
    """Angular velocity in the object's axes (N, 3) [rad/s]."""
    push: Floats
    """The part of the velocity that blown air gives, downwards (N,) [m/s]."""
    unsure: Bools
    """The object met the belt or the solid part of its cup before, which only the engine knows of (N,)."""

    @classmethod
    def hanging(cls, thrown: Context, push: Floats) -> Self:
        """Objects that hang rigidly under their cups, and get their spin and a push (N,) [m/s]."""
        o = thrown.objects
        zero = np.zeros_like(o.yaw)
        return cls(
            apart=np.concatenate([thrown.grasp, -o.com_depth[:, None]], axis=1),
            velocity=np.stack([zero, zero, -push], axis=1),
            attitude=upright(o.yaw),
            rate=in_body_axes(o.spin, o.yaw),
            push=push,
            unsure=np.zeros_like(zero, dtype=np.bool_),
        )
