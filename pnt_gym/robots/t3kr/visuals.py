"""Visual geoms of the T3KR robot, massless and without contacts: group 1 for the base, group 2 for moving parts."""

import numpy as np

from pnt_gym.engine import MjsBody, MjSpec
from pnt_gym.palette import ACCENT, CARBON, MOTOR, PAINT, STEEL
from pnt_gym.robots.brush import FIXED_GROUP, Brush
from pnt_gym.robots.t3kr.geometry import N_ARMS, T3krGeometry

_JOINT_RADIUS = 0.014
_TUBE_RADIUS = 0.008


def dress_base(spec: MjSpec, geometry: T3krGeometry) -> None:
    """Draw the mounting plate with a motor on each axis."""
    brush = Brush(spec.worldbody.add_body(name="base", pos=[0, 0, geometry.pivot_z]), FIXED_GROUP)
    half_x, half_y = geometry.pivot_x + 0.10, geometry.pivot_y + 0.08
    brush.box((0, 0, 0.100), (half_x, half_y, 0.036), PAINT)
    brush.box((0, 0, 0.138), (half_x - 0.06, half_y - 0.06, 0.012), STEEL)
    brush.box((0, 0, 0.073), (half_x - 0.10, 0.015, 0.003), ACCENT)
    for arm in range(N_ARMS):
        axis, centre = geometry.arms.motor_axis[arm], geometry.arms.pivot[arm] * np.array([1.0, 1.0, 0.0])
        brush.cylinder(centre - 0.085 * axis, centre + 0.085 * axis, 0.055, MOTOR)
        brush.cylinder(centre - 0.095 * axis, centre + 0.095 * axis, 0.030, STEEL)
        brush.box(centre + np.array([0, 0, 0.055]), (0.045, 0.045, 0.025), PAINT)


def dress_arm(body: MjsBody, geometry: T3krGeometry, axle: bool) -> None:
    """Draw a tapered arm; the elbow carries an axle for two rods, or a single joint."""
    length, brush = geometry.arm_length, Brush(body)
    brush.capsule((0, 0, 0), (0.45 * length, 0, 0), 0.036, ACCENT)
    brush.capsule((0.45 * length, 0, 0), (length, 0, 0), 0.024, ACCENT)
    brush.cylinder((0.45 * length, 0, 0), (0.45 * length + 0.03, 0, 0), 0.037, PAINT)
    if axle:
        half = geometry.rod_spacing / 2
        brush.capsule((length, -half, 0), (length, half, 0), 0.010, STEEL)


def dress_rod(body: MjsBody, geometry: T3krGeometry, single: bool) -> None:
    """Draw one carbon tube with ball joints, or a frame of two tubes when the body stands for a pair of rods."""
    brush, length, half = Brush(body), geometry.rod_length, geometry.rod_spacing / 2
    for side in (0.0,) if single else (half, -half):
        brush.capsule((0, side, 0), (0, side, -length), _TUBE_RADIUS, CARBON)
    for height in (0.0, -length):
        brush.ball((0, 0, height), _JOINT_RADIUS, STEEL)
        if not single:
            brush.capsule((0, -half, height), (0, half, height), 0.010, STEEL)


def dress_platform(body: MjsBody, geometry: T3krGeometry, axles: bool) -> None:
    """Draw a disc with a bracket to each forearm, and the stem that carries the suction cup."""
    brush, height = Brush(body), geometry.attach_height
    brush.cylinder((0, 0, height - 0.012), (0, 0, height + 0.012), 0.070, PAINT)
    brush.cylinder((0, 0, height + 0.012), (0, 0, height + 0.017), 0.045, ACCENT)
    brush.cylinder((0, 0, 0.030), (0, 0, height), 0.016, STEEL)
    for arm in range(N_ARMS):
        attach = geometry.arms.attach[arm]
        brush.capsule((0, 0, height), attach, 0.013, PAINT)
        if axles:
            axle = geometry.rod_spacing / 2 * geometry.arms.motor_axis[arm]
            brush.capsule(attach - axle, attach + axle, 0.010, STEEL)
