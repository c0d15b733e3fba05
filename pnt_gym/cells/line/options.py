"""Options of a line's robots: every object that a robot can meet, into every bin that takes the object, as planned.

Times and feasibility are those of the conveyor's planner, so a chosen option is executed with the same values.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple, final

import numpy as np

from pnt_gym.arrays import Floats, Ints
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.line.state import PicksAndThrows

UNAVAILABLE_X: Final = 1e6
"""Position along the belt of objects that the robot cannot take [m]."""


@final
@dataclass(frozen=True)
class Options(PicksAndThrows):
    """Possible picks and throws, S = (C,), in the order of their lines."""

    row: Ints
    """Index of the line among K lines."""
    place: Ints
    """Index of the object among the line's objects in sight."""


class Sight(NamedTuple):
    """Objects that camera and encoder know in K lines: W objects each, the most downstream first."""

    line: Ints
    """Indices of the lines (K,)."""
    object_index: Ints
    """Indices of the objects in their streams (K, W)."""
    x: Floats
    """Position along the belt (K, W) [m]; `UNAVAILABLE_X` where the object may not be taken."""
    kind: Ints
    """Item as which the camera classifies the object (K, W)."""


class ThrowCandidates(NamedTuple):
    """Objects near C robots, each for one bin and one speed setting, in the order of the lines."""

    indices: Ints
    """Line among K lines, object among the line's objects in sight, site and setting, (4, C)."""
    x: Floats
    """Position of the object from the robot's base (C,) [m]."""


@final
class Sites:
    """Bins and speed settings of all kinds of robots in one table each.

    Args:
        configs: the kinds of robots, each as a conveyor cell.
        kind_of: kind of each robot (R,).
    """

    def __init__(self, configs: Sequence[ConveyorConfig], kind_of: Ints) -> None:
        bins = [len(config.bins.fixed) for config in configs]
        settings = [len(config.limits.percent) for config in configs]
        first_bins, first_settings = np.cumsum([0, *bins]), np.cumsum([0, *settings])
        self.kind: Ints = np.repeat(np.arange(len(configs)), bins)
        """Kind of robots that has each site (B,)."""
        self.bin: Ints = np.arange(first_bins[-1]) - first_bins[self.kind]
        """Index of each site among the bins of its robots (B,)."""
        self.centre = np.array([[b.x, b.y, c.bins.rim] for c in configs for b in c.bins.fixed]).reshape(-1, 3)
        """Middle of each site's opening (B, 3) [m]."""
        self.accepts = np.ascontiguousarray(np.concatenate([config.acceptance().T for config in configs]))
        """Whether each site takes each item (B, items)."""
        self.percent = np.concatenate([np.array(config.limits.percent, dtype=np.float64) for config in configs])
        """Speed settings (S,) [%]."""
        columns = first_bins[kind_of], first_bins[kind_of + 1], first_settings[kind_of], first_settings[kind_of + 1]
        self.ranges = np.ascontiguousarray(np.stack(columns, axis=1), dtype=np.int64)
        """Each robot's first site and the index after its last site, and the same of its settings (R, 4)."""
        self.most = int(max(config.acceptance().sum(axis=1).max() * len(config.limits.percent) for config in configs))
        """Largest number of candidates with one object."""
