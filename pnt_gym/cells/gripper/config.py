"""Level of the gripper robot: every number of the cell, once, with its unit and its reason.

The world's z = 0 is the plane of the robot's motor axes, as in Leveziel et al. The lengths here do not scale with the
robot: a level for a robot of another size sets its own.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self, cast, final

import numpy as np
from pydantic import Field, ValidationError, model_validator

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.catalogue import CLAW_ITEMS, ItemsConfig
from pnt_gym.cells.base.config import Duration, Finite, NonNegative, Positive, Range, Section, Share, check_ranges
from pnt_gym.cells.base.sorting import SortingReward
from pnt_gym.cells.gripper.conveyor import Conveyor, ConveyorSite
from pnt_gym.cells.gripper.robot import Robot

Task = Literal["toss", "drop"]


class Table(Section):
    """Table or belt on which the objects lie."""

    height: Finite = Field(default=-0.321, description="z of the surface [m].")
    x: Range = Field(default=(-0.110, 0.030), description="Extent along x [m].")
    y: Range = Field(default=(-0.080, 0.080), description="Extent along y [m].")
    pick_x: Range = Field(default=(-0.060, -0.020), description="Range along x in which objects are picked [m].")
    pick_y: Range = Field(default=(-0.030, 0.030), description="Range along y in which objects are picked [m].")
    speed: NonNegative = Field(
        default=0.0,
        description="Speed of the surface, for a belt [m/s]; the claws then begin to close in `pick_x` and `pick_y`.",
    )
    travel_deg: Finite = Field(default=0.0, description="Direction in which the belt moves, from the x axis [deg].")
    camera: Finite = Field(
        default=0.0,
        description="Distance from the origin, along the belt's travel, at which the camera sees objects on the "
        "belt [m].",
    )

    @property
    def travel(self) -> Floats:
        """Unit vector of the belt's travel (3,)."""
        angle = np.deg2rad(self.travel_deg)
        return np.array([np.cos(angle), np.sin(angle), 0.0])

    @model_validator(mode="after")
    def _check(self) -> Self:
        check_ranges(self, "table", "x", "y", "pick_x", "pick_y")
        return self


class Tray(Section):
    """Compartments in a row along y, one for each kind of object, in the order of `items`."""

    x: Finite = Field(default=0.185, description="Middle of the row of compartments along x [m].")
    y: Finite = Field(default=0.0, description="Middle of the row of compartments along y [m].")
    rim: Finite = Field(default=-0.430, description="z of the plane of the rims, in which landings are measured [m].")
    depth: Positive = Field(default=0.050, description="Depth of the compartments below the rim [m].")
    opening: tuple[Positive, Positive] = Field(
        default=(0.052, 0.052), description="Inner opening of a compartment along x and y [m]."
    )
    wall: Annotated[float, Field(ge=0.002, le=0.1)] = Field(default=0.004, description="Thickness of the walls [m].")
    settle: Duration = Field(
        default=0.14,
        gt=0,
        description="Simulated time after the planned landing, in which the object comes to rest [s].",
    )

    def centres(self, count: int) -> Floats:
        """Middle of every compartment's opening (count, 3) [m]."""
        pitch = self.opening[1] + self.wall
        y = self.y + pitch * (np.arange(count) - (count - 1) / 2.0)
        return np.stack([np.full(count, self.x), y, np.full(count, self.rim)], axis=-1)


class Grip(Section):
    """Closing and opening of the claws."""

    open_deg: Finite = Field(default=-35.0, description="Angle of the halves above the object [deg].")
    squeeze_deg: Positive = Field(
        default=7.0,
        description="Angle by which the halves close beyond the first contact with an object of the planned width; "
        "4 N per pad [deg].",
    )
    release_deg: Positive = Field(
        default=10.0, description="Angle by which the halves open beyond that contact at the release [deg]."
    )
    closing: Duration = Field(default=0.070, gt=0, description="Time to close [s].")
    hold: Duration = Field(default=0.030, description="Standstill with closed claws before the lift [s].")
    opening: Duration = Field(
        gt=0,
        default=0.060,
        description="Time to open; the prototype moves its halves by 15 deg in 60 ms (section VI-B) [s].",
    )
    clearance: Positive = Field(default=0.002, description="Height of the pads' lower edge above the table [m].")


class Motion(Section):
    """Motion from the grip to the end of the toss."""

    height: Finite = Field(default=-0.200, description="z of the platform at the release [m].")
    release_x: tuple[Finite, ...] = Field(
        default=(0.030, 0.045, 0.060, 0.070, 0.080),
        min_length=1,
        description="Release points along x that the planner tries [m].",
    )
    release_y: NonNegative = Field(default=0.6, description="y of the release, as a share of the target's y.")
    elevation_deg: tuple[Finite, ...] = Field(
        default=(0.0, 8.0, 16.0, 24.0),
        min_length=1,
        description="Elevations of the throw that the planner tries [deg].",
    )
    acceleration: Positive = Field(
        default=15.0, description="Largest acceleration on the straight line of the throw [m/s2]."
    )
    move_acceleration: Positive | None = Field(
        default=None,
        description="Largest acceleration on the way from grip to line [m/s2]; null where the speed of the motors "
        "alone bounds it, as for a small robot.",
    )
    before: Duration = Field(default=0.012, description="Time of constant velocity before the release [s].")
    after: Duration = Field(
        default=0.010,
        description="Time of constant velocity after the release [s]; a longer time forgives a late opening and "
        "costs cycle time.",
    )
    speed_share: Share = Field(
        default=0.75,
        description="Share of the largest motor speed that the plan uses; accelerations need the remainder.",
    )
    line_speed_share: Share = Field(
        default=0.85,
        description="Share of the largest motor speed that the plan uses on the straight line of the throw.",
    )
    drop_height: Finite = Field(default=-0.215, description="z of the platform above a compartment at a drop [m].")
    rest: Duration = Field(default=0.040, description="Standstill before the claws open for a drop [s].")


class Errors(Section):
    """Effects that the planner does not know, at m = 1; every value is scaled by the mismatch m. All assumed."""

    width: NonNegative = Field(default=0.02, le=0.5, description="Relative standard deviation of the object's extents.")
    mass: NonNegative = Field(default=0.15, le=1, description="Lognormal spread of the mass.")
    friction: NonNegative = Field(default=0.10, le=1, description="Lognormal spread of the friction.")
    drag: NonNegative = Field(default=0.15, le=1, description="Lognormal spread of the drag coefficient.")
    placement: NonNegative = Field(
        default=0.002, le=0.5, description="Standard deviation of the object's place per axis [m]."
    )
    yaw_deg: NonNegative = Field(default=3.0, description="Standard deviation of the object's direction [deg].")
    delay: NonNegative = Field(default=1.0, le=100, description="Factor of the `opening_delay` of every item.")
    timing: Duration = Field(default=0.002, description="Standard deviation of the delay of the claws' opening [s].")
    feedforward: Annotated[float, Field(ge=0, le=1)] = Field(
        default=0.30, description="Share of the torque that the servos' feed-forward lacks, so that the servos lag."
    )
    camera: NonNegative = Field(
        default=0.0003, description="Standard deviation of each extent that the camera measures [m]."
    )
    belt_speed: NonNegative = Field(default=0.0, le=1, description="Relative standard deviation of the belt's speed.")


class Action(Section):
    """Correction of the throw for an action of 1."""

    along: Positive = Field(
        default=0.030,
        description="Shift of the release point along the throw, for an action of 1; the landing moves as far [m].",
    )
    across: Positive = Field(default=0.015, description="Shift of the release point sideways, for an action of 1 [m].")
    opening: Duration = Field(default=0.050, gt=0, description="Delay of the claws' opening, for an action of 1 [s].")

    def scale(self) -> Floats:
        """Correction for an action of 1 as an array (3,) [m, m, s]."""
        return np.array([self.along, self.across, self.opening])


class Reward(SortingReward):
    """Weights of the reward's terms; a compartment is the bin."""

    success: NonNegative = Field(
        default=0.5, description="Weight of the success: the object crossed its opening and lies in its compartment."
    )
    landing_scale: Positive = Field(default=0.06, description="Landing error at which the landing term reaches 0 [m].")
    time_scale: Positive = Field(default=2.0, description="Cycle time at which the time term reaches 0 [s].")


@final
class GripperConfig(ItemsConfig):
    """Level of a gripper robot's cell. The defaults are the level `nominal` of the task `toss`."""

    folder: ClassVar[str | Path] = "gripper"

    task: Task = Field(
        default="toss",
        description="toss: a release in motion. drop: a release at rest above the tray, as in the paper.",
    )
    timestep: Annotated[float, Field(ge=0.0001, le=0.001)] = Field(default=0.001, description="Physics step [s].")
    robot: Robot = Robot()
    conveyor: Conveyor | None = Field(
        default=None,
        description="A conveyor cell from which this cell takes the values that it does not set; null for none.",
    )
    items: tuple[str, ...] = Field(
        default=CLAW_ITEMS,
        min_length=1,
        description="Names of the items, each with a compartment of the tray; see the catalogue of items.",
    )
    table: Table = Table()
    tray: Tray = Tray()
    grip: Grip = Grip()
    motion: Motion = Motion()
    errors: Errors = Errors()
    action: Action = Action()
    reward: Reward = Reward()
    observation: Mapping[str, tuple[Finite, Positive]] = Field(
        default_factory=dict,
        description="Centre and scale by feature, for features whose usual values do not suit this cell.",
    )

    @model_validator(mode="before")
    @classmethod
    def _read(cls, data: Any) -> Any:
        """Fill in the values of the conveyor cell that this cell does not set."""
        entries = cast("dict[str, Any]", data) if isinstance(data, dict) else {}
        if entries.get("conveyor") is None:
            return cast(Any, data)
        try:
            conveyor = Conveyor.model_validate(entries["conveyor"])
        except ValidationError:
            return entries  # the field's own validation says what is wrong
        site = ConveyorSite.load(conveyor.level)
        full: dict[str, Any] = {"items": site.items, "extra_items": site.extra_items} | entries
        items = cast("list[str]", full["items"]) if isinstance(full["items"], list | tuple) else []  # refused below
        for name, values in conveyor.sections(site, items).items():
            section = entries.get(name, {})
            section = section.model_dump(exclude_unset=True) if isinstance(section, Section) else section
            full[name] = values | cast("dict[str, Any]", section) if isinstance(section, dict) else section
        return full

    @model_validator(mode="after")
    def _check(self) -> Self:
        if len(set(self.items)) != len(self.items):
            raise ValueError(f"items {list(self.items)} must differ from one another; each has a compartment")
        claws = self.robot.parts()[1].claws
        platform = self.motion.height if self.task == "toss" else self.motion.drop_height
        lowest = platform - claws.length - claws.pad[2] / 2.0
        if self.tray.rim >= lowest:
            raise ValueError(
                f"tray.rim is {self.tray.rim} m; it must lie below the claws at the release, "
                f"which end at {lowest:.3f} m"
            )
        # Check that the tray does not stand in the table; lower than the table and beneath it is allowed.
        tray, table = self.tray, self.table
        long, wide = tray.opening[0] + 2.0 * tray.wall, len(self.items) * (tray.opening[1] + tray.wall) + tray.wall
        x, y = (tray.x - long / 2.0, tray.x + long / 2.0), (tray.y - wide / 2.0, tray.y + wide / 2.0)
        if tray.rim > table.height and _overlap(x, table.x) and _overlap(y, table.y):
            raise ValueError(
                f"the tray spans x {x[0]:.3f} to {x[1]:.3f} m and stands in the table, which spans {table.x[0]:.3f} to "
                f"{table.x[1]:.3f} m; move it off"
            )
        return self


def _overlap(first: Range, second: Range) -> bool:
    return first[0] < second[1] and second[0] < first[1]
