"""Level of the one-joint thrower: every number of the cell, once, with its unit and its reason.

The paper's upward axis is called y here, as in Miyashita et al.; in the simulated world that axis is z.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, ClassVar, Final, Literal, Self, final

import numpy as np
from pydantic import Field, model_validator

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.config import Finite, LevelConfig, NonNegative, Positive, Range, Section, check_ranges
from pnt_gym.cells.base.merging import MergeRules
from pnt_gym.planning.one_joint.parameters import Arm, Block

Task = Literal["throw", "sort", "assembly"]
Release = Literal["ideal", "contact"]

LOWEST_GOAL: Final = -0.45
"""Lowest goal; below is only the space of the pallets [m]."""
MOST_TURN: Final = 900.0
"""Largest angle that the planner searches: two whole turns either way on top of half a turn [deg]."""


class ArmSection(Section):
    """The arm as the planner knows it (Miyashita et al., section 6, where not noted)."""

    length: Positive = Field(default=Arm.length, description="Whole plate, mounted at its middle [m].")
    width: Positive = Field(default=Arm.width, description="Across the plane [m].")
    thickness: Positive = Field(default=Arm.thickness, description="Not published; a common sheet [m].")
    density: Positive = Field(default=Arm.density, description="Aluminium [kg/m3].")
    actuator_inertia: NonNegative = Field(
        default=Arm.actuator_inertia, description="At the output, manufacturer's table [kg m2]."
    )
    friction: NonNegative = Field(default=Arm.friction, description="Coulomb friction that is compensated [N m].")
    torque: Positive = Field(default=Arm.torque, description="Largest motor torque [N m].")
    speed: Positive = Field(default=Arm.speed, description="Largest angular speed [rad/s].")
    knee: Annotated[float, Field(gt=0, lt=1)] = Field(
        default=Arm.knee, description="Share of the speed up to which the whole torque is there (Eq. 10)."
    )
    torque_at_speed: Positive = Field(default=Arm.torque_at_speed, description="Torque left at full speed [N m].")
    angle_deg: Range = Field(default=(-90.0, 90.0), description="theta_min, theta_max (section 3.1.2) [deg].")
    time_step: Positive = Field(default=Arm.time_step, description="Longest spacing of the spline's knots [s].")

    @model_validator(mode="after")
    def _check(self) -> Self:
        if not self.angle_deg[0] < self.angle_deg[1]:
            raise ValueError(f"arm.angle_deg runs from {self.angle_deg[0]} to {self.angle_deg[1]}; the range is empty")
        return self

    def arm(self) -> Arm:
        """The planner's arm."""
        values = self.model_dump(exclude={"angle_deg"})
        low, high = np.deg2rad(self.angle_deg)
        return Arm(**values, angle=(float(low), float(high)))


class BlockSection(Section):
    """The block of the tasks `throw` and `sort` (section 6)."""

    mass: Positive = Field(default=Block.mass, description="Mass of the block [kg].")
    half_length: Positive = Field(default=Block.half_length, description="Half the length of the block, l_A = l_B [m].")
    half_height: Positive = Field(default=Block.half_height, description="Half the height of the block, d [m].")
    depth: Positive = Field(default=Block.depth, description="Extent of the block across the plane of the throw [m].")


class Servo(Section):
    """The joint's PD controller; the gains are not published."""

    kp: Positive = Field(default=2000.0, description="Position gain [N m/rad]; about 23 Hz with the arm's inertia.")
    kv: NonNegative = Field(default=20.0, description="Speed gain [N m s/rad]; a damping ratio of 0.7.")


class Errors(Section):
    """Effects that the planner does not know, at m = 1; every value is scaled by the mismatch m. All assumed."""

    radius: Finite = Field(default=0.003, description="Distance by which the object lies too far out [m].")
    inertia: Annotated[float, Field(gt=-0.3, le=1)] = Field(
        default=0.10, description="Share by which the inertia of plate and actuator is larger than planned."
    )
    friction: NonNegative = Field(default=0.6, description="Coulomb friction of the gear [N m].")
    viscous: NonNegative = Field(default=0.02, description="Viscous friction of the gear [N m s/rad].")
    drag: NonNegative = Field(default=1.05, description="Drag coefficient of the object, that of a cube.")
    delay: Annotated[float, Field(ge=0, le=0.05)] = Field(
        default=0.005,
        description="Time from the beginning of the arm's braking until the object comes free; for the release "
        "`ideal` only [s].",
    )
    placement: NonNegative = Field(
        default=0.0002, description="Standard deviation of the object's radius from throw to throw [m]."
    )
    timing: Annotated[float, Field(ge=0, le=0.01)] = Field(
        default=0.0001,
        description="Standard deviation of the release time from throw to throw; for the release `ideal` only [s].",
    )


class Camera(Section):
    """Frames of the flying object, from which the flight is estimated (section 6)."""

    rate: Annotated[float, Field(ge=50, le=10000)] = Field(default=1000.0, description="Frames per second.")
    frames: Annotated[int, Field(ge=8, le=5000)] = Field(
        default=400, description="Largest number of frames of a throw."
    )
    position: NonNegative = Field(
        default=0.0003, description="Standard deviation of the measured x and y at m = 1; scales with the mismatch [m]."
    )
    angle_deg: NonNegative = Field(
        default=0.17, description="Standard deviation of the measured angle at m = 1; scales with the mismatch [deg]."
    )


def _check_goal(label: str, y: float, phi: float) -> None:
    if y < LOWEST_GOAL:
        raise ValueError(f"{label}: y is {y} m; it lies below the pallets, y must be at least {LOWEST_GOAL} m")
    if abs(phi) > MOST_TURN:
        raise ValueError(f"{label}: phi_deg is {phi}; the planner reaches -{MOST_TURN:g} to {MOST_TURN:g} deg")


class Goal(Section):
    """State that a throw passes: z_d of the paper."""

    name: str = Field(default="goal", min_length=1, description="Name of the goal.")
    x: Finite = Field(description="Horizontal position from the pivot [m].")
    y: Finite = Field(description="Height above the pivot [m].")
    phi_deg: Finite = Field(description="Angle of the block, not wrapped: 510 is not 150 [deg].")
    dy: Finite = Field(description="Vertical speed, up positive [m/s].")

    @model_validator(mode="after")
    def _check(self) -> Self:
        _check_goal(f"goal {self.name!r}", self.y, self.phi_deg)
        return self

    def state(self) -> Floats:
        """x, y [m], phi [rad], dy [m/s] (4,)."""
        return np.array([self.x, self.y, np.deg2rad(self.phi_deg), self.dy])


class GoalRegion(Section):
    """Box from which the goal of every throw is drawn, until one is in reach and out of the arm's sweep."""

    x: Range = Field(default=(-0.40, 0.10), description="Range of the horizontal position from the pivot [m].")
    y: Range = Field(default=(0.15, 0.45), description="Range of the height above the pivot [m].")
    phi_deg: Range = Field(default=(100.0, 200.0), description="Range of the block's angle [deg].")
    dy: Range = Field(default=(-1.5, 0.0), description="Range of the vertical speed [m/s].")
    reserve: Annotated[float, Field(ge=0, le=0.05)] = Field(
        default=0.010,
        description="Largest delay of the release for which the arm must be able to make up at a goal [s].",
    )

    @model_validator(mode="after")
    def _check(self) -> Self:
        check_ranges(self, "goals.region", "x", "y", "phi_deg", "dy")
        for y, phi in zip(self.y, self.phi_deg, strict=True):
            _check_goal("goals.region", y, phi)
        return self

    def bounds(self) -> tuple[Floats, Floats]:
        """Lower and upper corner (4,) in x, y [m], phi [rad], dy [m/s]."""
        rows = np.array([self.x, self.y, np.deg2rad(self.phi_deg), self.dy])
        return rows[:, 0], rows[:, 1]


class Goals(Section):
    """Goals of the task `throw`: a list or a region. The goals of the other tasks are their pallets.

    Without a list or a region the default region is used; with the release `contact`, which does not reach that region,
    the list `PUSHED`.
    """

    fixed: tuple[Goal, ...] = Field(
        default=(), description="Goals by name, of which each throw draws one; exclusive with `region`."
    )
    region: GoalRegion | None = Field(
        default=None, description="Box from which the goal of each throw is drawn; exclusive with `fixed`."
    )

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.fixed and self.region is not None:
            raise ValueError("goals has a list `fixed` and a section `region`; give one of them")
        return self


class Tolerance(Section):
    """Distance from the goal within which a throw is a success."""

    position: Positive = Field(default=0.005, description="Largest distance from the goal of a success [m].")
    angle_deg: Positive = Field(default=2.0, description="Largest error of the angle of a success [deg].")
    speed: Positive = Field(default=0.05, description="Largest error of the vertical speed of a success [m/s].")


class Scale(Section):
    """T of the Appendix: scales that make metres, radians and metres per second comparable; not published."""

    position: Positive = Field(
        default=1.0,
        le=1e6,
        description="Weight of an error of the position in the distance of a state from its goal [1/m].",
    )
    angle: NonNegative = Field(default=0.1, le=1e6, description="Weight of an error of the angle [1/rad].")
    speed: NonNegative = Field(default=0.1, le=1e6, description="Weight of an error of the vertical speed [s/m].")

    def weights(self) -> Floats:
        """The diagonal of T (4,)."""
        return np.array([self.position, self.position, self.angle, self.speed])


class Action(Section):
    """Correction of the throw for an action of 1."""

    position: Positive = Field(
        default=0.20, description="Shift of the virtual goal along x and up, for an action of 1 [m]."
    )
    angle_deg: Positive = Field(default=60.0, description="Turn of the virtual goal, for an action of 1 [deg].")
    speed: Positive = Field(
        default=0.8, description="Change of the virtual goal's vertical speed, for an action of 1 [m/s]."
    )
    release_angle_deg: Positive = Field(
        default=10.0, description="Change of the arm's angle at the release, for an action of 1 [deg]."
    )
    release_speed: Positive = Field(
        default=3.0, description="Change of the arm's speed at the release, for an action of 1 [rad/s]."
    )
    release_radius: Positive = Field(default=0.03, description="Change of the object's radius, for an action of 1 [m].")

    def goal_scale(self) -> Floats:
        """Offset of x, y [m], phi [rad] and dy [m/s] for an action of 1 (4,)."""
        return np.array([self.position, self.position, np.deg2rad(self.angle_deg), self.speed])

    def release_scale(self) -> Floats:
        """Offset of theta_t [rad], dtheta_t [rad/s] and l_t [m] for an action of 1 (3,)."""
        return np.array([np.deg2rad(self.release_angle_deg), self.release_speed, self.release_radius])


class Reward(Section):
    """Weights and scales of the reward's terms, each in [0, 1] before weighting, from the true flight."""

    position: NonNegative = Field(default=1.0, description="Weight of max(0, 1 - landing error / position_scale).")
    angle: NonNegative = Field(default=0.3, description="Weight of max(0, 1 - |angle error| / angle_scale_deg).")
    speed: NonNegative = Field(default=0.2, description="Weight of max(0, 1 - |speed error| / speed_scale).")
    success: NonNegative = Field(default=0.5, description="Weight of the success.")
    position_scale: Positive = Field(
        default=0.10, description="Landing error at which the position term reaches 0 [m]."
    )
    angle_scale_deg: Positive = Field(
        default=30.0, description="Error of the angle at which the angle term reaches 0 [deg]."
    )
    speed_scale: Positive = Field(
        default=0.40, description="Error of the vertical speed at which the speed term reaches 0 [m/s]."
    )


@final
class OneJointConfig(LevelConfig):
    """Level of a one-joint cell. The defaults are the level `nominal` of the task `throw`."""

    folder: ClassVar[str | Path] = "one_joint"
    rules: ClassVar[MergeRules] = MergeRules(alternatives={"goals": ("fixed", "region")})

    task: Task = Field(
        default="throw",
        description="throw: a block passes a state. sort: a block lands in one of three pallets. assembly: two "
        "parts join.",
    )
    release: Release = Field(
        default="ideal",
        description="ideal: the object is held rigidly and let go at once. contact: the object lies between two "
        "stoppers, which push the object while it leaves; `delay` and `timing` then have no meaning.",
    )
    timestep: Annotated[float, Field(ge=0.0001, le=0.002)] = Field(
        default=0.001, description="Physics step [s]; 1 ms places the flight to 0.2 mm, 2 ms to 0.7 mm."
    )
    arm: ArmSection = ArmSection()
    block: BlockSection = BlockSection()
    servo: Servo = Servo()
    errors: Errors = Errors()
    camera: Camera = Camera()
    goals: Goals = Goals()
    tolerance: Tolerance = Tolerance()
    scale: Scale = Scale()
    action: Action = Action()
    reward: Reward = Reward()

    @model_validator(mode="after")
    def _check(self) -> Self:
        half = self.arm.length / 2
        if self.block.half_length >= half:
            raise ValueError(
                f"block.half_length is {self.block.half_length} m; it must be shorter than half the arm, {half} m"
            )
        names = [g.name for g in self.goals.fixed]
        if len(set(names)) != len(names):
            raise ValueError(f"goals.fixed names {names} must differ from one another")
        if self.mismatch * self.errors.inertia <= -0.9:
            raise ValueError(
                f"errors.inertia {self.errors.inertia} at mismatch {self.mismatch} leaves the arm no inertia"
            )
        return self
