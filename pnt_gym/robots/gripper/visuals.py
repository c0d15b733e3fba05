"""Visual geoms of the gripper robot, massless and without contacts: group 1 for the base, group 2 for moving parts."""

from __future__ import annotations

import numpy as np

from pnt_gym.engine import MjsBody, MjSpec
from pnt_gym.palette import ACCENT, CARBON, MOTOR, PAINT, PRINT, STEEL
from pnt_gym.robots.brush import FIXED_GROUP, Brush
from pnt_gym.robots.gripper.build import Claws
from pnt_gym.robots.gripper.geometry import N_ARMS, PROTOTYPE, Dimensions


def dress_base(spec: MjSpec, dims: Dimensions) -> None:
    """Draw a plate above the four servos."""
    brush, s = Brush(spec.worldbody.add_body(name="base"), FIXED_GROUP), _scale(dims)
    brush.cylinder((0, 0, 0.025 * s), (0, 0, 0.033 * s), 1.35 * dims.k, PAINT)
    brush.cylinder((0, 0, 0.033 * s), (0, 0, 0.040 * s), 0.35 * dims.k, STEEL)
    for arm in range(N_ARMS):
        out = np.array([np.cos(arm * np.pi / 2), np.sin(arm * np.pi / 2), 0.0])
        side = np.array([-out[1], out[0], 0.0])
        centre = dims.k * out
        # A box of a quarter turn is a box along the axes; half extents are the absolute values.
        half = np.abs(0.014 * out + 0.017 * side) + np.array([0.0, 0.0, 0.023])
        brush.box(centre - 0.006 * s * out, s * half, MOTOR)
        brush.cylinder(centre - 0.020 * s * side, centre + 0.020 * s * side, 0.010 * s, ACCENT)


def dress_arm(body: MjsBody, dims: Dimensions) -> None:
    """Draw a fork on both sides of the servo, and the elbow's axle."""
    brush, s = Brush(body), _scale(dims)
    spread = 0.020 * s
    for side in (-spread, spread):
        brush.capsule((0, side, 0), (dims.r, side, 0), 0.004 * s, PRINT)
    brush.capsule((dims.r, -spread, 0), (dims.r, spread, 0), 0.003 * s, STEEL)


def dress_rod(body: MjsBody, dims: Dimensions) -> None:
    """Draw both tubes of the parallelogram."""
    brush, s = Brush(body), _scale(dims)
    spread = 0.016 * s
    for side in (-spread, spread):
        brush.capsule((0, side, 0), (0, side, -dims.l), 0.0022 * s, CARBON)
    brush.capsule((0, -spread, -dims.l), (0, spread, -dims.l), 0.003 * s, STEEL)


def dress_middle(body: MjsBody, dims: Dimensions) -> None:
    """Draw the bar between forearms 1 and 3 with the bearings of the halves."""
    brush, s = Brush(body), _scale(dims)
    brush.box((0, 0, 0), (dims.u, 0.006 * s, 0.003 * s), PAINT)
    for y in (-dims.v, dims.v):
        brush.capsule((-0.018 * s, y, 0), (0.018 * s, y, 0), 0.003 * s, STEEL)
    for x in (-0.020 * s, 0.020 * s):
        brush.box((x, 0, 0), (0.002 * s, dims.v + 0.004 * s, 0.004 * s), PAINT)


def dress_half(body: MjsBody, dims: Dimensions, sign: float) -> None:
    """Draw a gear wheel of the radius v and the lever to the forearm."""
    brush, s = Brush(body), _scale(dims)
    brush.cylinder((-0.005 * s, 0, 0), (0.005 * s, 0, 0), 0.98 * dims.v, ACCENT)
    brush.capsule((0, 0, 0), (0, sign * dims.w, 0), 0.004 * s, PRINT)


def dress_finger(body: MjsBody, claws: Claws, pad: tuple[float, float, float], sign: float) -> None:
    """Draw a bent bar from the folding axis to the back of the pad."""
    brush, length = Brush(body), claws.length
    plate, spread, thick = 0.03 * length, 0.3 * claws.pad[0], 0.04 * length
    back = pad[1] + sign * (claws.pad[1] / 2.0 + plate)
    # The knee lies outwards, on the side of the pad's back, and leaves the space between the pads free.
    knee = (sign * 0.16 * length, -0.45 * length)
    for x in (-spread, spread):
        brush.capsule((x, 0, 0), (x, *knee), thick, PRINT)
        brush.capsule((x, *knee), (x, back, -length), thick, PRINT)
    brush.box((0, back, -length), (claws.pad[0] / 2.0, plate, claws.pad[2] / 2.0), PRINT)


def _scale(dims: Dimensions) -> float:
    """Size of the robot over the size of the prototype."""
    return dims.r / PROTOTYPE.r
