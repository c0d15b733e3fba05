"""What gauge and scales say of an object under the cup: how fast its grip lets it be thrown."""

from __future__ import annotations

from typing import Final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.items import SURFACES
from pnt_gym.cells.conveyor.cup.hold import Hold

SAFETY: Final = 1.3
"""Factor of the measured load that a grip must hold."""
FRICTION: Final = SURFACES["smooth"].friction
"""Friction of the lip, whatever the object: no sensor measures it, and it is the less of those of dry objects."""


def allowed_acceleration(hold: Hold, safety: float = SAFETY) -> Floats:
    """Largest accelerations in any direction at which grips hold a multiple of the load (N,) [m/s2].

    Args:
        hold: measured values; its friction is not read.
        safety: the multiple.
    """
    return hold._replace(friction=np.full(len(hold.force), FRICTION)).acceleration(safety)
