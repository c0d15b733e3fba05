"""Masses, servos and claws of the gripper robot, which its dynamics need and the paper does not print.

The prototype is made of Dynamixel XM430-W210 servos, carbon tubes, steel ball joints and printed parts (Leveziel et
al., section VI-A). Every mass below is assumed from such parts; the servo's torque and speed are its data sheet's at
12 V.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, Self, final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.errors import ConfigError
from pnt_gym.robots.gripper.motion import MOTOR_SPEED

_MASSES: Final = ("arm_mass", "rod_mass", "platform_mass", "half_mass", "finger_mass")

NO_LOAD_SPEED: Final = 77.0 * 2.0 * np.pi / 60.0
"""No-load speed of the XM430-W210 at 12 V, 77 rpm [rad/s]; the prototype moves at up to 70 rpm."""


def _check_positive(name: str, value: float) -> None:
    if not (np.isfinite(value) and value > 0.0):
        raise ConfigError(f"gripper robot: {name} is {value:g}; it must be positive and finite")


@final
@dataclass(frozen=True)
class MotorServo:
    """One motor with its gear and position controller, seen from the arm.

    The torque is the controller's, bounded by the stall torque, less a share that grows with the motor's speed:
    at the no-load speed no torque is left.

    Raises:
        ConfigError: (a ValueError) a value is not positive and finite.
    """

    stall_torque: float = 3.0
    """[N m]"""
    no_load_speed: float = NO_LOAD_SPEED
    """[rad/s]"""
    speed: float = MOTOR_SPEED
    """Largest speed that motions may ask for [rad/s]."""
    armature: float = 0.005
    """Inertia of rotor and gear, assumed [kg m2]."""
    kp: float = 200.0
    """Position gain [N m/rad]; the servo's own controller allows 14 (its default) to 280."""
    kv: float = 1.6
    """Speed gain [N m s/rad]; together with the motor's own damping critical."""

    def __post_init__(self) -> None:
        for name in ("stall_torque", "no_load_speed", "speed", "armature", "kp", "kv"):
            _check_positive(f"servo.{name}", getattr(self, name))

    @property
    def damping(self) -> float:
        """Torque lost per speed of the motor [N m s/rad]."""
        return self.stall_torque / self.no_load_speed


@final
@dataclass(frozen=True)
class Claws:
    """The two fingers: each finger hangs on a platform half by a torsion spring and ends in a flat soft pad.

    The spring is the compliance between platform and fingers that the paper asks for (section VII): claws that close
    further than the object is wide press with a known force instead of jamming the mechanism.

    Raises:
        ConfigError: (a ValueError) a value is not positive and finite, or the angle is not between -90 and 0 degrees.
    """

    length: float = 0.062
    """Folding axis to the middle of the pad [m]."""
    pad: tuple[float, float, float] = (0.030, 0.003, 0.020)
    """Size of a pad: length along x, thickness, height [m]."""
    width: float = 0.022
    """Distance of the pads at which they are parallel [m]."""
    theta: float = float(np.deg2rad(-50.0))
    """Angle of the platform halves while the pads are parallel [rad]."""
    stiffness: float = 2.0
    """Stiffness of the spring in each finger [N m/rad]."""
    damping: float = 0.005
    """Damping of the spring in each finger [N m s/rad]."""
    friction: float = 0.8
    """Friction coefficient of the pads, soft rubber."""

    def __post_init__(self) -> None:
        for name in ("length", "width", "stiffness", "damping", "friction"):
            _check_positive(f"claws.{name}", getattr(self, name))
        for value in self.pad:
            _check_positive("claws.pad", value)
        if not -np.pi / 2 < self.theta < 0.0:
            raise ConfigError(f"gripper robot: claws.theta is {self.theta:.4g} rad; it must lie in -1.571 to 0")

    def contact_theta(self, width: Floats) -> Floats:
        """Angles of the halves (...) [rad] at which relaxed pads just touch objects of given widths (...) [m]."""
        return np.asarray(self.theta + np.arcsin((width - self.width) / (2.0 * self.length)), dtype=np.float64)

    def gap(self, theta: float) -> float:
        """Width between the relaxed pads [m] with the halves at `theta` [rad]: the inverse of `contact_theta`."""
        return self.width + 2.0 * self.length * float(np.sin(theta - self.theta))

    def force(self, squeeze: float) -> float:
        """Force of one pad [N] when the halves are closed by `squeeze` [rad] beyond the contact."""
        return self.stiffness * squeeze / self.length


@final
@dataclass(frozen=True)
class Build:
    """Masses of the robot's parts [kg], all assumed, with its servo and its claws.

    Raises:
        ConfigError: (a ValueError) a mass is not positive and finite.
    """

    arm_mass: float = 0.030
    """An arm, slender: its centre of mass is at its middle."""
    rod_mass: float = 0.024
    """Both tubes of a forearm with their ball joints; slender."""
    platform_mass: float = 0.060
    """The platform's middle part."""
    half_mass: float = 0.015
    """Each half with its gear; the centre of mass is midway between axis and forearm."""
    finger_mass: float = 0.010
    """Each finger with its pad; the centre of mass is at half the length."""
    servo: MotorServo = MotorServo()
    claws: Claws = Claws()

    def __post_init__(self) -> None:
        for name in _MASSES:
            _check_positive(name, getattr(self, name))

    @property
    def moving_mass(self) -> float:
        """Mass that moves with the platform: its three parts, the fingers, the lower halves of the forearms [kg]."""
        return self.platform_mass + 2.0 * (self.half_mass + self.finger_mass) + 2.0 * self.rod_mass

    def with_scale(self, factor: float, servo: MotorServo) -> Self:
        """The build of a robot of the same form with all lengths multiplied by ``factor``, with other motors.

        Masses grow with the square of the lengths, as for tubes and sheets of the same thickness. The stiffness of the
        fingers' springs grows with the cube, so that the grip force grows with the weights.

        Raises:
            ConfigError: (a ValueError) the factor is not positive and finite.
        """
        _check_positive("scale factor", factor)
        x, y, z = self.claws.pad
        claws = replace(
            self.claws,
            length=self.claws.length * factor,
            width=self.claws.width * factor,
            pad=(x * factor, y * factor, z * factor),
            stiffness=self.claws.stiffness * factor**3,
            damping=self.claws.damping * factor**3.5,
        )
        masses = {name: getattr(self, name) * factor**2 for name in _MASSES}
        return replace(self, **masses, claws=claws, servo=servo)

    def with_servo(self, **changes: float) -> Self:
        """The same build with changed servo values."""
        return replace(self, servo=replace(self.servo, **changes))


PROTOTYPE_BUILD: Final = Build()
"""Build of the prototype of Leveziel et al."""
