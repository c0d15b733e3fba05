"""The T3KR's joints under any motion of the hand, in the shape of its arguments, and its controls."""

import numpy as np

from pnt_gym.planning import EllipticWorkspace
from pnt_gym.robots.t3kr.geometry import T3KR
from pnt_gym.robots.t3kr.kinematics import joint_knots, per_arm

WORKSPACE = EllipticWorkspace(T3KR.workspace_x, T3KR.workspace_y, T3KR.z_min, T3KR.z_max)


def control_columns(model, handles):
    """Columns of ctrl (12,): position, velocity and feed-forward torque of motor 0, then of motors 1 to 3.

    A motor has three controls, so the columns come from `actuator_ctrladr`, not from the motor's id.
    """
    starts = [int(model.actuator_ctrladr[model.actuator(name).id]) for name in handles.actuators]
    return np.array([start + k for start in starts for k in range(3)])


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
