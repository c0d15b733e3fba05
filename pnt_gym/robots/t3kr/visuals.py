"""How the robot looks: massless geoms that touch nothing, group 1 for the base and group 2 for what moves."""

import numpy as np

from pnt_gym.engine import MjsBody, MjSpec
from pnt_gym.planning.arrays import Floats
from pnt_gym.robots.brush import FIXED_GROUP, Brush
from pnt_gym.robots.t3kr.geometry import N_ARMS, T3krGeometry

_PAINT = (0.93, 0.94, 0.95, 1.0)
_STEEL = (0.62, 0.65, 0.69, 1.0)
_MOTOR = (0.16, 0.18, 0.21, 1.0)
_ACCENT = (0.95, 0.47, 0.09, 1.0)
_CARBON = (0.09, 0.09, 0.10, 1.0)

_JOINT_RADIUS = 0.014
_TUBE_RADIUS = 0.008


def dress_base(spec: MjSpec, geometry: T3krGeometry) -> None:
    """Mounting plate with a motor on each axis."""
    brush = Brush(spec.worldbody.add_body(name="base", pos=[0, 0, geometry.pivot_z]), FIXED_GROUP)
    half_x, half_y = geometry.pivot_x + 0.10, geometry.pivot_y + 0.08
    brush.box((0, 0, 0.095), (half_x, half_y, 0.020), _PAINT)
    brush.box((0, 0, 0.127), (half_x - 0.06, half_y - 0.06, 0.012), _STEEL)
    brush.box((0, 0, 0.073), (half_x - 0.10, 0.015, 0.003), _ACCENT)
    for arm in range(N_ARMS):
        axis, centre = _motor_axis(geometry, arm), geometry.arms.pivot[arm] * np.array([1.0, 1.0, 0.0])
        brush.cylinder(centre - 0.085 * axis, centre + 0.085 * axis, 0.055, _MOTOR)
        brush.cylinder(centre - 0.095 * axis, centre + 0.095 * axis, 0.030, _STEEL)
        brush.box(centre + np.array([0, 0, 0.055]), (0.045, 0.045, 0.025), _PAINT)


def dress_arm(body: MjsBody, geometry: T3krGeometry, axle: bool) -> None:
    """Tapered arm; the elbow carries an axle for two rods or a single joint."""
    length, brush = geometry.arm_length, Brush(body)
    brush.capsule((0, 0, 0), (0.45 * length, 0, 0), 0.034, _PAINT)
    brush.capsule((0.45 * length, 0, 0), (length, 0, 0), 0.022, _PAINT)
    brush.cylinder((0.45 * length, 0, 0), (0.45 * length + 0.03, 0, 0), 0.035, _ACCENT)
    if axle:
        half = geometry.rod_spacing / 2
        brush.capsule((length, -half, 0), (length, half, 0), 0.010, _STEEL)


def dress_rod(body: MjsBody, geometry: T3krGeometry, single: bool) -> None:
    """One carbon tube with ball joints, or a frame of two tubes when the body stands for a pair."""
    brush, length, half = Brush(body), geometry.rod_length, geometry.rod_spacing / 2
    for side in (0.0,) if single else (half, -half):
        brush.capsule((0, side, 0), (0, side, -length), _TUBE_RADIUS, _CARBON)
    for height in (0.0, -length):
        brush.ball((0, 0, height), _JOINT_RADIUS, _STEEL)
        if not single:
            brush.capsule((0, -half, height), (0, half, height), 0.010, _STEEL)


def dress_platform(body: MjsBody, geometry: T3krGeometry, axles: bool) -> None:
    """Disc with a bracket to each forearm, and the stem that carries the suction cup."""
    brush, height = Brush(body), geometry.attach_height
    brush.cylinder((0, 0, height - 0.012), (0, 0, height + 0.012), 0.070, _PAINT)
    brush.cylinder((0, 0, height + 0.012), (0, 0, height + 0.017), 0.045, _ACCENT)
    brush.cylinder((0, 0, 0.030), (0, 0, height), 0.016, _STEEL)
    for arm in range(N_ARMS):
        attach = geometry.arms.attach[arm]
        brush.capsule((0, 0, height), attach, 0.013, _PAINT)
        if axles:
            axle = geometry.rod_spacing / 2 * _motor_axis(geometry, arm)
            brush.capsule(attach - axle, attach + axle, 0.010, _STEEL)


def _motor_axis(geometry: T3krGeometry, arm: int) -> Floats:
    """Unit vector along a motor axis."""
    frames = geometry.arms
    return np.array([-frames.sin[arm, 0], frames.cos[arm, 0], 0.0])
