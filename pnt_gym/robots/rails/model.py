"""A hand on three rails in a MuJoCo model specification, for robots of which no joints are known.

The hand follows its path as the planner has it: nothing here says how well the joints of the real robot would. The
model serves for contacts of the cup with an object after its release, and for pictures.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, Self, final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats
from pnt_gym.constants import GRAVITY
from pnt_gym.engine import MjSpec
from pnt_gym.palette import MOTOR, PAINT, STEEL
from pnt_gym.robots.brush import Brush
from pnt_gym.robots.joints import JointMotion, MotorLimits, Place
from pnt_gym.robots.specification import add_level_platform, add_motor, add_site, set_inertia

MASS: Final = 5.0
"""Mass of the hand, large beside objects, which then hardly disturb its path [kg]."""
INERTIA: Final = (0.02, 0.02, 0.02)
"""Moments of inertia of the hand, which never turns [kg m2]."""
STIFFNESS: Final = 200.0
"""Natural frequency of the motors' position control, critically damped [rad/s]."""
LARGEST_FORCE: Final = 1e5
"""Largest force of a motor, beyond that of any sheet [N]."""
POST: Final = 0.55
"""Height of the drawn post above the hand [m]."""


@final
@dataclass(frozen=True)
class RailHandles:
    """Names of the elements that `add_rails` added."""

    joints: tuple[str, ...]
    """Slides along x, y and z; each has a motor."""
    actuators: tuple[str, ...]
    """Motors; each motor takes three consecutive controls: position, velocity, feed-forward force."""
    mount: Place = (0.0, 0.0, POST)
    """Upper end of the stand-in, above the workspace [m]."""
    platform: str = "platform"
    """Body whose origin is the hand."""
    tcp: str = "tcp"
    """Site at the hand."""

    @property
    def motor_joints(self) -> tuple[str, ...]:
        """Joints that the motors drive."""
        return self.joints

    @property
    def limits(self) -> MotorLimits:
        """Limits of the motors, which no sheet reaches."""
        return MotorLimits.of_torque(LARGEST_FORCE, len(self.joints))

    def with_prefix(self, prefix: str) -> Self:
        """The names of the elements after the specification is attached to another one with a prefix."""
        lists = {name: tuple(prefix + entry for entry in getattr(self, name)) for name in ("joints", "actuators")}
        return replace(self, platform=prefix + self.platform, tcp=prefix + self.tcp, **lists)

    def pose(self, hand: ArrayLike) -> Floats:
        """Joint positions with the hand at points (N, 3) [m]."""
        return np.array(hand, dtype=np.float64)

    def rates(self, hand: ArrayLike, velocity: ArrayLike) -> Floats:
        """Joint velocities (N, 3) while the hand moves with velocities (N, 3) [m/s]."""
        return np.array(velocity, dtype=np.float64)

    def motion(self, position: Floats, velocity: Floats, acceleration: Floats) -> JointMotion:
        """Positions, velocities and forces of the motors, each (3, ...), for the hand's motion (..., 3)."""
        force = MASS * (acceleration + np.array([0.0, 0.0, GRAVITY]))
        parts = (position, velocity, acceleration, force)
        return JointMotion(*(np.ascontiguousarray(np.moveaxis(part, -1, 0)) for part in parts))


def add_rails(spec: MjSpec) -> RailHandles:
    """Add the hand to a model specification and return the names."""
    body, joints = add_level_platform(spec)
    set_inertia(body, MASS, (0.0, 0.0, 0.0), INERTIA)
    add_site(body, "tcp")
    motors = [f"motor_{number}" for number in range(3)]
    for motor, joint in zip(motors, joints, strict=True):
        add_motor(spec, motor, joint, LARGEST_FORCE, MASS * STIFFNESS**2, 2.0 * MASS * STIFFNESS)
    brush = Brush(body)
    brush.cylinder((0.0, 0.0, 0.05), (0.0, 0.0, 0.07), 0.06, PAINT)
    brush.cylinder((0.0, 0.0, 0.07), (0.0, 0.0, POST), 0.018, STEEL)
    brush.box((0.0, 0.0, POST), (0.05, 0.05, 0.04), MOTOR)
    return RailHandles(tuple(joints), tuple(motors))
