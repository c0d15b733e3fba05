"""The sections of a cell's config: every number of belt, bins, motion, suction and sensors, with unit and reason."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
NonNegative = Annotated[float, Field(ge=0, allow_inf_nan=False)]
Finite = Annotated[float, Field(allow_inf_nan=False)]
Range = tuple[Finite, Finite]


class Section(BaseModel):
    """Base of the sections: frozen, and an unknown key is an error."""

    model_config = ConfigDict(frozen=True, extra="forbid")


def _ordered(name: str, bounds: Range) -> None:
    if bounds[0] > bounds[1]:
        raise ValueError(f"{name} runs from {bounds[0]} to {bounds[1]}; the first value must not exceed the second")


class Limits(Section):
    """Cartesian limits of the hand. With `percent`, each throw draws one speed setting."""

    percent: tuple[Annotated[float, Field(gt=0, le=100)], ...] = Field(
        default=(40.0,),
        min_length=1,
        description="Shares of V 6 m/s, A 120 m/s2, J 3000 m/s3 (Hassan 2022, IV-B), in percent.",
    )


class Belt(Section):
    """The conveyor: a surface that moves along +x, and the stream of objects on it."""

    height: Finite = Field(
        default=-0.90, description="z of the surface [m]; a 50 mm object is then picked at the paper's -0.85."
    )
    speed: Positive = Field(default=0.25, description="Surface speed along +x [m/s].")
    x: Range = Field(default=(-1.4, 0.8), description="Extent along x [m].")
    y: Range = Field(default=(-0.55, -0.08), description="Extent along y [m].")
    pick_x: Range = Field(default=(-0.30, 0.30), description="Window in which an object may be picked, along x [m].")
    lane_y: Range = Field(default=(-0.45, -0.20), description="Where objects lie across the belt [m].")
    spacing: Range = Field(default=(0.10, 0.30), description="Gap between consecutive objects along x, uniform [m].")
    camera_x: Finite = Field(
        default=-0.80, description="Where the camera sees an object; a belt-speed error grows from here [m]."
    )

    @model_validator(mode="after")
    def _check(self) -> Self:
        for name in ("x", "y", "pick_x", "lane_y", "spacing"):
            _ordered(f"belt.{name}", getattr(self, name))
        if self.spacing[0] <= 0:
            raise ValueError(f"belt.spacing starts at {self.spacing[0]}; gaps must be greater than 0 m")
        if not (self.x[0] <= self.pick_x[0] and self.pick_x[1] <= self.x[1]):
            raise ValueError(f"belt.pick_x {self.pick_x} leaves the belt, which spans x {self.x}")
        if not (self.y[0] <= self.lane_y[0] and self.lane_y[1] <= self.y[1]):
            raise ValueError(f"belt.lane_y {self.lane_y} leaves the belt, which spans y {self.y}")
        return self


class Bin(Section):
    """One fixed bin: the centre of its opening and the inner size of the opening."""

    name: str = Field(min_length=1)
    x: Finite
    y: Finite
    size: tuple[Positive, Positive] = Field(default=(0.22, 0.22), description="Inner opening along x and y [m].")
    accepts: tuple[str, ...] = Field(default=(), description="Items sorted here; empty: any item may be sent here.")


class RandomBins(Section):
    """One square bin per throw, drawn anew: a cell with very many bins."""

    x: Range = (-0.50, 0.50)
    y: Range = (0.25, 0.75)
    side: Range = Field(default=(0.12, 0.14), description="Inner side of the opening, uniform [m].")
    item_clearance: NonNegative = Field(
        default=0.0,
        description="The opening is at least the item's longest side plus this [m]; 0 switches the rule off.",
    )

    @model_validator(mode="after")
    def _check(self) -> Self:
        for name in ("x", "y", "side"):
            _ordered(f"bins.random.{name}", getattr(self, name))
        if self.side[0] <= 0:
            raise ValueError(f"bins.random.side starts at {self.side[0]}; an opening must be wider than 0 m")
        return self


class Bins(Section):
    """The bins: a fixed list, or one random bin per throw."""

    fixed: tuple[Bin, ...] = ()
    random: RandomBins | None = None
    rim: Finite = Field(default=-0.85, description="z of the rim plane, where landing is measured [m].")
    depth: Positive = Field(default=0.30, description="Inner depth below the rim [m].")
    wall: Annotated[float, Field(ge=0.004, le=0.1)] = Field(
        default=0.010, description="Wall thickness [m]; thinner than 4 mm lets fast objects through."
    )

    @model_validator(mode="after")
    def _check(self) -> Self:
        if bool(self.fixed) == (self.random is not None):
            raise ValueError("bins needs either a list `fixed` or a section `random`, and not both")
        names = [b.name for b in self.fixed]
        if len(set(names)) != len(names):
            raise ValueError(f"bins.fixed names {names} must differ from one another")
        return self


class FollowThrough(Section):
    """What the hand does after the release: it buys success with cycle time."""

    window: NonNegative = Field(
        default=0.080,
        description="Constant velocity after the release [s]; at 80 ms few objects are touched again.",
    )
    gravity_share: Annotated[float, Field(gt=0, le=1)] | None = Field(
        default=None,
        description="Braking is slowed until the hand falls with at most this share of g; null: full braking. "
        "For straight throws; a free direction plans its motion by the next three.",
    )
    hand_cap: NonNegative = Field(
        default=0.15, description="Free direction: how far the hand may rise above the release ceiling [m]."
    )
    clear_distance: NonNegative = Field(
        default=0.12, description="Free direction: the hand stays above the object until this far away sideways [m]."
    )
    margin: Annotated[float, Field(ge=0, lt=1)] = Field(
        default=0.3, description="Free direction: by this share of g t^2 / 2 at least, t since the release."
    )


class Motion(Section):
    """One pick from lift to lift."""

    ceiling: Positive = Field(
        default=0.10, description="Release at most this far above the pick (Hassan 2022, IV-B) [m]."
    )
    clearance: Positive = Field(default=0.05, description="Vertical approach above the next pick, Z_off [m].")
    dwell: NonNegative = Field(
        default=0.10, description="Standstill while the vacuum builds up; counted, not simulated [s]."
    )
    follow_through: FollowThrough = FollowThrough()
    ceiling_slack: NonNegative = Field(
        default=0.03, description="A residual may exceed the release ceiling by this [m]."
    )
    reserve: NonNegative = Field(
        default=0.10,
        description="A throw is taken on only if the target moved by +- this along is feasible too [m].",
    )


class Suction(Section):
    """Release happens late: valve delay + decay of the vacuum + jitter.

    delay = valve + tau_e ln(F0 / (m g)), tau_e = tau / (1 + leak (F_ref / F0 - 1)) for F0 below F_ref: a porous
    seal vents through its leak as well.
    """

    valve: NonNegative = Field(default=0.004, description="Valve delay, assumed [s].")
    tau: NonNegative = Field(default=0.009, description="Time constant of the vacuum, tight seal, assumed [s].")
    leak: NonNegative = Field(default=0.25, description="Strength of the leak's effect on tau, assumed.")
    leak_reference: Positive = Field(default=20.0, description="Seal force above which nothing leaks [N].")
    jitter: NonNegative = Field(default=0.001, description="Standard deviation of the release time [s].")


class Spread(Section):
    """How much throws of one item differ (hidden values; assumed unless noted)."""

    mass: NonNegative = Field(default=0.22, description="Lognormal.")
    size: NonNegative = Field(default=0.08, description="Lognormal, common to the three axes.")
    size_axis: NonNegative = Field(default=0.04, description="Lognormal, per axis.")
    drag: NonNegative = Field(default=0.12, description="Lognormal.")
    seal: NonNegative = Field(default=0.40, description="Lognormal, seal quality.")
    com_depth: NonNegative = Field(default=0.06, description="Normal, share of the height.")
    grasp: NonNegative = Field(default=0.008, description="Normal per axis, cup against centre of mass [m].")
    height: NonNegative = Field(default=0.002, description="Normal, lip compression and height error [m].")
    belt_speed: NonNegative = Field(default=0.005, description="Normal, relative error of the belt speed.")
    spin: NonNegative = Field(
        default=1.0, description="Normal about x and y at release [rad/s]; a third of it about z."
    )
    spin_per_offset: NonNegative = Field(default=30.0, description="Spin per metre of grasp offset [rad/s/m].")
    feedforward: NonNegative = Field(default=0.10, description="Torque feed-forward too small by this share.")
    yaw: NonNegative = Field(default=1.5707963267948966, description="Half range of the yaw on the belt [rad].")
    residue_chance: Annotated[float, Field(ge=0, le=1)] = Field(
        default=0.4, description="Containers that are not empty."
    )
    residue: NonNegative = Field(default=1.5, description="Most residue, in item masses.")


class Noise(Section):
    """What the cell's sensors add to a measured value (one standard deviation)."""

    size: NonNegative = Field(default=0.003, description="Camera outline and height [m].")
    mass: NonNegative = Field(default=0.10, description="Relative.")
    seal: NonNegative = Field(default=0.10, description="Vacuum sensor, relative.")
    yaw: NonNegative = Field(default=0.05, description="[rad]")
    grasp: NonNegative = Field(default=0.004, description="Camera outline against cup position [m].")


class ActionScale(Section):
    """What an action of 1 means in each action mode."""

    along: Positive = Field(default=0.20, description="Drag-free landing shift along the throw [m].")
    across: Positive = Field(default=0.06, description="Drag-free landing shift across the throw [m].")
    xyz: tuple[Positive, Positive, Positive] = Field(
        default=(0.12, 0.02, 0.015), description="Raw shift of the release point along, sideways, up [m]."
    )


class Reward(Section):
    """Weights of the reward terms; each term lies in [0, 1]."""

    landing: NonNegative = Field(default=1.0, description="1 - landing error / landing_scale, not below 0.")
    sorted: NonNegative = Field(default=0.1, description="1 if the object lies in its bin.")
    time: NonNegative = Field(default=0.1, description="1 - cycle time / time_scale, not below 0.")
    landing_scale: Positive = Field(default=0.25, description="Landing error at which the landing term reaches 0 [m].")
    time_scale: Positive = Field(default=3.0, description="Cycle time at which the time term reaches 0 [s].")
