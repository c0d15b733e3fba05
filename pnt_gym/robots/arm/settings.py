"""What a model file does not say of an arm, and the limits of its joints, from the file or from the settings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, final

import numpy as np

from pnt_gym.arrays import Point
from pnt_gym.engine import MjModel, mujoco
from pnt_gym.errors import ConfigError
from pnt_gym.names import list_names
from pnt_gym.robots.arm.reading import ModelFile
from pnt_gym.robots.joints import MotorLimits


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
    """Positions of the joints near which the arm works; None for zeros [rad, m]."""
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


def joint_limits(file: ModelFile, joints: Sequence[int], names: Sequence[str], settings: ArmSettings) -> MotorLimits:
    """Ranges, speeds and torques of the joints.

    Raises:
        ConfigError: a speed or a torque is not known.
    """
    model, count = file.model, len(joints)
    lower, upper = np.full(count, -np.inf), np.full(count, np.inf)
    for k, joint in enumerate(joints):
        if bool(model.jnt_limited[joint]):
            lower[k], upper[k] = model.jnt_range[joint]
    if settings.speed is not None:
        speed: Any = fitting("speed", settings.speed, count)
    elif unknown := [name for name in names if not file.speeds.get(name, 0.0) > 0.0]:
        raise ConfigError(
            f"the largest speed of joint {list_names(unknown)} is missing; give robot.model.speed, a value a joint"
        )
    else:
        speed = [file.speeds[name] for name in names]
    if settings.torque is not None:
        torque: Any = fitting("torque", settings.torque, count)
    else:
        torque = [_torque(model, joint) for joint in joints]
        if unknown := [name for name, value in zip(names, torque, strict=True) if not 0.0 < value < np.inf]:
            raise ConfigError(
                f"joint {list_names(unknown)} has no actuator with a largest torque; give the model actuators with a "
                "forcerange, or give robot.model.torque, a value a joint"
            )
    return MotorLimits(lower, upper, np.array(speed, dtype=np.float64), np.array(torque, dtype=np.float64))


def _torque(model: MjModel, joint: int) -> float:
    """Largest torque of a joint's actuator in both directions; infinite where the file says none [N m, N]."""
    largest = np.inf
    if bool(model.jnt_actfrclimited[joint]):
        largest = float(np.abs(model.jnt_actfrcrange[joint]).min())
    driven = False
    for motor in range(int(model.nactuator)):
        kind, target = int(model.actuator_trntype[motor]), int(model.actuator_trnid[motor, 0])
        if kind != int(mujoco.mjtTrn.mjTRN_JOINT) or target != joint:
            continue
        driven, gear = True, abs(float(model.actuator_gear[motor, 0]))
        if bool(model.actuator_forcelimited[motor]):
            largest = min(largest, gear * float(np.abs(model.actuator_forcerange[motor]).min()))
        elif _is_plain(model, motor):
            gain = abs(float(model.actuator_gainprm[motor, 0]))
            controls = model.actuator_ctrlrange[int(model.actuator_ctrladr[motor])]
            largest = min(largest, gear * gain * float(np.abs(controls).min()))
    return largest if driven or largest < np.inf else 0.0


def _is_plain(model: MjModel, motor: int) -> bool:
    """Whether an actuator turns its bounded control into a torque, and adds nothing."""
    bounded = bool(model.actuator_ctrllimited[int(model.actuator_ctrladr[motor])])
    fixed, none = int(mujoco.mjtGain.mjGAIN_FIXED), int(mujoco.mjtBias.mjBIAS_NONE)
    return bounded and int(model.actuator_gaintype[motor]) == fixed and int(model.actuator_biastype[motor]) == none
