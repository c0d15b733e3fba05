"""Inverse kinematics in closed form and forward kinematics by Newton's method, for any number of poses at once.

A pose is (x, y, z, theta): the middle of the platform in m and the angle of its geared halves in rad, 0 when flat and
negative when they hang down. Motor angles q count from the outward horizontal of each arm, up positive. A row's result
does not depend on the batch's other rows.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Bools, Floats, numbers
from pnt_gym.robots.gripper.closure import excess, forearms, joints, solve_joints
from pnt_gym.robots.gripper.geometry import N_ARMS, PROTOTYPE, Dimensions
from pnt_gym.robots.gripper.pose import PoseError, as_rows, columns, map_pieces, pose_rows

ITERATIONS: Final = 60
"""Most Newton steps; poses within the strokes take 5 to 10, halved steps next to a singularity take more."""
CONVERGED: Final = 1e-8
"""Newton step [rad, and m over l] below which the iteration ends; the error left is of the step's square."""


def inverse_kinematics(
    pose: ArrayLike, dimensions: Dimensions = PROTOTYPE, *, branch: ArrayLike = 1, strokes: bool = False
) -> Floats:
    """Return the motor angles that put the platform at a pose (Leveziel et al., Eqs. 5 to 7).

    Args:
        pose: (..., 4) x, y, z [m], theta [rad].
        dimensions: the robot.
        branch: 1 for elbows outward below the base, the working branch; -1 for inward; or 1 or -1 per arm (4,).
        strokes: whether a pose beyond a motor's stroke is out of reach as well.

    Returns:
        (..., 4) angles [rad] from the outward horizontal, up positive, within half a turn; all four NaN where any
        arm is out of reach.

    Raises:
        PoseError: (a ValueError) the shape is not (..., 4), a number is not finite, or a branch is not 1 or -1.
    """
    shape, rows = pose_rows(pose)
    sign = branch_signs(branch)

    def angles(components: Floats) -> Floats:
        cos, sin, _ = solve_joints(joints(components, dimensions), dimensions, sign)
        q = np.arctan2(sin, cos, out=sin)
        # A NaN anywhere makes the sum NaN.
        unreachable = np.isnan(q[0] + q[1] + q[2] + q[3])
        if strokes:
            unreachable |= ~within_strokes(q, dimensions)
        q[:, unreachable] = np.nan
        return q.T

    return map_pieces(angles, rows).reshape(*shape, N_ARMS)


def forward_kinematics(q: ArrayLike, dimensions: Dimensions = PROTOTYPE, *, start: ArrayLike | None = None) -> Floats:
    """Return the platform's pose at given motor angles, by damped Newton steps on the closure equations.

    No step may end on the far side of det J_x = 0, so the assembly mode is the start's. With the pose a moment ago as
    the start, the solution is the pose that the robot itself would take.

    Args:
        q: (..., 4) motor angles [rad] from the outward horizontal, up positive; NaN gives NaN.
        dimensions: the robot.
        start: (4,) or (..., 4) pose to start from, such as the pose a moment ago; the home pose when not given.

    Returns:
        (..., 4) x, y, z [m], theta [rad]; NaN where Newton's method finds no pose in the robot's assembly mode.

    Raises:
        PoseError: (a ValueError) a shape is wrong, an angle is infinite, or the start is not finite.
    """
    shape, angles = as_rows(q, "q", N_ARMS)
    if np.isinf(angles).any():
        raise PoseError(f"q must hold angles in rad, got {angles[np.isinf(angles)][0]}")
    start_shape, start_rows = pose_rows(dimensions.home if start is None else start, "start")
    if start_shape not in ((), shape):
        raise PoseError(f"start must have shape (4,) or {(*shape, 4)} as q has, got {(*start_shape, 4)}")
    inputs = np.concatenate([angles, np.broadcast_to(start_rows, angles.shape)], axis=1)
    return map_pieces(lambda part: _newton(part[:4], part[4:], dimensions).T, inputs).reshape(*shape, 4)


def closure_excess(pose: ArrayLike, q: ArrayLike, dimensions: Dimensions = PROTOTYPE) -> Floats:
    """Return the closure error (|A_i - B_i|^2 - l^2) / 2 of each forearm (..., 4) [m2]; zero when ``q`` fits ``pose``.

    The error's derivative by the pose is J_x, by the angles minus J_q. Both arguments have the same shape (..., 4).

    Raises:
        PoseError: (a ValueError) a shape is wrong, or a number is not finite.
    """
    shape, rows = pose_rows(pose)
    angle_shape, angle_rows = pose_rows(q, "q")
    if shape != angle_shape:
        raise PoseError(f"pose has shape {(*shape, 4)} but q has {(*angle_shape, 4)}; give one row each")
    components, angles = columns(rows), columns(angle_rows)
    points = joints(components, dimensions)
    lengths = excess(forearms(components, points, np.cos(angles), np.sin(angles), dimensions), points, dimensions)
    return np.ascontiguousarray(lengths.T).reshape(*shape, N_ARMS)


def branch_signs(branch: ArrayLike) -> Floats | float:
    """Return the branch as a number, or as (4, 1) numbers, one per arm.

    Raises:
        PoseError: the branch is neither 1 nor -1, nor four of these numbers.
    """
    signs = numbers(branch, "branch")
    if signs.shape not in ((), (N_ARMS,)) or not np.isin(signs, (-1.0, 1.0)).all():
        raise PoseError(f"branch must be 1 (elbows outward) or -1 (inward), or four of these, got {branch!r}")
    return float(signs) if signs.ndim == 0 else signs[:, None]


def within_strokes(q: Floats, dims: Dimensions) -> Bools:
    """Whether all four of the (4, M) angles are within the strokes (M,), ends included; False for NaN."""
    low, high = dims.stroke
    inside = (q >= low) & (q <= high)
    return inside[0] & inside[1] & inside[2] & inside[3]


def _newton(q: Floats, start: Floats, dims: Dimensions) -> Floats:
    """Poses (4, M) for the angles (4, M), by Newton steps on the rows that have not converged."""
    result = np.full(q.shape, np.nan)
    rows = np.flatnonzero(~np.isnan(q.sum(axis=0)))
    cos, sin = np.cos(q[:, rows]), np.sin(q[:, rows])
    base: Floats = start[:, rows]
    step: Floats = np.zeros_like(base)
    share: Floats = np.ones(rows.size)
    merit: Floats = np.full(rows.size, np.inf)
    best_det: Floats = np.full(rows.size, -np.inf)
    for _ in range(ITERATIONS):
        if not rows.size:
            break
        with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
            trial = base + share * step
            points = joints(trial, dims)
            closure = forearms(trial, points, cos, sin, dims)
            load, det = excess(closure, points, dims), closure.determinant()
            size = np.max(np.abs(load), axis=0)
            # A step may not cross the singularity det J_x = 0 from the positive side.
            good = (size < merit) & (det > np.minimum(best_det, 0.0))
            newton = closure.solve(-load)
            # A step is at most a quarter of a forearm and a quarter of a radian.
            reach = np.maximum(np.max(np.abs(newton[:3]), axis=0) / dims.l, np.abs(newton[3]))
        converged = good & (reach < CONVERGED) & (det > 0.0)
        result[:, rows[converged]] = trial[:, converged] + newton[:, converged]
        base, step = np.where(good, trial, base), np.where(good, newton, step)
        share = np.where(good, np.minimum(1.0, 0.25 / np.maximum(reach, 1e-300)), 0.5 * share)
        merit, best_det = np.where(good, size, merit), np.where(good, det, best_det)
        keep = ~converged & np.isfinite(step).all(axis=0) & (share > 1e-9)
        rows, cos, sin = rows[keep], cos[:, keep], sin[:, keep]
        base, step, share, merit, best_det = base[:, keep], step[:, keep], share[keep], merit[keep], best_det[keep]
    return result
