"""Motor references: controls that make the hand follow a Cartesian motion.

Inverse kinematics and dynamics are evaluated at coarse knots; `pnt_gym.robots.joints` fills what lies between. A row
does not depend on the other rows.
"""

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.robots.joints import JointMotion
from pnt_gym.robots.t3kr import kernel
from pnt_gym.robots.t3kr.geometry import N_ARMS, T3KR, T3krGeometry


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
