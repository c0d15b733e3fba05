"""Parameters of the one-joint thrower and its block (Miyashita et al., section 6).

The vertical plane is x to the right and y up, the pivot is the origin, angles count anticlockwise from the
horizontal arm. The object lies on the arm's upper surface, which passes through the pivot.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from pnt_gym.arrays import number, numbers, of_kind
from pnt_gym.errors import PlanningError


@final
@dataclass(frozen=True)
class Block:
    """A box that lies on the arm with its longer side.

    Raises:
        ValueError: a mass or a length is not positive and finite.
    """

    mass: float = 0.029
    """Mass of the wooden block [kg] (section 6)."""
    half_length: float = 0.030
    """l_A = l_B: from the centre of mass to the vertices A (outer) and B (inner) along the arm [m]."""
    half_height: float = 0.015
    """d: height of the centre of mass above the arm's surface [m]."""
    depth: float = 0.030
    """Size across the plane of the throw [m]."""

    def __post_init__(self) -> None:
        for name in ("mass", "half_length", "depth"):
            _check_positive(f"block {name}", getattr(self, name))
        if not 0.0 <= number(self.half_height, "block half_height") < np.inf:
            raise PlanningError(f"block half_height is {self.half_height}; it must be at least 0")

    @property
    def inertia(self) -> float:
        """J of a homogeneous box about the axis through its centre of mass across the plane [kg m2]."""
        return self.mass * (self.half_length**2 + self.half_height**2) / 3.0


@final
@dataclass(frozen=True)
class Arm:
    """A plate mounted at its middle on the shaft of an actuator, with the limits of plate and actuator.

    Raises:
        ValueError: a size, mass or limit is not positive and finite, or the range of angles is empty.
    """

    length: float = 0.62
    """Length of the whole plate, mounted at its middle [m] (section 6)."""
    width: float = 0.15
    """Width of the plate, across the plane of the throw [m] (section 6)."""
    thickness: float = 0.005
    """Not published; the thickness of a common sheet [m]."""
    density: float = 2700.0
    """Aluminium [kg/m3]."""
    actuator_inertia: float = 0.050
    """FHA-14C-50 with incremental encoder, at the output (manufacturer's table) [kg m2]."""
    friction: float = 0.0
    """Coulomb friction in the planner's model [N m]."""
    torque: float = 18.0
    """tau_max (section 6) [N m]."""
    speed: float = 4.0 * np.pi
    """Largest angular speed (section 6) [rad/s]."""
    knee: float = 0.8
    """Share of `speed` up to which the whole torque is available; linear to `torque_at_speed` beyond (Eq. 10)."""
    torque_at_speed: float = 9.0
    """Torque left at `speed` [N m]."""
    angle: tuple[float, float] = (-np.pi / 2.0, np.pi / 2.0)
    """theta_min, theta_max (section 3.1.2) [rad]."""
    time_step: float = 0.06
    """Delta t_max, the longest spacing of the spline's knots; not published [s]."""

    def __post_init__(self) -> None:
        for name in ("length", "width", "thickness", "density", "torque", "speed", "torque_at_speed", "time_step"):
            _check_positive(f"arm {name}", getattr(self, name))
        for name in ("actuator_inertia", "friction"):
            value = getattr(self, name)
            if not 0.0 <= number(value, f"arm {name}") < np.inf:
                raise PlanningError(f"arm {name} is {value}; it must be at least 0")
        if not 0.0 < number(self.knee, "arm knee") < 1.0:
            raise PlanningError(f"arm knee is {self.knee}; it must lie between 0 and 1")
        angle = numbers(self.angle, "arm angle")
        if angle.shape != (2,) or not angle[0] < angle[1]:
            raise PlanningError(f"arm angle is {self.angle}; it must be two rising angles [rad]")

    @property
    def inertia(self) -> float:
        """J_R of plate and actuator about the pivot [kg m2]."""
        mass = self.density * self.length * self.width * self.thickness
        return mass * (self.length**2 + self.thickness**2) / 12.0 + self.actuator_inertia

    def largest_radius(self, block: Block) -> float:
        """Largest r at which the block's whole edge is on the arm [m]."""
        return 0.5 * self.length - block.half_length


def arm_and_block(arm: Arm | None, block: Block | None) -> tuple[Arm, Block]:
    """Return the given arm and block, and the paper's for None.

    Raises:
        ValueError: one of them is something else.
    """
    arm, block = Arm() if arm is None else arm, Block() if block is None else block
    return of_kind(arm, Arm, "arm"), of_kind(block, Block, "block")


def _check_positive(name: str, value: float) -> None:
    if not 0.0 < number(value, name) < np.inf:
        raise PlanningError(f"{name} is {value}; it must be positive and finite")
