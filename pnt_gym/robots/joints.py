"""What every robot of a conveyor is to the engine: names of its parts, and joints for the motion of its hand.

A robot turns motions of its hand into motions of its joints at coarse knots, say every 4 ms. Between knots the joint's
position is the cubic with the exact end positions and velocities, the velocity is that cubic's derivative, and the
torque is linear. A row does not depend on the other rows.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Protocol, Self, TypeAlias, final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.compiled import kernel
from pnt_gym.engine import MjModel, mujoco
from pnt_gym.errors import PntGymError
from pnt_gym.rows import Floats3, Ints1

Place: TypeAlias = tuple[float, float, float]
"""A point, x, y and z [m]."""
CONTROLS: Final = 3
"""Position, velocity and feed-forward torque of a motor, in this order."""


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
        finite: Bools = np.isfinite(self.position)
        if finite.all():
            return self
        reached = np.atleast_2d(finite.all(axis=0))
        knots, count = np.arange(reached.shape[-1], dtype=np.int64), reached.sum(axis=-1, keepdims=True)
        leaves: Bools = (count > 0) & np.equal(reached, knots < count).all(axis=-1, keepdims=True)
        last, rests = np.where(leaves, np.minimum(knots, count - 1), knots)[None], leaves & (knots >= count)
        position, torque = (np.take_along_axis(part, last, axis=2) for part in (self.position, self.torque))
        velocity, acceleration = (np.where(rests, 0.0, part) for part in (self.velocity, self.acceleration))
        return JointMotion(position, velocity, acceleration, torque)


@final
@dataclass(frozen=True, eq=False)
class MotorLimits:
    """Range (rad), largest speed (rad/s) and torque (N m) of M motors; (M,) arrays, infinite where none is known."""

    lower: Floats
    upper: Floats
    speed: Floats
    torque: Floats

    @classmethod
    def of_torque(cls, torque: float, count: int) -> MotorLimits:
        """Limits of motors of which the torque alone is known."""
        free = np.full(count, np.inf)
        return cls(-free, free, free, np.full(count, torque))

    def shares(self, motion: JointMotion) -> Floats:
        """Largest share of each limit that a motion (M, ...) takes: of the range, the speed and the torque (3, ...).

        A share above 1 is beyond the limit. The share of a range is 0 at its middle and 1 at its ends.
        """
        extra = (1,) * (motion.position.ndim - 1)
        lower, upper, speed, torque = (
            np.reshape(limit, (-1, *extra)) for limit in (self.lower, self.upper, self.speed, self.torque)
        )
        bounded = np.isfinite(lower) & np.isfinite(upper)
        low, high = np.where(bounded, lower, -1.0), np.where(bounded, upper, 1.0)
        aside = np.where(bounded, np.abs(2.0 * motion.position - low - high) / (high - low), 0.0)
        taken = aside, np.abs(motion.velocity) / speed, np.abs(motion.torque) / torque
        return np.stack([share.max(axis=0) for share in taken])


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
    def limits(self) -> MotorLimits:
        """Limits of the motors."""
        ...

    @property
    def mount(self) -> Place:
        """Place at which the robot is mounted [m]."""
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


def knot_count(steps: int, stride: int) -> int:
    """Knots that `steps` samples need when every `stride`-th sample is a knot.

    Args:
        steps: number of samples; sample k is at time k * timestep.
        stride: samples per knot interval.

    Raises:
        PntGymError: (a ValueError) steps or stride is below 1.
    """
    if steps < 1 or stride < 1:
        raise PntGymError(f"steps and stride must be at least 1, got {steps} and {stride}")
    return (steps + stride - 2) // stride + 1


def upsample(knots: JointMotion, spacing: float, stride: int, out: Floats, counts: Ints | None = None) -> Floats:
    """Fill a control array from knots, sample k at time k * spacing / stride (the start of physics step k).

    Args:
        knots: N motions at their knots.
        spacing: time between knots, s.
        stride: samples per knot interval.
        out: contiguous (N, steps, C); columns 0 to 3 M - 1 of M motors are written, others are left as they are.
        counts: number of samples that are written of each motion (N,), at most `steps`; None for all.

    Returns:
        out.

    Raises:
        PntGymError: (a ValueError) the shapes do not fit, or the spacing is not positive.
    """
    rows, steps, width = out.shape
    have, need = knots.position.shape[1:], (rows, knot_count(steps, stride))
    columns = CONTROLS * len(knots.position)
    if have != need or width < columns:
        raise PntGymError(
            f"out of shape {out.shape} with stride {stride} needs knots of shape {need} "
            f"and at least {columns} columns, got knots of shape {have}"
        )
    if not 0.0 < spacing < np.inf:
        raise PntGymError(f"spacing must be positive and finite, got {spacing} s")
    written: Ints = np.full((rows,), steps, dtype=np.int64) if counts is None else counts
    fill_controls(knots.position, knots.velocity, knots.torque, spacing, stride, out, written)
    return out


@kernel
def fill_controls(
    position: Floats3, velocity: Floats3, torque: Floats3, spacing: float, stride: int, out: Floats3, counts: Ints1
) -> None:
    """Fill position, velocity and torque of each motor at samples from those at knots.

    The position is the cubic Hermite p0 + h01 (p1 - p0) + h10 v0 + h11 v1, the velocity its derivative; the torque is
    linear.

    Args:
        position: at the knots (M, N, K), as velocity and torque.
        velocity: see position.
        torque: see position.
        spacing: time between knots [s].
        stride: samples per knot interval.
        out: (N, steps, 3 M and more), of which 3 M columns are filled.
        counts: numbers of samples of the motions (N,).
    """
    motors = len(position)
    for row in range(out.shape[0]):
        steps = counts[row]
        for first in range(0, steps, stride):
            knot = first // stride
            for arm in range(motors):
                p, v, t = position[arm, row, knot], velocity[arm, row, knot], torque[arm, row, knot]
                sample = out[row, first, 3 * arm : 3 * arm + 3]
                sample[0], sample[1], sample[2] = p, v, t
            for step in range(1, min(stride, steps - first)):
                u = step / stride
                # h10 and h11 times the spacing [s], h01 and its derivative by time, and the derivatives of h10 and h11.
                left, right = u * ((1.0 - u) * (1.0 - u)) * spacing, u * u * (u - 1.0) * spacing
                blend, slope = u * u * (3.0 - 2.0 * u), 6.0 * u * (1.0 - u) / spacing
                early, late = (1.0 - u) * (1.0 - 3.0 * u), u * (3.0 * u - 2.0)
                for arm in range(motors):
                    p, v, t = position[arm, row, knot], velocity[arm, row, knot], torque[arm, row, knot]
                    dp, w = position[arm, row, knot + 1] - p, velocity[arm, row, knot + 1]
                    sample = out[row, first + step, 3 * arm : 3 * arm + 3]
                    sample[0] = p + blend * dp + left * v + right * w
                    sample[1] = slope * dp + early * v + late * w
                    sample[2] = t + u * (torque[arm, row, knot + 1] - t)
