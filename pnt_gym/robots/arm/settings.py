"""What a model file does not say of an arm: its place, its hand, and limits that the file lacks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

from pnt_gym.arrays import Point
from pnt_gym.errors import ConfigError


@final
@dataclass(frozen=True)
class ArmSettings:
    """What a model file does not say of an arm."""

    base: Point = (0.0, 0.0, 0.0)
    """Place of the model's origin in the cell [m]."""
    turn: Point = (0.0, 0.0, 0.0)
    """Rotation vector of the model's axes in the cell [rad]."""
    tool: str | None = None
    """Site or body whose z axis points out of the flange; None for the body behind the last joint."""
    stem: float = 0.1
    """Distance of the cup's tip from the tool, along its z axis [m]."""
    hand: float = 0.5
    """Mass of the cup and its mount, in the middle of the stem [kg]."""
    home: tuple[float, ...] | None = None
    """Positions of the joints near which the arm works; None for the file's key "home", or zeros [rad, m]."""
    speed: tuple[float, ...] | None = None
    """Largest speeds of the joints; None for those of the file [rad/s, m/s]."""
    torque: tuple[float, ...] | None = None
    """Largest torques of the motors; None for those of the file [N m, N]."""


def fitting(name: str, values: Sequence[float], count: int) -> Sequence[float]:
    """The values, one for each of the joints.

    Raises:
        ConfigError: there are more or fewer values than joints.
    """
    if len(values) != count:
        raise ConfigError(f"robot.model.{name} has {len(values)} values, and the arm has {count} joints")
    return values
