"""What stands around the robots of a belt in pictures, and nowhere in the physics: the belt's frame, and stands."""

from __future__ import annotations

from typing import Final

import numpy as np

from pnt_gym.cells.base.canvas import Marker
from pnt_gym.cells.base.sorting import Belt
from pnt_gym.cells.base.stage import BELT_THICKNESS
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.scene import floor_height
from pnt_gym.engine import MjSpec, mujoco
from pnt_gym.palette import ACCENT, FRAME, MOTOR, PAINT, STEEL
from pnt_gym.robots.brush import FIXED_GROUP, Brush
from pnt_gym.robots.joints import Place

ABOVE: Final = 0.14
"""Height of the mounting plate's upper side above the robot's mount [m]."""
STAND: Final = 0.45
"""Distance of the posts from the belt, where no arm swings [m]."""
HOOD: Final = (0.16, 0.30)
"""Half the length along the belt, and the height, of the hoods that hide both ends of the belt [m]."""
LEGS: Final = 1.2
"""Largest distance of a belt's legs [m]."""


def add_belt_frame(spec: MjSpec, belt: Belt, ends: tuple[float, float], floor: float) -> None:
    """Add the frame under a belt, its legs, and hoods over the belt's ends.

    Args:
        spec: the specification.
        belt: height and width.
        ends: x of the middles of both hoods [m].
        floor: height of the floor [m].
    """
    brush, (low, high) = Brush(spec.worldbody.add_body(name="frame"), FIXED_GROUP), ends
    middle, width, length = sum(belt.y) / 2, (belt.y[1] - belt.y[0]) / 2, (high - low) / 2
    top, centre = belt.height - BELT_THICKNESS, (low + high) / 2
    brush.box((centre, middle, top - 0.03), (length, width - 0.03, 0.03), FRAME)
    for y in belt.y:
        brush.box((centre, y, top - 0.01), (length, 0.014, BELT_THICKNESS / 2 + 0.014), STEEL)
    for x in np.linspace(low + 0.12, high - 0.12, 1 + max(1, int(np.ceil((high - low - 0.24) / LEGS)))):
        for y in (belt.y[0] + 0.05, belt.y[1] - 0.05):
            brush.box((x, y, (top - 0.06 + floor) / 2), (0.028, 0.028, (top - 0.06 - floor) / 2), FRAME)
            brush.box((x, y, floor + 0.006), (0.05, 0.05, 0.006), MOTOR)
    half, height = HOOD
    for x in ends:
        brush.box((x, middle, belt.height + height / 2), (half, width + 0.03, height / 2), PAINT)
        brush.box((x, middle, belt.height + height), (half + 0.01, width + 0.04, 0.010), STEEL)
        brush.box((x, belt.y[1] + 0.032, belt.height + 0.7 * height), (0.8 * half, 0.003, 0.015), ACCENT)


def add_stand(spec: MjSpec, mount: Place, edge: float, floor: float) -> None:
    """Add the stand of a robot: a post under a mount beside the belt; else one beside the belt, and a beam over it.

    Args:
        spec: the robot's specification.
        mount: where the robot is mounted.
        edge: y of the belt's far edge [m].
        floor: height of the floor [m].
    """
    brush, (x, end, top) = Brush(spec.worldbody.add_body(name="stand"), FIXED_GROUP), mount
    if end < edge:
        brush.box((x, end, (top + floor) / 2), (0.09, 0.09, (top - floor) / 2), FRAME)
        return
    y, base = edge - STAND, top + ABOVE
    brush.box((x, y, (base + floor) / 2), (0.07, 0.07, (base - floor) / 2), FRAME)
    brush.box((x, y, floor + 0.012), (0.16, 0.16, 0.012), STEEL)
    brush.box((x, (y + end) / 2, base + 0.06), (0.07, (end - y) / 2 + 0.07, 0.06), FRAME)


def furniture(config: ConveyorConfig, mount: Place) -> list[Marker]:
    """Markers of everything that stands around one robot."""
    spec, floor, (half, _) = mujoco.MjSpec(), floor_height(config), HOOD
    add_belt_frame(spec, config.belt, (config.belt.x[0] - half, config.belt.x[1] + half), floor)
    add_stand(spec, mount, config.belt.y[0], floor)
    return Marker.all_of(spec.compile())
