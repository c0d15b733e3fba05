"""The differential model J_x dx = J_q dq (Leveziel et al., Eq. 8), with the angles of this package.

q counts from the outward horizontal; the paper's q_3 and q_4 are pi minus that, so entries (3, 3) and (4, 4) of J_q,
and columns 3 and 4 of J, have the opposite sign of the printed entries. kappa and tau are the same in both conventions.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats
from pnt_gym.robots.gripper.closure import Arms, arms_at
from pnt_gym.robots.gripper.geometry import N_ARMS, PROTOTYPE, Dimensions
from pnt_gym.robots.gripper.kinematics import branch_signs


def jacobian_x(pose: ArrayLike, dimensions: Dimensions = PROTOTYPE, *, branch: ArrayLike = 1) -> Floats:
    """Return J_x of Eq. 8 as printed.

    Args:
        pose: (..., 4) x, y, z [m], theta [rad].
        dimensions: the robot.
        branch: 1 for elbows outward, -1 for inward, or 1 or -1 per arm (4,).

    Returns:
        (..., 4, 4): columns 1 to 3 in m, column 4 in m2; NaN where out of reach.

    Raises:
        PoseError: (a ValueError) as `inverse_kinematics`.
    """
    return _matrices(pose, dimensions, branch, lambda arms: arms.closure.matrix())


def jacobian_q(pose: ArrayLike, dimensions: Dimensions = PROTOTYPE, *, branch: ArrayLike = 1) -> Floats:
    """Return J_q of Eq. 8, diagonal, (..., 4, 4) [m2]; arguments, NaN and errors as `jacobian_x`."""
    return _matrices(pose, dimensions, branch, lambda arms: arms.drive.T[:, :, None] * np.eye(N_ARMS))


def jacobian(pose: ArrayLike, dimensions: Dimensions = PROTOTYPE, *, branch: ArrayLike = 1) -> Floats:
    """Return J = J_x^-1 J_q, the derivative of the pose by the motor angles.

    Rows 1 to 3 are in m/rad, row 4 in rad/rad; infinite or NaN where J_x is singular. (..., 4, 4); arguments and
    errors as `jacobian_x`.
    """
    unit = np.eye(N_ARMS)[:, :, None]
    return _matrices(
        pose,
        dimensions,
        branch,
        lambda arms: np.stack([arms.closure.solve(load).T for load in arms.drive[:, None] * unit], axis=2),
    )


def inverse_jacobian(pose: ArrayLike, dimensions: Dimensions = PROTOTYPE, *, branch: ArrayLike = 1) -> Floats:
    """Return J_q^-1 J_x, the derivative of the motor angles by the pose.

    Columns 1 to 3 are in rad/m, column 4 in rad/rad; infinite or NaN where an arm is stretched or folded.
    (..., 4, 4); arguments and errors as `jacobian_x`.
    """
    return _matrices(pose, dimensions, branch, lambda arms: arms.closure.matrix() / arms.drive.T[:, :, None])


def _matrices(pose: ArrayLike, dims: Dimensions, branch: ArrayLike, function: Callable[[Arms], Floats]) -> Floats:
    with np.errstate(invalid="ignore", divide="ignore"):
        matrices = arms_at(pose, dims, function, branch_signs(branch))
    matrices[np.isnan(matrices).any(axis=(-2, -1))] = np.nan
    return matrices
