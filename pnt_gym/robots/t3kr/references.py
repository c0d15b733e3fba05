"""Motor references: controls that make the hand follow a Cartesian motion.

Inverse kinematics and dynamics are evaluated at coarse knots (say every 4 ms). Between knots the joint
angle is the cubic with the exact end angles and velocities, the joint velocity is that cubic's derivative,
and the torque is linear. All arithmetic is element-wise, so a row does not depend on the other rows.
"""

from operator import methodcaller

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats, concatenate_records, take
from pnt_gym.errors import PntGymError
from pnt_gym.robots.t3kr.dynamics import HandMotion, JointMotion, joint_motion
from pnt_gym.robots.t3kr.geometry import N_ARMS, T3KR, T3krGeometry

N_CONTROLS = 12
"""Position, velocity and feed-forward torque of four motors, in this order per motor."""

_BLOCK = 4096
"""Poses evaluated together: temporary arrays of this size stay in the processor's second-level cache."""


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
        position: (N, K, 3) TCP, m.
        velocity: (N, K, 3) m/s.
        acceleration: (N, K, 3) m/s^2.
        payload: held mass, kg; broadcast to (N, K).
        geometry: the robot.

    Returns:
        Joint motion and torques at the knots, (4, N, K) arrays; NaN where a pose is out of reach.
    """
    (rows, knots), hand = HandMotion.stack(position, velocity, acceleration, payload)
    blocks: list[JointMotion] = []
    for start in range(0, rows * knots, _BLOCK):
        block = slice(start, start + _BLOCK)
        blocks.append(joint_motion(take(hand, (..., block)), geometry))
    whole = vars(concatenate_records(blocks, axis=1)).values()
    return JointMotion(*map(methodcaller("reshape", N_ARMS, rows, knots), whole))


def exact_references(knots: JointMotion) -> Floats:
    """References without interpolation, one exact sample per knot.

    Returns:
        (N, K, 12) controls [position, velocity, torque] of motors 0 to 3; NaN where out of reach.
    """
    out = np.empty((*knots.position.shape[1:], N_CONTROLS))
    for channel, values in enumerate((knots.position, knots.velocity, knots.torque)):
        out[..., channel::3] = values.transpose(1, 2, 0)
    return out


def upsample(knots: JointMotion, spacing: float, stride: int, out: Floats) -> Floats:
    """Fill a control array from knots, sample k at time k * spacing / stride (the start of physics step k).

    Args:
        knots: N motions at their knots.
        spacing: time between knots, s.
        stride: samples per knot interval.
        out: (N, steps, C) with C >= 12; columns 0 to 11 are written, further columns are left as they are.

    Returns:
        out.

    Raises:
        PntGymError: (a ValueError) the shapes do not fit, or the spacing is not positive.
    """
    rows, steps, width = out.shape
    have, need = knots.position.shape[1:], (rows, knot_count(steps, stride))
    if have != need or width < N_CONTROLS:
        raise PntGymError(
            f"out of shape {out.shape} with stride {stride} needs knots of shape {need} "
            f"and at least {N_CONTROLS} columns, got knots of shape {have}"
        )
    if not 0.0 < spacing < np.inf:
        raise PntGymError(f"spacing must be positive and finite, got {spacing} s")
    for arm in range(N_ARMS):
        _upsample_arm(knots, arm, spacing, stride, out[..., 3 * arm : 3 * arm + 3])
    return out


def _upsample_arm(knots: JointMotion, arm: int, spacing: float, stride: int, out: Floats) -> None:
    """Write position, velocity and torque of one arm between knots.

    The position is the cubic Hermite p0 + h01 (p1 - p0) + h10 v0 + h11 v1, the velocity its derivative; the torque is
    linear.
    """
    position, velocity, torque = knots.position[arm], knots.velocity[arm], knots.torque[arm]
    at_knots = out[:, ::stride]
    for channel, values in enumerate((position, velocity, torque)):
        at_knots[..., channel] = values[:, : at_knots.shape[1]]
    rise, lift = position[:, 1:] - position[:, :-1], torque[:, 1:] - torque[:, :-1]
    for step in range(1, stride):
        u = step / stride
        samples = out[:, step::stride]
        count = samples.shape[1]
        p, dp, t, dt = position[:, :count], rise[:, :count], torque[:, :count], lift[:, :count]
        v, w = velocity[:, :count], velocity[:, 1 : count + 1]
        # h10 and h11 of the Hermite basis; slopes by u are velocities times the spacing.
        left, right = u * (1.0 - u) ** 2 * spacing, u * u * (u - 1.0) * spacing
        samples[..., 0] = p + (u * u * (3.0 - 2.0 * u)) * dp + left * v + right * w
        # Derivatives of h01, h10 and h11 by time.
        slope = 6.0 * u * (1.0 - u) / spacing
        samples[..., 1] = slope * dp + ((1.0 - u) * (1.0 - 3.0 * u)) * v + (u * (3.0 * u - 2.0)) * w
        samples[..., 2] = t + u * dt
