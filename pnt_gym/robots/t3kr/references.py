"""Motor references: controls that make the hand follow a Cartesian motion.

Inverse kinematics and dynamics are evaluated at coarse knots (say every 4 ms). Between knots the joint
angle is the cubic with the exact end angles and velocities, the joint velocity is that cubic's derivative,
and the torque is linear. A row does not depend on the other rows.
"""

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats
from pnt_gym.errors import PntGymError
from pnt_gym.robots.joints import JointMotion
from pnt_gym.robots.t3kr import kernel
from pnt_gym.robots.t3kr.geometry import N_ARMS, T3KR, T3krGeometry

CONTROLS = 3
"""Position, velocity and feed-forward torque of a motor, in this order."""


def knot_count(steps: int, stride: int) -> int:
    """Knots that `steps` samples need when every `stride`-th sample is a knot.

    Args:
        steps: number of samples; sample k is at time k * timestep.
        stride: samples per knot interval.

    Raises:
        PntGymError: (a ValueError) steps or stride is below 1.
    """
    if steps < 1 or stride < 1:
        raise PntGymError(f"steps and stride must be at least 1, got {steps} and {stride}")
    return (steps + stride - 2) // stride + 1


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
    motion = (np.asarray(position), np.asarray(velocity), np.asarray(acceleration))
    if not motion[0].shape == motion[1].shape == motion[2].shape:
        motion = np.broadcast_arrays(*motion)
    hand = np.concatenate(motion, axis=-1, dtype=np.float64)
    shape = hand.shape[:-1]
    mass, rows = np.full(shape, payload, dtype=np.float64).ravel(), np.ascontiguousarray(hand.reshape(-1, 9))
    joints = kernel.joint_motion(rows, mass, geometry.arms.rows, geometry.mechanism).reshape(5, N_ARMS, *shape)
    cos, sin, *rates = joints
    return JointMotion(np.arctan2(sin, cos), *rates)


def upsample(knots: JointMotion, spacing: float, stride: int, out: Floats) -> Floats:
    """Fill a control array from knots, sample k at time k * spacing / stride (the start of physics step k).

    Args:
        knots: N motions at their knots.
        spacing: time between knots, s.
        stride: samples per knot interval.
        out: contiguous (N, steps, C); columns 0 to 3 M - 1 of M motors are written, others are left as they are.

    Returns:
        out.

    Raises:
        PntGymError: (a ValueError) the shapes do not fit, or the spacing is not positive.
    """
    rows, steps, width = out.shape
    have, need = knots.position.shape[1:], (rows, knot_count(steps, stride))
    columns = CONTROLS * len(knots.position)
    if have != need or width < columns:
        raise PntGymError(
            f"out of shape {out.shape} with stride {stride} needs knots of shape {need} "
            f"and at least {columns} columns, got knots of shape {have}"
        )
    if not 0.0 < spacing < np.inf:
        raise PntGymError(f"spacing must be positive and finite, got {spacing} s")
    kernel.upsample(knots.position, knots.velocity, knots.torque, spacing, stride, out)
    return out
