"""Closed-form kinematics of the T3KR-class robot, and what its motors do for a motion, for many poses at once.

Joint angles are measured from the outward horizontal, up positive; arm i stands in quadrant i,
counter-clockwise from (+x, +y). The platform never rotates. A pose's result does not depend on the batch's other
poses.
"""

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats, in_order, tuples
from pnt_gym.robots.joints import JointMotion
from pnt_gym.robots.t3kr import kernel
from pnt_gym.robots.t3kr.geometry import N_ARMS, T3KR, T3krGeometry


def as_rows(points: ArrayLike, name: str, width: int = 3) -> tuple[tuple[int, ...], Floats]:
    """Split points (..., width) into their leading shape and rows (M, width), a copy.

    Raises:
        ValueError: the shape differs.
    """
    array = np.array(tuples(points, name, width), order="C")
    return array.shape[:-1], array.reshape(-1, width)


def per_arm(values: Floats, shape: tuple[int, ...]) -> Floats:
    """(4, M) values as (*shape, 4); a pose that any arm cannot reach is NaN for all four arms."""
    values[:, np.isnan(values).any(axis=0)] = np.nan
    return np.ascontiguousarray(values.T).reshape(*shape, N_ARMS)


def inverse_kinematics(tcp: ArrayLike, geometry: T3krGeometry = T3KR) -> Floats:
    """Arm angles that put the TCP at a point.

    Args:
        tcp: (..., 3) points in the world, m.
        geometry: the robot.

    Returns:
        (..., 4) arm angles in rad from the outward horizontal, up positive; all four NaN where out of reach.
    """
    shape, points = as_rows(tcp, "tcp")
    cos, sin = kernel.arm_poses(points, geometry.arms.rows, geometry.mechanism)[:2]
    return per_arm(np.arctan2(sin, cos), shape)


def forward_kinematics(q: ArrayLike, geometry: T3krGeometry = T3KR) -> Floats:
    """TCP for given arm angles: the point whose four rod lengths fit best.

    Four rods and three coordinates: trilateration on three rods, then two Gauss-Newton steps on all four. Angles
    that belong to a pose give that pose; measured angles give the least-squares point.

    Args:
        q: (..., 4) arm angles, rad.
        geometry: the robot.

    Returns:
        (..., 3) TCP in the world, m; NaN where the rods cannot meet.
    """
    shape, angles = as_rows(q, "q", N_ARMS)
    angles, frames = angles.T, geometry.arms
    out = geometry.arm_length * np.cos(angles)
    centre = np.stack(
        [
            frames.cos * out + (frames.pivot[:, :1] - frames.attach[:, :1]),
            frames.sin * out + (frames.pivot[:, 1:2] - frames.attach[:, 1:2]),
            geometry.arm_length * np.sin(angles) - frames.offset_z,
        ]
    )
    with np.errstate(invalid="ignore", divide="ignore"):
        # Lower of the two points at distance `radius` from three (3, M) centres, below the centres' circumcentre.
        a = centre[:, 0]
        ab, ac = centre[:, 1] - a, centre[:, 2] - a
        normal = np.cross(ab, ac, axis=0)
        area = _dot(normal, normal)
        normal_ab, normal_ac = np.cross(normal, ab, axis=0), np.cross(ac, normal, axis=0)
        middle = (_dot(ac, ac) * normal_ab + _dot(ab, ab) * normal_ac) / (2.0 * area)
        height = np.sqrt((geometry.rod_length * geometry.rod_length - _dot(middle, middle)) / area)
        point = a + middle - np.copysign(height, normal[2]) * normal
    point = np.ascontiguousarray(point.T)
    kernel.fit_points(np.ascontiguousarray(centre.T), geometry.rod_length, point)
    return point.reshape(*shape, 3)


def _dot(a: Floats, b: Floats) -> Floats:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def jacobian(tcp: ArrayLike, geometry: T3krGeometry = T3KR) -> Floats:
    """Derivative of the arm angles by the TCP.

    Args:
        tcp: (..., 3) points, m.
        geometry: the robot.

    Returns:
        (..., 4, 3) dq/dx in rad/m; NaN where out of reach.
    """
    shape, points = as_rows(tcp, "tcp")
    rows = kernel.jacobian(points, geometry.arms.rows, geometry.mechanism)
    rows[np.isnan(rows).any(axis=(1, 2))] = np.nan
    return rows.reshape(*shape, N_ARMS, 3)


def closed_pose(tcp: ArrayLike, rods_per_arm: int = 1, geometry: T3krGeometry = T3KR) -> Floats:
    """Joint positions of the model with every loop closed, so that a simulation starts without a jerk.

    Args:
        tcp: (N, 3) TCP, m.
        rods_per_arm: 1, or 2 where the platform may turn.
        geometry: the robot.

    Returns:
        (N, n) positions in the order of `model.qpos_columns`: n = 15 with one rod per arm, 27 with two (the last
        four a quaternion); NaN rows where the TCP is out of reach.
    """
    _, points = as_rows(tcp, "tcp")
    cos, sin, rod_x, rod_y, rod_z = kernel.arm_poses(points, geometry.arms.rows, geometry.mechanism)
    q = np.arctan2(sin, cos)
    # A rod's frame is turned by q + swing about -y of the arm frame, then by tilt about x.
    swing = np.arctan2(rod_x, -rod_z) - q
    tilt = np.arctan2(rod_y, np.hypot(rod_x, rod_z))
    level = np.array([1.0, 0.0, 0.0, 0.0] if rods_per_arm == 2 else [])
    return kernel.close_loops(q, swing, tilt, rods_per_arm, points, level)


def closed_velocity(
    tcp: ArrayLike, velocity: ArrayLike, rods_per_arm: int = 1, geometry: T3krGeometry = T3KR
) -> Floats:
    """Joint velocities of the model while the TCP moves and the loops stay closed, at positions of `closed_pose`.

    Args:
        tcp: (N, 3) TCP, m.
        velocity: (N, 3) of the TCP, m/s.
        rods_per_arm: 1, or 2 where the platform may turn.
        geometry: the robot.

    Returns:
        (N, n) velocities in the order of `model.qvel_columns`: n = 15 with one rod per arm, 26 with two (the last three
        the angular velocity of the platform, zero); NaN rows where the TCP is out of reach.
    """
    _, points = as_rows(tcp, "tcp")
    _, speeds = as_rows(velocity, "velocity")
    arm, swing, tilt = kernel.closed_velocity(points, speeds, geometry.arms.rows, geometry.mechanism)
    return kernel.close_loops(arm, swing, tilt, rods_per_arm, speeds, np.zeros(3 if rods_per_arm == 2 else 0))


def joint_knots(
    position: ArrayLike,
    velocity: ArrayLike,
    acceleration: ArrayLike,
    payload: ArrayLike = 0.0,
    *,
    geometry: T3krGeometry = T3KR,
) -> JointMotion:
    """Inverse kinematics and dynamics at the knots.

    Args:
        position: (N, K, 3) TCP, m; or any (..., 3).
        velocity: (N, K, 3) m/s.
        acceleration: (N, K, 3) m/s^2.
        payload: held mass, kg; broadcast to (N, K).
        geometry: the robot.

    Returns:
        Joint motion and torques at the knots, (4, N, K) arrays; not finite where a pose is out of reach or singular.
    """
    motion: tuple[Floats, ...] = tuple([np.asarray(part, np.float64) for part in (position, velocity, acceleration)])
    if not motion[0].shape == motion[1].shape == motion[2].shape:
        motion = tuple([part.copy() for part in np.broadcast_arrays(*motion)])
    shape = motion[0].shape[:-1]
    hand = kernel.HandMotion(*in_order(*[part.reshape(-1, 3) for part in motion]))
    mass = np.full(shape, payload, dtype=np.float64).ravel()
    joints = kernel.joint_motion(hand, mass, geometry.arms.rows, geometry.mechanism).reshape(5, N_ARMS, *shape)
    cos, sin, *rates = joints
    return JointMotion(np.arctan2(sin, cos), *rates)
