"""Visual geoms of the one-joint thrower, massless and without contacts: group 1 for the stand, group 2 for the arm."""

from __future__ import annotations

from typing import Final

from pnt_gym.engine import MjsBody, MjSpec
from pnt_gym.palette import ACCENT, ALUMINIUM, MOTOR, PAINT, STEEL
from pnt_gym.planning.one_joint.parameters import Arm
from pnt_gym.robots.brush import FIXED_GROUP, Brush

STAND_DEPTH: Final = 0.16
"""Distance of the stand's column behind the plane of the throw [m]."""
FLOOR: Final = -0.70
"""Height of the floor [m]; the arm and the thrown parts stay above the floor."""


def dress_arm(body: MjsBody, arm: Arm) -> None:
    """Draw a plate whose upper surface passes through the pivot, clamped to a hub behind the plane."""
    brush, half, thin = Brush(body), arm.length / 2, arm.thickness / 2
    tip = 0.012
    brush.box((0, 0, -thin), (half - tip, arm.width / 2, thin), ALUMINIUM)
    for side in (-1.0, 1.0):
        brush.box((side * (half - tip / 2), 0, -thin), (tip / 2, arm.width / 2, thin), ACCENT)
    # Below the surface, where nothing is thrown.
    brush.box((0, 0.010, -2 * thin - 0.008), (0.055, arm.width / 2 + 0.010, 0.008), MOTOR)
    brush.cylinder((0, arm.width / 2, 0), (0, STAND_DEPTH - 0.050, 0), 0.034, STEEL)


def dress_stand(spec: MjSpec, arm: Arm) -> None:
    """Draw a motor on a column behind the plane, out of the way of thrown parts."""
    brush = Brush(spec.worldbody.add_body(name="column"), FIXED_GROUP)
    back = STAND_DEPTH
    brush.cylinder((0, back - 0.050, 0), (0, back + 0.070, 0), 0.055, MOTOR)
    brush.cylinder((0, back - 0.056, 0), (0, back - 0.050, 0), 0.050, ACCENT)
    brush.cylinder((0, back + 0.070, 0), (0, back + 0.085, 0), 0.042, STEEL)
    brush.box((0, back + 0.010, FLOOR / 2 - 0.020), (0.040, 0.040, -FLOOR / 2 - 0.020), PAINT)
    brush.box((0, back + 0.010, FLOOR + 0.012), (0.16, 0.13, 0.012), STEEL)
