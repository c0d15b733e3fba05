"""Joint positions of the model in a pose of the platform, and motor references along a motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats
from pnt_gym.constants import GRAVITY
from pnt_gym.robots.gripper.build import PROTOTYPE_BUILD, Build
from pnt_gym.robots.gripper.closure import joints
from pnt_gym.robots.gripper.geometry import N_ARMS, PROTOTYPE, Dimensions
from pnt_gym.robots.gripper.jacobian import inverse_jacobian
from pnt_gym.robots.gripper.kinematics import inverse_kinematics
from pnt_gym.robots.gripper.pose import PoseError, columns, pose_rows


@final
@dataclass(frozen=True, eq=False)
class MotorReferences:
    """Angle, speed and torque references of the motors at the start of every step; (..., S, 4) each."""

    angle: Floats
    """[rad]"""
    speed: Floats
    """[rad/s]"""
    torque: Floats
    """Feed-forward [N m]."""

    def controls(self) -> Floats:
        """The model's controls (..., S, 12): angle, speed and torque of each motor in turn."""
        stacked = np.stack([self.angle, self.speed, self.torque], axis=-1)
        return stacked.reshape(*stacked.shape[:-2], 3 * N_ARMS)


def closed_pose(pose: ArrayLike, dimensions: Dimensions = PROTOTYPE) -> Floats:
    """Return the joint positions of the model with its loops closed and its fingers relaxed.

    Args:
        pose: (..., 4) x, y, z [m], theta [rad].
        dimensions: the robot.

    Returns:
        (..., 19): arm angle, swing and tilt of its forearm for each arm; x, y, z; half and finger, right, then left.

    Raises:
        PoseError: (a ValueError) a pose is out of reach, or its shape is wrong.
    """
    shape, rows = pose_rows(pose)
    q = inverse_kinematics(rows, dimensions).T
    if np.isnan(q).any():
        raise PoseError("the robot cannot be set up in a pose that is out of reach")
    points = joints(columns(rows), dimensions)
    cos, sin = np.cos(q), np.sin(q)
    out, up = points.out - dimensions.r * cos, points.up - dimensions.r * sin
    # Coordinate along each arm's own y axis, which turns with the arm's azimuth.
    side = points.along * np.array([1.0, -1.0, -1.0, 1.0])[:, None]
    forward, above = out * cos + up * sin, up * cos - out * sin
    swing, tilt = np.arctan2(forward, -above), np.arcsin(np.clip(side / dimensions.l, -1.0, 1.0))
    arms = np.stack([q, swing, tilt], axis=1).reshape(3 * N_ARMS, -1).T
    theta, zero = rows[:, 3:], np.zeros((len(rows), 1))
    return np.concatenate([arms, rows[:, :3], theta, zero, theta, zero], axis=1).reshape(*shape, 3 * N_ARMS + 7)


def motor_references(
    pose: ArrayLike,
    step: float,
    dimensions: Dimensions = PROTOTYPE,
    build: Build = PROTOTYPE_BUILD,
    *,
    payload: ArrayLike = 0.0,
    share: ArrayLike = 1.0,
) -> MotorReferences:
    """Return the motor references along poses that are one physics step apart.

    Speeds and accelerations are central differences. The torque moves the motor, the arm, the forearm (half of its mass
    at each end) and the platform with its load, and makes up for the torque lost to the motor's speed.

    Args:
        pose: (..., S, 4) x, y, z [m], theta [rad], S at least 3, smooth in time.
        step: time between the poses [s].
        dimensions: lengths.
        build: masses and servos.
        payload: mass that the platform carries, broadcast against (..., S) [kg].
        share: share of the torque that is fed forward, broadcast against (..., S, 4).

    Raises:
        PoseError: (a ValueError) a pose is out of reach, or there are fewer than three.
    """
    poses = np.asarray(pose, dtype=np.float64)
    if poses.ndim < 2 or poses.shape[-2] < 3:
        raise PoseError(f"references need at least three poses (..., S, 4), got shape {poses.shape}")
    q = inverse_kinematics(poses, dimensions)
    if np.isnan(q).any():
        raise PoseError("the motion leaves the robot's reach")
    speed = _rate(q, step)
    acceleration = _rate(speed, step)
    hand = _rate(_rate(poses[..., :3], step), step)
    # Motor, arm and the upper half of the forearm.
    inertia = build.servo.armature + (build.arm_mass / 3.0 + build.rod_mass / 2.0) * dimensions.r**2
    weight = (build.arm_mass + build.rod_mass) * GRAVITY * dimensions.r / 2.0
    torque = inertia * acceleration + build.servo.damping * speed + weight * np.cos(q)
    # The platform with its load: J_inv^T torque = force, with no force on the folding angle.
    mass = build.moving_mass + np.asarray(payload, dtype=np.float64)
    force = np.zeros(poses.shape)
    force[..., :3] = hand * mass[..., None]
    force[..., 2] += mass * GRAVITY
    transposed = np.swapaxes(inverse_jacobian(poses, dimensions), -1, -2)
    torque += np.linalg.solve(transposed, force[..., None])[..., 0]
    return MotorReferences(q, speed, torque * np.asarray(share, dtype=np.float64))


def _rate(values: Floats, step: float) -> Floats:
    return np.asarray(np.gradient(values, step, axis=-2), dtype=np.float64)
