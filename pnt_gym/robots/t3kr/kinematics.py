"""Closed-form kinematics of the T3KR-class robot, for any number of poses at once.

Joint angles are measured from the outward horizontal, up positive; arm i stands in quadrant i,
counter-clockwise from (+x, +y). The platform never rotates. All arithmetic is
element-wise, so a pose's result does not depend on the batch's other poses.
"""

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats
from pnt_gym.robots.t3kr.geometry import N_ARMS, T3KR, T3krGeometry


@final
@dataclass(frozen=True)
class ArmPose:
    """Angles and rods of the four arms, each in its own frame; every array is (4, M). NaN where out of reach."""

    cos: Floats
    """Cosine of the arm angle."""
    sin: Floats
    """Sine of the arm angle."""
    rod_x: Floats
    """Rod from elbow to platform joint, outward component, m."""
    rod_y: Floats
    """Component of the rod along the motor axis, m."""
    rod_z: Floats
    """Upward component of the rod, m."""
    root: Floats
    """Minus the rod's component along the elbow's direction of travel, m: zero where the arm is singular."""
    reach: Floats
    """Component along the arm of the vector from pivot to platform joint, m."""


def components(points: ArrayLike) -> tuple[tuple[int, ...], Floats]:
    """Split (..., 3) or (..., 4) points into their leading shape and contiguous (3 or 4, M) components."""
    array = np.asarray(points, dtype=np.float64)
    return array.shape[:-1], np.ascontiguousarray(array.reshape(-1, array.shape[-1]).T)


def per_arm(values: Floats, shape: tuple[int, ...]) -> Floats:
    """(4, M) values as (*shape, 4); a pose that any arm cannot reach is NaN for all four arms."""
    values[:, np.isnan(values).any(axis=0)] = np.nan
    return np.ascontiguousarray(values.T).reshape(*shape, N_ARMS)


def solve_arms(tcp: Floats, geometry: T3krGeometry = T3KR) -> ArmPose:
    """Arm poses for the (3, M) TCP components, elbows outward.

    In an arm's plane, with d from pivot to platform joint, |d - L n(q)|^2 = l^2 is k = d_x cos q + d_z sin q
    with k = (|d|^2 + L^2 - l^2) / 2L; the outward elbow is the root with the larger q.
    """
    frames, length = geometry.arms, geometry.arm_length
    # Components of d in the arm's frame: along its azimuth, across it, and up.
    d_x = frames.cos * tcp[0] + frames.sin * tcp[1] + frames.offset_x
    d_y = frames.cos * tcp[1] - frames.sin * tcp[0] + frames.offset_y
    d_z = tcp[2] + frames.offset_z
    planar = d_x * d_x + d_z * d_z
    # k of the docstring.
    reach = (planar + d_y * d_y + (length**2 - geometry.rod_length**2)) * (0.5 / length)
    with np.errstate(invalid="ignore", divide="ignore"):
        # The direction of d, turned by the angle whose cosine is k / |d| in the plane.
        root = np.sqrt(planar - reach * reach)
        scale = 1.0 / planar
        cos = (d_x * reach - d_z * root) * scale
        sin = (d_z * reach + d_x * root) * scale
    return ArmPose(cos, sin, d_x - length * cos, d_y, d_z - length * sin, root, reach)


def inverse_kinematics(tcp: ArrayLike, geometry: T3krGeometry = T3KR) -> Floats:
    """Arm angles that put the TCP at a point.

    Args:
        tcp: (..., 3) points in the world, m.
        geometry: the robot.

    Returns:
        (..., 4) arm angles in rad from the outward horizontal, up positive; all four NaN where out of reach.
    """
    shape, points = components(tcp)
    arms = solve_arms(points, geometry)
    return per_arm(np.arctan2(arms.sin, arms.cos), shape)


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
    shape, angles = components(q)
    frames = geometry.arms
    out = geometry.arm_length * np.cos(angles)
    centre = np.stack(
        [
            frames.cos * out + (frames.pivot[:, :1] - frames.attach[:, :1]),
            frames.sin * out + (frames.pivot[:, 1:2] - frames.attach[:, 1:2]),
            geometry.arm_length * np.sin(angles) - frames.offset_z,
        ]
    )
    with np.errstate(invalid="ignore", divide="ignore"):
        point = _trilaterate(centre[:, 0], centre[:, 1], centre[:, 2], geometry.rod_length)
        for _ in range(2):
            point = point + _fit_step(point[:, None] - centre, geometry.rod_length)
    return np.ascontiguousarray(point.T).reshape(*shape, 3)


def _dot(a: Floats, b: Floats) -> Floats:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _trilaterate(a: Floats, b: Floats, c: Floats, radius: float) -> Floats:
    """Lower of the two points at distance `radius` from three (3, M) centres, below the centres' circumcentre.

    With the normal n = ab x ac the circumcentre is a + (|ac|^2 n x ab + |ab|^2 ac x n) / (2 |n|^2).
    """
    ab, ac = b - a, c - a
    normal = np.cross(ab, ac, axis=0)
    area = _dot(normal, normal)
    normal_ab, normal_ac = np.cross(normal, ab, axis=0), np.cross(ac, normal, axis=0)
    centre = (_dot(ac, ac) * normal_ab + _dot(ab, ab) * normal_ac) / (2.0 * area)
    height = np.sqrt((radius * radius - _dot(centre, centre)) / area)
    return a + centre - np.copysign(height, normal[2]) * normal


def _fit_step(rods: Floats, length: float) -> Floats:
    """Gauss-Newton step (3, M) of the TCP that brings the (3, 4, M) rods to their length."""
    norm = np.sqrt(_dot(rods, rods))
    unit = rods / norm
    load = (unit * (length - norm)).sum(axis=1)
    return solve_normal(unit, load)


def solve_normal(rows: Floats, load: Floats) -> Floats:
    """Solve (R^T R) x = load by cofactors, with R the (3, 4, M) rows by component and load, x (3, M)."""
    x, y, z = rows
    # Entries of the symmetric matrix R^T R.
    xx, yy, zz = (x * x).sum(axis=0), (y * y).sum(axis=0), (z * z).sum(axis=0)
    xy, xz, yz = (x * y).sum(axis=0), (x * z).sum(axis=0), (y * z).sum(axis=0)
    # Cofactors of the first row, which give the determinant; then the other cofactors.
    c_xx, c_xy, c_xz = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    scale = 1.0 / (xx * c_xx + xy * c_xy + xz * c_xz)
    a, b, c = load * scale
    c_yy, c_yz, c_zz = xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy
    first, second = c_xx * a + c_xy * b + c_xz * c, c_xy * a + c_yy * b + c_yz * c
    return np.stack([first, second, c_xz * a + c_yz * b + c_zz * c])


def jacobian_rows(arms: ArmPose, geometry: T3krGeometry = T3KR) -> Floats:
    """dq/dx as (3, 4, M), by component of the TCP, arm, pose, from rod . (v - L dq/dt t) = 0.

    v is the TCP's velocity, t the elbow's direction of travel, L the arm's length.
    """
    frames = geometry.arms
    with np.errstate(invalid="ignore", divide="ignore"):
        scale = -1.0 / (geometry.arm_length * arms.root)
        out, along, up = arms.rod_x * scale, arms.rod_y * scale, arms.rod_z * scale
        return np.stack([frames.cos * out - frames.sin * along, frames.sin * out + frames.cos * along, up])


def jacobian(tcp: ArrayLike, geometry: T3krGeometry = T3KR) -> Floats:
    """Derivative of the arm angles by the TCP.

    Args:
        tcp: (..., 3) points, m.
        geometry: the robot.

    Returns:
        (..., 4, 3) dq/dx in rad/m; NaN where out of reach.
    """
    shape, points = components(tcp)
    rows = jacobian_rows(solve_arms(points, geometry), geometry)
    rows[:, :, np.isnan(rows).any(axis=(0, 1))] = np.nan
    return np.ascontiguousarray(rows.transpose(2, 1, 0)).reshape(*shape, N_ARMS, 3)


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
    _, points = components(np.atleast_2d(np.asarray(tcp, dtype=np.float64)))
    arms = solve_arms(points, geometry)
    q = np.arctan2(arms.sin, arms.cos)
    # A rod's frame is turned by q + swing about -y of the arm frame, then by tilt about x.
    swing = np.arctan2(arms.rod_x, -arms.rod_z) - q
    tilt = np.arctan2(arms.rod_y, np.hypot(arms.rod_x, arms.rod_z))
    rods = [swing[:, None], tilt[:, None]] * rods_per_arm
    chains = np.concatenate([q[:, None], *rods], axis=1).reshape(-1, points.shape[1])
    level = np.zeros((4 if rods_per_arm == 2 else 0, points.shape[1]))
    level[:1] = 1.0
    pose = np.concatenate([chains, points, level]).T
    pose[np.isnan(pose).any(axis=1)] = np.nan
    return np.ascontiguousarray(pose)


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
    _, points = components(np.atleast_2d(np.asarray(tcp, dtype=np.float64)))
    _, (x, y, z) = components(np.atleast_2d(np.asarray(velocity, dtype=np.float64)))
    arms, frames = solve_arms(points, geometry), geometry.arms
    rows = jacobian_rows(arms, geometry)
    turn = rows[0] * x + rows[1] * y + rows[2] * z
    # The rod's lower end moves with the platform, its upper end with the elbow: difference of the two velocities.
    out = frames.cos * x + frames.sin * y + geometry.arm_length * arms.sin * turn
    along = frames.cos * y - frames.sin * x
    up = z - geometry.arm_length * arms.cos * turn
    planar = arms.rod_x**2 + arms.rod_z**2
    swing = (arms.rod_x * up - arms.rod_z * out) / planar - turn
    level = np.sqrt(planar)
    tilt = (along * level - arms.rod_y * (arms.rod_x * out + arms.rod_z * up) / level) / (planar + arms.rod_y**2)
    rods = [swing[:, None], tilt[:, None]] * rods_per_arm
    chains = np.concatenate([turn[:, None], *rods], axis=1).reshape(-1, points.shape[1])
    still = np.zeros((3 if rods_per_arm == 2 else 0, points.shape[1]))
    rates = np.concatenate([chains, np.stack([x, y, z]), still]).T
    rates[np.isnan(rates).any(axis=1)] = np.nan
    return np.ascontiguousarray(rates)
