"""Limits of an arm's joints, from its file or from its settings."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from pnt_gym.engine import MjModel, mujoco
from pnt_gym.errors import ConfigError
from pnt_gym.names import list_names
from pnt_gym.robots.arm.reading import ModelFile
from pnt_gym.robots.arm.settings import ArmSettings, fitting
from pnt_gym.robots.joints import JointLimits


def joint_limits(file: ModelFile, joints: Sequence[int], names: Sequence[str], settings: ArmSettings) -> JointLimits:
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
    return JointLimits(lower, upper, np.array(speed, dtype=np.float64), np.array(torque, dtype=np.float64))


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
