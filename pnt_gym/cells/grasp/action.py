"""Actions of a cell that grasps: place of the cup, whether to try again, pace of the throw, and its residual."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Self, final

import numpy as np

from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.grasp.config import GraspConfig

MODE: Final = "grasp"
"""Name of the only action mode."""
NUMBERS: Final = (
    "place of the cup along the belt", "place of the cup across the belt",
    "above 1/2: try another place; below -1/2: let the object ride", "pace of the throw",
    "release point along the throw line", "release point sideways",
)  # fmt: skip
"""Meaning of each number of an action."""
_CHOICE: Final = 2
"""The number that a cell of one stage leaves out."""
THRESHOLD: Final = 0.5
"""Size of the third number from which an object is grasped again, or rides on."""


@final
@dataclass(frozen=True)
class Wishes:
    """What N actions ask for."""

    place: Floats
    """Places of the cups from the pictures' middles, along world x, y (N, 2) [m]."""
    again: Bools
    """Whether an object that hangs is to be grasped again (N,)."""
    rides: Bools
    """Whether an object is to ride on: put down, or given up (N,)."""
    pace: Floats
    """Largest acceleration of the throw, as a share of the robot's (N,)."""
    residual: Floats
    """Action of the conveyor's mode `release_point` (N, 2)."""

    @classmethod
    def of(cls, actions: Floats, config: GraspConfig) -> Self:
        """What actions (N, A) within [-1, 1] ask for; with one stage, the choice is not among their numbers."""
        if config.grasp.stages == 1:
            actions = np.insert(actions, _CHOICE, 0.0, axis=1)
        slow, fast = config.grasp.pace
        choice, share = actions[:, _CHOICE], (actions[:, 3] + 1.0) / 2.0
        return cls(
            config.grasp.reach * actions[:, :2],
            choice > THRESHOLD,
            choice < -THRESHOLD,
            slow + (fast - slow) * share,
            actions[:, 4:],
        )
