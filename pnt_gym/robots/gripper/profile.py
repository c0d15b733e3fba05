"""What the motors can do, and how a motion gathers and loses speed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal, final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.errors import ConfigError
from pnt_gym.planning.motion.limits import MotionLimits
from pnt_gym.planning.motion.scurve import min_time_scurve

MOTOR_SPEED: Final = 70.0 * 2.0 * np.pi / 60.0
"""70 rpm, the largest speed of the prototype's motors [rad/s] (section VI-B)."""


@final
@dataclass(frozen=True)
class JointLimits:
    """What every motor can do.

    Raises:
        ConfigError: (a ValueError) a limit that is not positive.
    """

    speed: float = MOTOR_SPEED
    """[rad/s]"""
    acceleration: float = np.inf
    """[rad/s2]; not published, so without a bound unless given."""

    def __post_init__(self) -> None:
        if not (np.isfinite(self.speed) and self.speed > 0.0):
            raise ConfigError(f"joint speed is {self.speed} rad/s; it must be positive and finite")
        if not self.acceleration > 0.0:
            raise ConfigError(f"joint acceleration is {self.acceleration} rad/s2; it must be positive")


@final
@dataclass(frozen=True)
class Profile:
    """How progress runs from 0 to 1 in a time of 1.

    Raises:
        ConfigError: (a ValueError) an unknown kind, or a ramp outside (0, 0.5].
    """

    kind: Literal["trapezoid", "s-curve"] = "trapezoid"
    """Constant acceleration in the ramps, or one that rises and falls linearly."""
    ramp: float = 0.25
    """Share of the time spent speeding up, and again slowing down."""

    def __post_init__(self) -> None:
        if self.kind not in ("trapezoid", "s-curve"):
            raise ConfigError(f"profile kind is {self.kind!r}; it must be 'trapezoid' or 's-curve'")
        if not 0.0 < self.ramp <= 0.5:
            raise ConfigError(f"profile ramp is {self.ramp}; it must lie in (0, 0.5]")

    def sample(self, time: Floats) -> tuple[Floats, Floats, Floats]:
        """Return progress and its first two derivatives at times (S,) from 0 to 1."""
        peak = 1.0 / (1.0 - self.ramp)
        if self.kind == "s-curve":
            # Two jerk segments fill a ramp, so its highest acceleration is twice the mean one.
            limits = MotionLimits(peak, 2.0 * peak / self.ramp, 4.0 * peak / self.ramp**2)
            return min_time_scurve(1.0, limits).sample(time)
        slope, left = peak / self.ramp, 1.0 - time
        early, late = time < self.ramp, left < self.ramp
        straight = peak * (time - 0.5 * self.ramp)
        progress = np.where(early, 0.5 * slope * time**2, np.where(late, 1.0 - 0.5 * slope * left**2, straight))
        return progress, slope * np.minimum(np.minimum(time, left), self.ramp), slope * (1.0 * early - 1.0 * late)
