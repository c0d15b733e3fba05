"""Where the robot's numbers stand in a compiled model, and joint positions that close its loops."""

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats, Ints
from pnt_gym.engine import MjModel, mujoco
from pnt_gym.robots.t3kr.geometry import N_ARMS
from pnt_gym.robots.t3kr.kinematics import components, solve_arms
from pnt_gym.robots.t3kr.model import T3krHandles

CONTROLS_PER_MOTOR = 3
"""Position (rad), velocity (rad/s) and feed-forward torque (N m)."""


def closed_pose(tcp: ArrayLike, handles: T3krHandles) -> Floats:
    """Joint positions with every loop closed, so that a simulation starts without a jerk.

    Args:
        tcp: (N, 3) TCP, m.
        handles: the robot.

    Returns:
        (N, n) positions in the order of `qpos_columns`: n = 15 with four rods, 27 with eight (the last
        four a quaternion); NaN rows where the TCP is out of reach.
    """
    _, points = components(np.atleast_2d(np.asarray(tcp, dtype=np.float64)))
    arms = solve_arms(points, handles.geometry)
    q = np.arctan2(arms.sin, arms.cos)
    # A rod's frame is turned by q + swing about -y of the arm frame, then by tilt about x.
    swing = np.arctan2(arms.rod_x, -arms.rod_z) - q
    tilt = np.arctan2(arms.rod_y, np.hypot(arms.rod_x, arms.rod_z))
    rods = [swing[:, None], tilt[:, None]] * (len(handles.equalities) // N_ARMS)
    chains = np.concatenate([q[:, None], *rods], axis=1).reshape(-1, points.shape[1])
    level = np.zeros((4, points.shape[1]) if handles.rods == "eight" else (0, points.shape[1]))
    level[:1] = 1.0
    pose = np.concatenate([chains, points, level]).T
    pose[np.isnan(pose).any(axis=1)] = np.nan
    return np.ascontiguousarray(pose)


def qpos_columns(model: MjModel, handles: T3krHandles) -> Ints:
    """(n,) columns of the model's qpos that `closed_pose` fills: `qpos[:, columns] = closed_pose()`."""
    ball = int(mujoco.mjtJoint.mjJNT_BALL.value)
    columns: list[int] = []
    for name in handles.joints:
        joint = model.joint(name)
        start = int(joint.qposadr[0])
        columns += range(start, start + (4 if int(joint.type[0]) == ball else 1))
    return np.array(columns, dtype=np.int64)


def control_columns(model: MjModel, handles: T3krHandles) -> Ints:
    """(12,) columns of ctrl: position, velocity and feed-forward torque of motor 0, then of motors 1 to 3.

    A motor has three controls, so its controls are found through `actuator_ctrladr`, not through its id.
    """
    starts = [int(model.actuator_ctrladr[model.actuator(name).id]) for name in handles.actuators]
    return np.array([start + k for start in starts for k in range(CONTROLS_PER_MOTOR)], dtype=np.int64)
