"""Limits of the motors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.arrays import number
from pnt_gym.errors import ConfigError

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
