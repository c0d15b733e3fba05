"""The 4-DoF parallel robot with a built-in gripper (Leveziel et al.): kinematics, indices, workspace and motions."""

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
from pnt_gym.robots.gripper.motion import (
    CIRCLE_RADIUS,
    Deviation,
    PoseMotion,
    circle,
    closing_time,
    joint_deviation,
    joint_move,
    line,
    travel_time,
)
from pnt_gym.robots.gripper.pose import PoseError
from pnt_gym.robots.gripper.profile import MOTOR_SPEED, JointLimits, Profile
from pnt_gym.robots.gripper.workspace import TauHull, Workspace, scan_workspace, tau_hull

__all__ = [
    "CIRCLE_RADIUS",
    "MOTOR_SPEED",
    "PROTOTYPE",
    "PUBLISHED_TAU_SCALE",
    "Deviation",
    "Dimensions",
    "JointLimits",
    "PoseError",
    "PoseMotion",
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
