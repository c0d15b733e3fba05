"""What only tests ask of the T3KR-class robot: its workspace, the tilt of its rods, and joint rates by themselves."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pnt_gym.arrays import Floats
from pnt_gym.robots.t3kr.dynamics import HandMotion, joint_motion
from pnt_gym.robots.t3kr.geometry import T3KR, T3krGeometry
from pnt_gym.robots.t3kr.kinematics import components, per_arm, solve_arms


def rod_tilt(tcp: ArrayLike, geometry: T3krGeometry = T3KR) -> Floats:
    """Angle of each forearm out of its arm's plane.

    Args:
        tcp: (..., 3) points, m.
        geometry: the robot.

    Returns:
        (..., 4) tilt in rad, positive along the motor axis; at most 0.71 in the default workspace.
    """
    shape, points = components(tcp)
    arms = solve_arms(points, geometry)
    # Out of the plane by arcsin(rod_y / l); written with the other two so that NaN passes through.
    return per_arm(np.arctan2(arms.rod_y, np.hypot(arms.rod_x, arms.rod_z)), shape)


def in_workspace(tcp: ArrayLike, geometry: T3krGeometry = T3KR) -> NDArray[np.bool_]:
    """Whether points lie in the elliptical workspace, its boundary included.

    The mechanism reaches further in places; the ellipse keeps its rods below 45 degrees of tilt.

    Args:
        tcp: (..., 3) points, m. NaN is outside.
        geometry: the robot.

    Returns:
        (...,) booleans.
    """
    points = np.asarray(tcp, dtype=np.float64)
    x, y, z = points[..., 0] / geometry.workspace_x, points[..., 1] / geometry.workspace_y, points[..., 2]
    # Rounding of the two divisions must not expel points on the boundary.
    return (x * x + y * y <= 1.0 + 1e-12) & (z >= geometry.z_min) & (z <= geometry.z_max)


def joint_velocity(position: ArrayLike, velocity: ArrayLike, geometry: T3krGeometry = T3KR) -> Floats:
    """Arm velocities (..., 4) in rad/s; arguments and NaN as `inverse_dynamics`."""
    shape, hand = HandMotion.stack(position, velocity, np.zeros(3))
    return per_arm(joint_motion(hand, geometry).velocity, shape)


def joint_acceleration(
    position: ArrayLike, velocity: ArrayLike, acceleration: ArrayLike, geometry: T3krGeometry = T3KR
) -> Floats:
    """Arm accelerations (..., 4) in rad/s^2; arguments and NaN as `inverse_dynamics`."""
    shape, hand = HandMotion.stack(position, velocity, acceleration)
    return per_arm(joint_motion(hand, geometry).acceleration, shape)
