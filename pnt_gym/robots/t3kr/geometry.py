"""Dimensions, masses and motors of the T3KR-class robot, each with its unit and reason.

The robot (four arms, parallelogram forearms, 530 N m motors) is the robot of Hassan et al. 2022, who publish
neither its lengths nor its masses, and of its workspace that it is an ellipse in top view. The numbers here are
ours: the size of the ellipse, and the lengths from a search for a mechanism that reaches the ellipse. The numbers
agree in size with the published torque rating, which is no proof: 5 kg at 12 g along the belt needs 340 to 660 N m
by direction and place.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Self, final

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator

from pnt_gym.arrays import Floats
from pnt_gym.constants import GRAVITY
from pnt_gym.errors import PlanningError
from pnt_gym.rows import Row, Rows, field

N_ARMS = 4

# Arm i stands in quadrant i, counter-clockwise from (+x, +y).
_SIDE_X = np.array([1.0, -1.0, -1.0, 1.0])
_SIDE_Y = np.array([1.0, 1.0, -1.0, -1.0])

Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
Finite = Annotated[float, Field(allow_inf_nan=False)]
Acute = Annotated[float, Field(ge=0.0, le=np.pi / 2, allow_inf_nan=False)]


class ArmFrame(Row):
    """An arm's azimuth, and its vector from pivot to platform joint at a TCP in the origin."""

    cos: float = field("-", "cosine of the azimuth")
    sin: float = field("-", "sine of the azimuth")
    offset_x: float = field("m", "the vector along the azimuth")
    offset_y: float = field("m", "the vector across the azimuth")


class Mechanism(Row):
    """Constants of pose and dynamics, with L the length of an arm and l that of a rod."""

    offset_z: float = field("m", "height of the platform joints above the pivots at a TCP in the origin")
    length: float = field("m", "L")
    squares: float = field("m2", "L^2 - l^2")
    half: float = field("1/m", "0.5 / L")
    inertia: float = field("kg m2", "inertia of an arm on its motor")
    weight: float = field("N m", "torque of an arm's weight, outstretched")
    coupling: float = field("kg m", "the rods' coupling of elbow and platform")
    moved: float = field("kg", "mass that the platform moves")
    carried: float = field("kg", "mass that the platform carries")


@final
@dataclass(frozen=True)
class ArmFrames:
    """Constants of the four arm planes; the (4, 1) arrays broadcast against M poses.

    Arm frame i has its origin on the motor axis, x outward in the arm's vertical plane, y along the motor
    axis and z up.
    """

    azimuth: Floats
    """(4,) angle of each arm plane from the world's x axis, rad."""
    cos: Floats
    """(4, 1) cosine of the azimuth."""
    sin: Floats
    """(4, 1) sine of the azimuth."""
    pivot: Floats
    """(4, 3) motor axis centres in the world, m."""
    attach: Floats
    """(4, 3) forearm joints on the platform, relative to the TCP, m."""
    offset_x: Floats
    """(4, 1) x of attach - pivot in the arm frame, m."""
    offset_y: Floats
    """(4, 1) y of attach - pivot in the arm frame, m."""
    offset_z: float
    """z of attach - pivot, the same for all arms, m."""
    motor_axis: Floats
    """(4, 3) unit vectors along the motor axes."""

    @cached_property
    def rows(self) -> Rows[ArmFrame]:
        """Frames of the arms (4,)."""
        columns = {name: getattr(self, name)[:, 0] for name in ArmFrame.fields}
        return ArmFrame.zeros(N_ARMS, **columns)


@final
class T3krGeometry(BaseModel):
    """Lengths, masses, motors and workspace of the robot. Lengths in m, masses in kg, angles in rad.

    Raises:
        pydantic.ValidationError: (a ValueError) a value is not finite or not positive, or links cannot close.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    arm_length: Positive = 0.75
    """Motor axis to elbow. Arms shorter than 0.70 m cannot cover the ellipse for z from -0.9 to 0."""
    rod_length: Positive = 1.05
    """Elbow to platform joint."""
    pivot_x: Positive = 0.30
    """Motor axes stand at (+-pivot_x, +-pivot_y, pivot_z)."""
    pivot_y: Positive = 0.15
    pivot_z: Finite = 0.55
    """Height of the motor axes, above z = 0, the top of the workspace."""
    arm_azimuth: Acute = float(np.deg2rad(75.0))
    """Arm planes at +-75 and 180 +- 75 degrees: the arms swing mostly along y, the workspace's long axis."""
    attach_radius: Positive = 0.10
    """Radius of the circle of forearm joints; 0.10 keeps 45 mm between neighbouring ball joints."""
    attach_azimuth: Acute = float(np.deg2rad(45.0))
    attach_height: Positive = 0.10
    """Height of the forearm joints above the TCP, which leaves room for the suction cup."""
    rod_spacing: Positive = 0.10
    """Width of each parallelogram."""

    arm_mass: Positive = 2.0
    arm_com: Positive = 0.30
    """Distance of the arm's centre of mass from the motor axis; the arm tapers, so less than half-way."""
    rod_mass: Positive = 0.25
    """One rod; a forearm has two rods."""
    platform_mass: Positive = 2.0
    """Platform with the suction gripper, without an object."""
    armature: Positive = 0.25
    """Motor and gear inertia at the arm, kg m^2."""

    torque_limit: Positive = 530.0
    """Per motor, N m (Hassan et al. 2022, the robot's published rating)."""
    kp: Positive = 2e4
    """Joint position gain, N m/rad: tracks a 4.8 g throw within 0.2 mm at 0.4 ms steps."""
    kv: Positive = 400.0
    """Joint velocity gain, N m s/rad: kv * step / inertia stays below 0.5 up to 1 ms, so Euler is safe."""

    workspace_x: Positive = 0.45
    """Semi-axis of the elliptical workspace along x, ours: it holds the paper's picks and inside target."""
    workspace_y: Positive = 0.80
    """Semi-axis along y, ours: it holds the paper's P_initial."""
    z_min: Finite = -0.95
    """Below the belt (-0.85) so that the cup can press on low objects."""
    z_max: Finite = 0.0

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.z_min >= self.z_max:
            raise PlanningError(f"z_min = {self.z_min} m must be below z_max = {self.z_max} m")
        if self.arm_com > self.arm_length:
            raise PlanningError(f"arm_com = {self.arm_com} m must lie on the arm of {self.arm_length} m")
        drop = self.pivot_z - self.z_min - self.attach_height
        if drop >= self.arm_length + self.rod_length:
            raise PlanningError(
                f"arm_length + rod_length = {self.arm_length + self.rod_length} m must exceed the {drop} m "
                "from the base down to the lowest platform"
            )
        return self

    @cached_property
    def arm_inertia(self) -> float:
        """Inertia of one arm about its own centre of mass, kg m^2: a uniform bar of the same length."""
        return self.arm_mass * self.arm_length**2 / 12.0

    @cached_property
    def arms(self) -> ArmFrames:
        """Constants of the four arm planes."""
        azimuth = np.arctan2(_SIDE_Y * np.sin(self.arm_azimuth), _SIDE_X * np.cos(self.arm_azimuth))
        height = np.ones(N_ARMS)
        pivot = np.stack([_SIDE_X * self.pivot_x, _SIDE_Y * self.pivot_y, height * self.pivot_z], axis=1)
        reach_x = self.attach_radius * np.cos(self.attach_azimuth)
        reach_y = self.attach_radius * np.sin(self.attach_azimuth)
        attach = np.stack([_SIDE_X * reach_x, _SIDE_Y * reach_y, height * self.attach_height], axis=1)
        cos, sin = np.cos(azimuth), np.sin(azimuth)
        x, y, z = (attach - pivot).T
        return ArmFrames(
            azimuth=azimuth,
            cos=cos[:, None],
            sin=sin[:, None],
            pivot=pivot,
            attach=attach,
            offset_x=(cos * x + sin * y)[:, None],
            offset_y=(cos * y - sin * x)[:, None],
            offset_z=float(z[0]),
            motor_axis=np.stack([-sin, cos, 0.0 * height], axis=1),
        )

    @cached_property
    def mechanism(self) -> Rows[Mechanism]:
        """Constants of pose and dynamics (1,)."""
        # Thin rods: each end has a third of their inertia and half their weight, and a sixth couples the ends.
        length, rods = self.arm_length, 2.0 * self.rod_mass
        moved, carried = (self.platform_mass + N_ARMS * rods / part for part in (3.0, 2.0))
        return Mechanism.zeros(
            1,
            offset_z=self.arms.offset_z,
            length=length,
            squares=length**2 - self.rod_length**2,
            half=0.5 / length,
            inertia=self.armature + (self.arm_inertia + self.arm_mass * self.arm_com**2) + rods * length**2 / 3.0,
            weight=GRAVITY * (self.arm_mass * self.arm_com + rods * length / 2.0),
            coupling=rods * length / 6.0,
            moved=moved,
            carried=carried,
        )


T3KR = T3krGeometry()
"""The default robot."""
