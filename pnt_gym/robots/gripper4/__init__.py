"""The 4-DoF parallel robot with a built-in gripper (Leveziel et al.): kinematics, indices, workspace and motions."""

from pnt_gym.robots.gripper4.check import check_pose
from pnt_gym.robots.gripper4.geometry import PROTOTYPE, Dimensions
from pnt_gym.robots.gripper4.indices import (
    PUBLISHED_TAU_SCALE,
    Singularity,
    conditioning,
    folding_speed,
    kappa,
    singular_angle,
    singularity,
    tau,
)
from pnt_gym.robots.gripper4.jacobian import inverse_jacobian, jacobian, jacobian_q, jacobian_x
from pnt_gym.robots.gripper4.kinematics import closure_excess, forward_kinematics, inverse_kinematics
from pnt_gym.robots.gripper4.motion import (
    CIRCLE_RADIUS,
    Deviation,
    Motion,
    circle,
    closing_time,
    joint_deviation,
    joint_move,
    line,
    travel_time,
)
from pnt_gym.robots.gripper4.pose import PoseError
from pnt_gym.robots.gripper4.profile import MOTOR_SPEED, JointLimits, Profile
from pnt_gym.robots.gripper4.workspace import TauHull, Workspace, scan_workspace, tau_hull

__all__ = [
    "CIRCLE_RADIUS",
    "MOTOR_SPEED",
    "PROTOTYPE",
    "PUBLISHED_TAU_SCALE",
    "Deviation",
    "Dimensions",
    "JointLimits",
    "Motion",
    "PoseError",
    "Profile",
    "Singularity",
    "TauHull",
    "Workspace",
    "check_pose",
    "circle",
    "closing_time",
    "closure_excess",
    "conditioning",
    "folding_speed",
    "forward_kinematics",
    "inverse_jacobian",
    "inverse_kinematics",
    "jacobian",
    "jacobian_q",
    "jacobian_x",
    "joint_deviation",
    "joint_move",
    "kappa",
    "line",
    "scan_workspace",
    "singular_angle",
    "singularity",
    "tau",
    "tau_hull",
    "travel_time",
]
