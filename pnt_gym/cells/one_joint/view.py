"""Pictures of the one-joint thrower's cell."""

from __future__ import annotations

from typing import Any, Final

from pnt_gym.engine import mujoco

DOTS: Final = 0.6
"""Size of the dots along flights, see `ThrowView`."""


def camera() -> Any:
    """The standard view: the plane of the throw from the front, a little from above."""
    view = mujoco.MjvCamera()
    view.lookat[:] = [0.0, 0.0, 0.14]
    view.distance, view.azimuth, view.elevation = 1.35, 90.0, -8.0
    return view
