"""Lengths, strokes and limits of Leveziel's 4-DoF parallel robot with a built-in gripper.

The letters are the paper's (Leveziel et al., "A 4-DoF parallel robot with a built-in gripper for waste sorting",
Fig. 4 and section VI-A). Arm 1 points along +x, arm 2 along +y, arm 3 along -x, arm 4 along -y; arms 1 and 3 carry
the platform's middle, arms 2 and 4 its two geared halves.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from numbers import Real
from typing import Any, Self, cast, final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.errors import ConfigError
from pnt_gym.names import unknown_name

N_ARMS = 4
LENGTHS = ("k", "r", "l", "u", "v", "w")
RANGES = ("stroke", "theta")


@final
@dataclass(frozen=True)
class Dimensions:
    """Lengths [m], angles [rad] and home pose of the robot; the defaults are the prototype's.

    Raises:
        ConfigError: (a ValueError) a length is not positive and finite, a range of angles is empty, the home pose is
            outside of its ranges, or the links do not close at home.
    """

    k: float = 0.0825
    """Motor axis from the z axis."""
    r: float = 0.080
    """Arm, from motor axis to elbow."""
    l: float = 0.223  # noqa: E741
    """Forearm, from elbow to platform."""
    u: float = 0.040
    """Half of the platform's middle part, along x."""
    v: float = 0.0135
    """Platform centre to the axis about which a half folds, along y."""
    w: float = 0.0265
    """Folding axis to the forearm's joint on the half."""
    stroke: tuple[float, float] = (float(np.deg2rad(-85.0)), float(np.deg2rad(45.0)))
    """Smallest and largest motor angle, from the outward horizontal, up positive (section V-A)."""
    theta: tuple[float, float] = (float(np.deg2rad(-60.0)), float(np.deg2rad(-30.0)))
    """Closed and open angle of the platform halves (section VI-B)."""
    home_z: float = -0.200
    """Height of the platform at home, as in the paper's Fig. 6."""
    home_theta: float = float(np.deg2rad(-45.0))
    """Angle of the halves at home (section V-D)."""

    def __post_init__(self) -> None:
        for name in LENGTHS:
            value = _number(name, getattr(self, name))
            if value <= 0.0:
                raise ConfigError(f"gripper robot: {name} is {value:g} m; a length must be positive")
            object.__setattr__(self, name, value)
        for name, limit in zip(RANGES, (np.pi, np.pi / 2), strict=True):
            object.__setattr__(self, name, _range(name, getattr(self, name), limit))
        for name in ("home_z", "home_theta"):
            object.__setattr__(self, name, _number(name, getattr(self, name)))
        if self.home_z >= 0.0:
            raise ConfigError(f"gripper robot: home_z is {self.home_z:g} m; the platform hangs below the base, z < 0")
        low, high = self.theta
        if not low <= self.home_theta <= high:
            raise ConfigError(
                f"gripper robot: home_theta is {self.home_theta:.4g} rad; it must lie in {low:.4g} to {high:.4g}"
            )
        side = self.v + self.w * np.cos(self.home_theta)
        drop = self.home_z + self.w * np.sin(self.home_theta)
        for span in (np.hypot(self.u - self.k, self.home_z), np.hypot(side - self.k, drop)):
            if not abs(self.l - self.r) < span < self.l + self.r:
                raise ConfigError(
                    f"gripper robot: an arm r = {self.r:g} m and a forearm l = {self.l:g} m cannot bridge the "
                    f"{span:.4g} m from motor to platform at home"
                )

    @classmethod
    def from_mapping(cls, values: Mapping[str, Any]) -> Self:
        """Return the robot of a mapping read from a YAML file; values that are not named are the prototype's.

        Raises:
            ConfigError: a name is no field, or a value is invalid.
        """
        names = [field.name for field in fields(cls)]
        for name in values:
            if name not in names:
                raise ConfigError(f"gripper robot: {unknown_name('dimension', name, names)}")
        return cls(**values)

    def with_scale(self, factor: float) -> Self:
        """Return the robot with every length multiplied by ``factor`` and the same angles.

        With 4.1 the robot reaches 0.65 m to the side, like the industrial robot whose proportions the paper takes.

        Raises:
            ConfigError: the factor is not positive and finite.
        """
        factor = _number("scale factor", factor)
        if factor <= 0.0:
            raise ConfigError(f"gripper robot: scale factor is {factor:g}; it must be positive")
        lengths = {name: getattr(self, name) * factor for name in (*LENGTHS, "home_z")}
        return replace(self, **lengths)

    @property
    def home(self) -> Floats:
        """The home pose (4,): x, y, z [m], theta [rad]."""
        return np.array([0.0, 0.0, self.home_z, self.home_theta])


def _number(name: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, Real):
        raise ConfigError(f"gripper robot: {name} must be a number, got {value!r}")
    number = float(value)
    if not np.isfinite(number):
        raise ConfigError(f"gripper robot: {name} must be finite, got {value}")
    return number


def _range(name: str, value: object, limit: float) -> tuple[float, float]:
    if isinstance(value, str) or not isinstance(value, Sequence | np.ndarray):
        raise ConfigError(f"gripper robot: {name} must be two angles, got {value!r}")
    ends = [_number(name, end) for end in cast("Sequence[object]", value)]
    if len(ends) != 2 or not -limit <= ends[0] < ends[1] <= limit:
        raise ConfigError(
            f"gripper robot: {name} must be two rising angles within +-{limit:.4g} rad, got {tuple(ends)}"
        )
    return ends[0], ends[1]


PROTOTYPE = Dimensions()
"""Dimensions of the prototype of Leveziel et al."""
