"""Sections of a conveyor's level: limits and motion of the hand, release, grip, cup and picks, classes and actions."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from pnt_gym.cells.base.config import Duration, Finite, NonNegative, Positive, Section


class Limits(Section):
    """Cartesian limits of the hand. With `percent`, each throw draws one speed setting."""

    percent: tuple[Annotated[float, Field(ge=1, le=100)], ...] = Field(
        default=(40.0,),
        min_length=1,
        description="Speed settings in percent of the robot's limits; those of the T3KR are V 6 m/s, A 120 m/s2 and "
        "J 3000 m/s3 (Hassan 2022, IV-B). A throw draws one.",
    )


class FollowThrough(Section):
    """Motion of the hand after the release: a longer follow-through gives more success and a longer cycle."""

    window: Duration = Field(
        default=0.080,
        description="Time of constant velocity after the release [s]; with 80 ms few objects are touched again.",
    )
    gravity_share: Annotated[float, Field(gt=0, le=1)] | None = Field(
        default=None,
        description="Braking is slowed until the hand falls with at most this share of g; null: full braking. For "
        "straight throws; a free direction uses the next three keys.",
    )
    hand_cap: NonNegative = Field(
        default=0.15, description="Free direction: largest height of the hand above the release ceiling [m]."
    )
    clear_distance: NonNegative = Field(
        default=0.12,
        description="Free direction: sideways distance from the object up to which the hand stays above the object "
        "[m].",
    )
    margin: Annotated[float, Field(ge=0, lt=1)] = Field(
        default=0.3,
        description="Free direction: least height of the hand above the object, as a share of g t^2 / 2, with t "
        "since the release.",
    )


class Placing(Section):
    """Rules of `pick_and_place` and `ellipse`, which put an object down in its bin."""

    over_rim: Finite = Field(
        default=0.01,
        description="Height of the object's lowest point above the rim at the release of a carried object; "
        "negative: inside the bin [m].",
    )
    clear: NonNegative = Field(
        default=0.02, description="Least height of a carried object above the rims that it passes over [m]."
    )
    vertical: Positive = Field(
        default=0.02, description="`ellipse`: least length of the straight parts at pick and place (Choe 2023) [m]."
    )
    crest: Positive = Field(default=0.025, description="`ellipse`: height of the path above the higher end [m].")
    reserve: NonNegative = Field(
        default=0.03,
        description="Like `motion.reserve`, for a carried object, which misses only by the error of its grasp [m].",
    )


class Motion(Section):
    """Motion of the hand in one cycle, from lift to lift."""

    ceiling: Positive = Field(
        default=0.10,
        description="Release at most this far above the pick (Hassan 2022, IV-B); `horizontal` and "
        "`pick_and_place` rise by this height, at this pick and at the next [m].",
    )
    clearance: Positive = Field(
        default=0.05, description="Height above the next pick from which the hand comes down vertically, Z_off [m]."
    )
    dwell: NonNegative = Field(
        default=0.10,
        le=10,
        description="Time at the pick while the vacuum builds up; counted, not simulated. 30 l/min empty 15 cm3 to "
        "-0.6 bar in 70 ms (arithmetic) [s].",
    )
    follow_through: FollowThrough = FollowThrough()
    ceiling_slack: NonNegative = Field(
        default=0.03, description="Height by which a residual may exceed the release ceiling [m]."
    )
    reserve: NonNegative = Field(
        default=0.10,
        description="Distance: a target is accepted only if targets nearer and farther by this distance along the "
        "throw are feasible too [m].",
    )
    placing: Placing = Placing()


class Suction(Section):
    """Delay of the release after the command: valve delay + decay of the vacuum + jitter.

    delay = valve + tau_e ln(F0 / (m g)), tau_e = tau / (1 + leak (F_ref / F0 - 1)) for F0 below F_ref: a porous
    seal vents through its leak as well.
    """

    valve: NonNegative = Field(
        default=0.004, le=1, description="Delay of the valve after its command, assumed; 2 to 14 ms are plausible [s]."
    )
    tau: NonNegative = Field(
        default=0.009,
        le=1,
        description="Time constant of the vacuum under a tight seal, assumed: no measured figure was found. By "
        "arithmetic (choked flow through a valve of 3 mm2), a cup with a short hose, 15 cm3 in all, loses 63 % of 0.6 "
        "bar in 9.5 ms; with 1.5 m of hose of 8 mm, 75 cm3, it takes five times as long [s].",
    )
    leak: NonNegative = Field(default=0.25, description="Strength of the leak's effect on tau, assumed.")
    leak_reference: Positive = Field(default=20.0, description="Seal force above which the seal does not leak [N].")
    jitter: Duration = Field(default=0.001, description="Standard deviation of the release time [s].")


class Grip(Section):
    """Holding limit of the cup until the release, by slip and peel (`cells.conveyor.cup.hold`)."""

    limit: bool = Field(
        default=True,
        description="Whether an object leaves the cup on the way when its load is more than the cup can hold; the "
        "load scales with the mismatch.",
    )
    safety: Annotated[float, Field(ge=1, le=10)] | Literal["surface"] | None = Field(
        default=None,
        description="Throws are slowed until the cup could hold the measured load times this factor (surface: the "
        "factor of the item's surface). An object for which no throw is slow enough stays on the belt. "
        "null: no throw is slowed.",
    )


class Throwable(Section):
    """Bounds of thrown objects; others stay on the belt, or are put down by the planner `auto`. null: no bound."""

    drag_area: Positive | None = Field(
        default=None,
        description="Largest Cd A / m of a thrown object, by the Cd of its class and its measured outline and mass "
        "[m2/kg]; null: no bound.",
    )
    drag_shift: Positive | None = Field(
        default=None,
        description="Largest shift of a thrown object's landing by air, to first order [m]; null: no bound.",
    )
    margin: Annotated[float, Field(ge=1, le=10)] | None = Field(
        default=None,
        description="Least load that the cup must hold for an object to be thrown, as a multiple of the measured "
        "load of the throw; null: no bound.",
    )


class Cup(Section):
    """The cup's lip: how it bends while it holds an object, and the spin that it gives the object at the release."""

    stiffness: Annotated[float, Field(ge=0.05, le=100)] | None = Field(
        default=1.0,
        description="Stiffness of the lip against bending about each level axis; compliance scales with the "
        "mismatch. 0.1 to 3 are plausible, a bellows at the soft end (assumed); null: a rigid cup [N "
        "m/rad].",
    )
    damping: Annotated[float, Field(ge=0, le=0.95)] = Field(
        default=0.25, description="Damping ratio of the object's swing about each level axis, assumed."
    )
    peel: bool = Field(
        default=True,
        description="Whether the lip peels off at one side, which gives the spin at release; if not, the spin is "
        "drawn from `spread.spin` and `spread.spin_per_offset`.",
    )
    blow_off: Annotated[float, Field(ge=0, le=1)] = Field(
        default=0.0,
        description="Speed downwards that air blown into the cup gives the object at release, at mismatch 1; valves "
        "for blowing off are usual in compact ejectors, the speed of 0 to 0.3 m/s is assumed [m/s].",
    )
    fitted: bool = Field(
        default=True,
        description="Whether each item has a cup of its own `cup_radius`; if not, one cup of radius 18 mm serves all.",
    )


class Pick(Section):
    """Whether the cup has sealed on its object at the end of the dwell (`cells.conveyor.cup.hold`)."""

    fails: bool = Field(
        default=True,
        description="Whether a cup may fail to seal, depending on the item's `pick_chance` and on the place of "
        "the cup on the object; the chance to fail scales with the mismatch. A failed pick costs its "
        "cycle, and the object rides on.",
    )


class Classifier(Section):
    """The classifier of objects, which decides their bins."""

    confusion: dict[str, dict[str, Annotated[float, Field(ge=0, le=1)]]] = Field(
        default={},
        description="For each true item, the shares of the items that the classifier reports, which sum to 1; "
        "errors scale with the mismatch. Items that are not listed are always recognised.",
    )


class ActionScale(Section):
    """Residual of an action of 1 in each action mode."""

    along: Positive = Field(
        default=0.20, description="Shift of the drag-free landing along the throw, for an action of 1 [m]."
    )
    across: Positive = Field(
        default=0.06, description="Shift of the drag-free landing across the throw, for an action of 1 [m]."
    )
    xyz: tuple[Positive, Positive, Positive] = Field(
        default=(0.12, 0.02, 0.015),
        description="Shift of the release point along the throw, sideways and up, for an action of 1 in the mode "
        "`release_xyz` [m].",
    )
