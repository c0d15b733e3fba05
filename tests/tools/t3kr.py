"""The T3KR's joints under any motion of the hand, in the shape of its arguments."""

import numpy as np

from pnt_gym.planning import EllipticWorkspace
from pnt_gym.robots.t3kr.geometry import T3KR
from pnt_gym.robots.t3kr.kinematics import joint_knots, per_arm

WORKSPACE = EllipticWorkspace(T3KR.workspace_x, T3KR.workspace_y, T3KR.z_min, T3KR.z_max)


def _per_arm(values):
    return per_arm(values.reshape(4, -1), values.shape[1:])


def joint_velocity(x, v):
    """Arm velocities (..., 4); NaN where out of reach."""
    return _per_arm(joint_knots(x, v, np.zeros(3)).velocity)


def joint_acceleration(x, v, a):
    """Arm accelerations (..., 4)."""
    return _per_arm(joint_knots(x, v, a).acceleration)


def motor_torque(x, v, a, payload=0.0):
    """Motor torques (..., 4), the smallest set in norm."""
    return _per_arm(joint_knots(x, v, a, payload).torque)
