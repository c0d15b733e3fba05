"""Pictures of the one-joint thrower's cell."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.canvas import Marker
from pnt_gym.engine import mujoco

DOTS: Final = 0.6
"""Size of the flights' dots, see `ThrowView`."""
_GOAL: Final = np.array([0.20, 0.70, 0.35, 0.9])


def camera() -> Any:
    """The standard view: the plane of the throw from the front, a little from above."""
    view = mujoco.MjvCamera()
    view.lookat[:] = [0.0, 0.0, 0.14]
    view.distance, view.azimuth, view.elevation = 1.35, 90.0, -8.0
    return view


def goal_marker(place: Floats) -> Marker:
    """What marks a goal (3,) [m]."""
    return Marker.dot(place, _GOAL, 0.008)
