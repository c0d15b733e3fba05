"""Pictures of the gripper robot's cell."""

from __future__ import annotations

from typing import Any, Final

from pnt_gym.engine import mujoco

DOTS: Final = 0.4
"""Size of the dots along flights for the prototype, see `ThrowView`."""


def camera(size: float) -> Any:
    """The standard view: robot, table and tray from the front left, at a distance in proportion to the robot's size.

    Args:
        size: size of the robot over the prototype's.
    """
    view = mujoco.MjvCamera()
    view.lookat[:] = [0.05 * size, 0.0, -0.26 * size]
    view.distance, view.azimuth, view.elevation = 0.84 * size, 118.0, -14.0
    return view
