"""The T3KR's joints under any motion of the hand, in the shape of its arguments."""

import numpy as np

from pnt_gym.planning import EllipticWorkspace
from pnt_gym.robots.t3kr.dynamics import HandMotion, joint_motion
from pnt_gym.robots.t3kr.geometry import T3KR
from pnt_gym.robots.t3kr.kinematics import per_arm

WORKSPACE = EllipticWorkspace(T3KR.workspace_x, T3KR.workspace_y, T3KR.z_min, T3KR.z_max)


def joint_velocity(x, v):
    """Arm velocities (..., 4); NaN where out of reach."""
    shape, hand = HandMotion.stack(x, v, np.zeros(3))
    return per_arm(joint_motion(hand).velocity, shape)


def joint_acceleration(x, v, a):
    """Arm accelerations (..., 4)."""
    shape, hand = HandMotion.stack(x, v, a)
    return per_arm(joint_motion(hand).acceleration, shape)


def motor_torque(x, v, a, payload=0.0):
    """Motor torques (..., 4), the smallest set in norm."""
    shape, hand = HandMotion.stack(x, v, a, payload)
    return per_arm(joint_motion(hand).torque, shape)
