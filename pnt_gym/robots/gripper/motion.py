"""Limits of the motors, and the lower bound of their time from pose to pose."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats, number
from pnt_gym.errors import ConfigError
from pnt_gym.robots.gripper.geometry import PROTOTYPE, Dimensions
from pnt_gym.robots.gripper.kinematics import inverse_kinematics
from pnt_gym.robots.gripper.pose import CHUNK, pieces, pose_pairs

_PARTS = 64
MOTOR_SPEED: Final = 70.0 * 2.0 * np.pi / 60.0
"""70 rpm, the largest speed of the prototype's motors [rad/s] (section VI-B)."""


@final
@dataclass(frozen=True)
class JointLimits:
    """Largest speed and acceleration of every motor.

    Raises:
        ConfigError: (a ValueError) a limit is not positive.
    """

    speed: float = MOTOR_SPEED
    """Largest speed of every motor [rad/s]."""
    acceleration: float = np.inf
    """Largest acceleration of every motor [rad/s2]; not published, so unbounded by default."""

    def __post_init__(self) -> None:
        if not 0.0 < number(self.speed, "joint speed") < np.inf:
            raise ConfigError(f"joint speed is {self.speed} rad/s; it must be positive and finite")
        if not number(self.acceleration, "joint acceleration") > 0.0:
            raise ConfigError(f"joint acceleration is {self.acceleration} rad/s2; it must be positive")


def travel_time(
    start: ArrayLike, end: ArrayLike, dimensions: Dimensions = PROTOTYPE, *, speed: float = MOTOR_SPEED
) -> Floats:
    """Return the times of straight lines between poses when at every point the slowest motor runs at its largest speed.

    The time is a lower bound for every motion along the line, since acceleration and braking take longer.

    Args:
        start: (..., 4) x, y, z [m], theta [rad].
        end: (..., 4), the same shape.
        dimensions: the robot.
        speed: largest speed of the motors [rad/s].

    Returns:
        (...,) [s]; NaN where a line leaves the reach.

    Raises:
        PoseError: (a ValueError) the shapes differ or are wrong, or a number is not finite.
        ConfigError: (a ValueError) the speed is not positive.
    """
    shape, first, last = pose_pairs(start, end)
    limit = JointLimits(speed).speed
    # Sums of angle differences stay exact up to a stretched arm, where joint rates are infinite.
    share = np.linspace(0.0, 1.0, _PARTS + 1)[:, None]
    seconds = np.empty(len(first))
    for piece in pieces(len(first), max(1, CHUNK // _PARTS)):
        q = inverse_kinematics(first[piece, None] + share * (last - first)[piece, None], dimensions)
        seconds[piece] = np.abs(np.diff(q, axis=1)).max(axis=2).sum(axis=1) / limit
    return seconds.reshape(shape)
