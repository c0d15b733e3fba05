"""Check of poses, with one sentence that says why the robot cannot take a pose."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats
from pnt_gym.robots.gripper.closure import Arms, joints, solve_arms
from pnt_gym.robots.gripper.geometry import PROTOTYPE, Dimensions
from pnt_gym.robots.gripper.indices import singular_angle
from pnt_gym.robots.gripper.kinematics import within_strokes
from pnt_gym.robots.gripper.pose import PoseError, columns, pieces, pose_rows

# Tolerance for angles that were computed to lie on an end of a range [rad].
_ROUNDING = 1e-9


def check_pose(pose: ArrayLike, dimensions: Dimensions = PROTOTYPE, *, theta_limits: bool = True) -> None:
    """Raise unless the robot can take every pose: reach, strokes, assembly mode and range of theta, in this order.

    Args:
        pose: (..., 4) x, y, z [m], theta [rad].
        dimensions: the robot.
        theta_limits: whether theta must lie in the robot's range; if not, only the singularity bounds theta.

    Raises:
        PoseError: (a ValueError) with the first invalid pose, the arm or angle, its value and the valid range.
    """
    shape, rows = pose_rows(pose)
    for piece in pieces(rows.shape[0]):
        components = columns(rows[piece])
        arms = solve_arms(components, dimensions)
        q, det = np.arctan2(arms.sin, arms.cos), arms.closure.determinant()
        theta = components[3]
        low, high = dimensions.theta
        bad = ~within_strokes(q, dimensions) | ~(det > 0.0)
        if theta_limits:
            bad |= (theta < low - _ROUNDING) | (theta > high + _ROUNDING)
        if bad.any():
            first = int(bad.argmax())
            where = f" (row {piece.start + first})" if shape else ""
            row = rows[piece.start + first]
            x, y, z, angle = row[0], row[1], row[2], np.rad2deg(row[3])
            raise PoseError(f"pose ({x:.4g}, {y:.4g}, {z:.4g} m, {angle:.4g} deg){where}: {_reason(row, dimensions)}")


def _reason(pose: Floats, dims: Dimensions) -> str:
    components = columns(pose[None])
    arms = solve_arms(components, dims)
    if sentence := _reach(components, arms, dims):
        return sentence
    low, high = dims.stroke
    q = np.arctan2(arms.sin[:, 0], arms.cos[:, 0])
    out = (q < low) | (q > high)
    if out.any():
        arm = int(out.argmax())
        return (
            f"arm {arm + 1} would stand at {np.rad2deg(q[arm]):.2f} deg; "
            f"its stroke is {np.rad2deg(low):g} to {np.rad2deg(high):g} deg"
        )
    if arms.closure.determinant()[0] <= 0.0:
        sentence = "theta is at or past a singularity, where the motors lose hold of the platform"
        angle = float(singular_angle(pose[:3], dims))
        if pose[3] < angle or np.isnan(angle):
            return sentence
        return f"{sentence}; it must stay below {np.rad2deg(angle):.2f} deg at this position"
    low, high = np.rad2deg(dims.theta)
    return f"theta is {np.rad2deg(pose[3]):.2f} deg; it must lie in {low:g} to {high:g} deg"


def _reach(components: Floats, arms: Arms, dims: Dimensions) -> str:
    unreachable = np.isnan(arms.sin[:, 0])
    if not unreachable.any():
        return ""
    arm = int(unreachable.argmax())
    points = joints(components, dims)
    span, sideways = float(np.hypot(points.out[arm, 0], points.up[arm, 0])), abs(float(points.along[arm, 0]))
    if sideways > dims.l:
        return f"arm {arm + 1} is out of reach, {sideways:.4g} m beside its plane; its forearm has {dims.l:.4g} m"
    forearm = float(np.sqrt(dims.l**2 - sideways**2))
    low, high = abs(forearm - dims.r), forearm + dims.r
    return (
        f"arm {arm + 1} is out of reach, {span:.4g} m from motor axis to platform joint in the arm's plane; "
        f"it spans {low:.4g} to {high:.4g} m there"
    )
