"""The 4-DoF parallel robot with a built-in gripper (Leveziel et al.): kinematics and indices."""

from typing import TYPE_CHECKING

from pnt_gym.errors import refuse_moved_names
from pnt_gym.robots.gripper.check import check_pose
from pnt_gym.robots.gripper.geometry import PROTOTYPE, Dimensions
from pnt_gym.robots.gripper.indices import (
    PUBLISHED_TAU_SCALE,
    Singularity,
    conditioning,
    folding_speed,
    kappa,
    singular_angle,
    singularity,
    tau,
)
from pnt_gym.robots.gripper.jacobian import inverse_jacobian, jacobian, jacobian_q, jacobian_x
from pnt_gym.robots.gripper.kinematics import closure_excess, forward_kinematics, inverse_kinematics
from pnt_gym.robots.gripper.motion import MOTOR_SPEED, JointLimits, travel_time
from pnt_gym.robots.gripper.pose import PoseError

__all__ = [
    "MOTOR_SPEED",
    "PROTOTYPE",
    "PUBLISHED_TAU_SCALE",
    "Dimensions",
    "JointLimits",
    "PoseError",
    "Singularity",
    "check_pose",
    "closure_excess",
    "conditioning",
    "folding_speed",
    "forward_kinematics",
    "inverse_jacobian",
    "inverse_kinematics",
    "jacobian",
    "jacobian_q",
    "jacobian_x",
    "kappa",
    "singular_angle",
    "singularity",
    "tau",
    "travel_time",
]

if not TYPE_CHECKING:
    _MOTION = (
        "CIRCLE_RADIUS", "Deviation", "PoseMotion", "Profile", "circle", "closing_time", "joint_deviation",
        "joint_move", "line",
    )  # fmt: skip
    _SCAN = ("TauHull", "Workspace", "scan_workspace", "tau_hull")
    __getattr__ = refuse_moved_names(
        __name__,
        {**dict.fromkeys(_MOTION, "papers.leveziel.motion"), **dict.fromkeys(_SCAN, "papers.leveziel.scan")},
    )
