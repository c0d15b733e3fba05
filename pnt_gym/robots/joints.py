"""What every robot of a conveyor is to the engine: names of its parts, and joints for the motion of its hand."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, Self, final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats, Ints
from pnt_gym.engine import MjModel, mujoco


@final
@dataclass(frozen=True)
class JointMotion:
    """Joint angle (rad), velocity (rad/s), acceleration (rad/s^2) and motor torque (N m); (M, ...) arrays."""

    position: Floats
    velocity: Floats
    acceleration: Floats
    torque: Floats

    def within_reach(self) -> JointMotion:
        """The motion at knots, each (M, N, K), at rest from where a hand that rides with a belt has left the workspace.

        A motion that comes back from out of reach, or that begins there, stays as it is: not finite.
        """
        reached = np.isfinite(self.position).all(axis=0)
        if reached.all():
            return self
        knots, count = np.arange(reached.shape[1]), reached.sum(axis=1)[:, None]
        leaves = (count > 0) & (reached == (knots < count)).all(axis=1)[:, None]
        last, rests = np.where(leaves, np.minimum(knots, count - 1), knots)[None], leaves & (knots >= count)
        position, torque = (np.take_along_axis(part, last, axis=2) for part in (self.position, self.torque))
        velocity, acceleration = (np.where(rests, 0.0, part) for part in (self.velocity, self.acceleration))
        return JointMotion(position, velocity, acceleration, torque)


class RobotModel(Protocol):
    """A robot in a model: the names of its elements, and its kinematics and dynamics."""

    @property
    def joints(self) -> tuple[str, ...]:
        """All joints, in the order of `pose`."""
        ...

    @property
    def motor_joints(self) -> tuple[str, ...]:
        """Joints that the M motors drive."""
        ...

    @property
    def actuators(self) -> tuple[str, ...]:
        """Motors; each takes three consecutive controls: position, velocity, feed-forward torque."""
        ...

    @property
    def mount(self) -> float:
        """Height at which the robot is mounted, above the workspace [m]."""
        ...

    @property
    def tcp(self) -> str:
        """Site at the hand."""
        ...

    def with_prefix(self, prefix: str) -> Self:
        """The names of the robot's elements after its specification is attached to another one with a prefix."""
        ...

    def pose(self, hand: ArrayLike) -> Floats:
        """Joint positions (N, n) with the hand at points (N, 3) [m]; NaN where the hand cannot be."""
        ...

    def rates(self, hand: ArrayLike, velocity: ArrayLike) -> Floats:
        """Joint velocities (N, n) while the hand at points (N, 3) [m] moves with velocities (N, 3) [m/s]."""
        ...

    def motion(self, position: Floats, velocity: Floats, acceleration: Floats) -> JointMotion:
        """Motion and torques of the motors, each (M, ...), for the hand's motion (..., 3), without its object."""
        ...


def qpos_columns(model: MjModel, robot: RobotModel) -> Ints:
    """(n,) columns of the model's qpos that a pose fills: `qpos[:, columns] = robot.pose(hand)`."""
    return _columns(model, robot, "qposadr", 4)


def qvel_columns(model: MjModel, robot: RobotModel) -> Ints:
    """(n,) columns of the model's qvel that `robot.rates` fills."""
    return _columns(model, robot, "dofadr", 3)


def _columns(model: MjModel, robot: RobotModel, address: str, ball_width: int) -> Ints:
    """(n,) columns of all joints; a ball joint has `ball_width` columns, any other joint has one."""
    ball = int(mujoco.mjtJoint.mjJNT_BALL.value)
    columns: list[int] = []
    for name in robot.joints:
        joint = model.joint(name)
        start = int(getattr(joint, address)[0])
        columns += range(start, start + (ball_width if int(joint.type[0]) == ball else 1))
    return np.array(columns, dtype=np.int64)
