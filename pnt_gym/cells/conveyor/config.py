"""Config of a conveyor cell: every number once, with its unit and its reason.

Belt, items, bins and sensors are sections of any sorting cell (`cells.base.sorting`); `sections` has the robot's.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, ClassVar, Final, Literal

import numpy as np
from pydantic import Field

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.config import Positive, Range
from pnt_gym.cells.base.items import Item
from pnt_gym.cells.base.merging import MergeRules
from pnt_gym.cells.base.sorting import SortingLine, SortingReward
from pnt_gym.cells.conveyor.arm import arm_problems
from pnt_gym.cells.conveyor.drift import Bias, Cells, Drift, Feedback
from pnt_gym.cells.conveyor.robot import T3KR, RobotSheet, locate_robot
from pnt_gym.cells.conveyor.sections import ActionScale, Classifier, Cup, Grip, Limits, Motion, Pick, Suction, Throwable
from pnt_gym.names import list_names
from pnt_gym.planning.motion.riding import fastest_belt

SUM_TOLERANCE: Final = 1e-6
"""Tolerance of shares that must sum to 1."""
GRID: Final = 25
"""Points along and across the window at which a robot's reach is tried."""
LIP_GAP: Final = 0.0005
"""Gap between a held object and the rigid part of the cup, so that holding the object is not a contact [m]."""
LIP_LENGTH: Final = 0.010
"""Length of a compliant lip below the solid part of its cup; an object can tilt until it touches the solid part [m]."""


class ConveyorConfig(SortingLine):
    """A conveyor cell. The defaults are the level `nominal` without its bins."""

    rules: ClassVar[MergeRules] = replace(
        SortingLine.rules,
        wholes=frozenset({"mix", "classifier.confusion", "robot"}),
        dependents={"items": ("mix", "classifier.confusion")},
    )

    timestep: Annotated[float, Field(ge=0.0001, le=0.002)] = Field(
        default=0.001,
        description="Physics step [s]; 1 ms for training, 0.4 ms for evaluation. Long steps make contacts rebound too "
        "much: in steps of 1 ms those of a restitution of 0.87 or more gain speed, in steps of 2 ms those of 0.32 or "
        "more. Above 2 ms kinematic loops drift.",
    )
    fidelity: Literal["full", "flight"] = Field(
        default="full",
        description="What is simulated: robot and object (full), or the object alone, with a hand that moves as "
        "planned (flight), which is several times as fast.",
    )
    mix: dict[str, Positive] | None = Field(
        default=None,
        description="Relative frequency of the items; an item that is not listed never arrives. null: all items "
        "are equally frequent.",
    )
    robot: RobotSheet = Field(
        default=T3KR,
        description="The robot: the name of a shipped data sheet, or a data sheet. Joints and motors are those of the "
        "T3KR or of the sheet's `model`; of any other robot only the hand is simulated, with `fidelity: flight`.",
    )
    limits: Limits = Limits()
    motion: Motion = Motion()
    suction: Suction = Suction()
    grip: Grip = Grip()
    throwable: Throwable = Throwable()
    cup: Cup = Cup()
    pick: Pick = Pick()
    classifier: Classifier = Classifier()
    cells: Cells = Cells()
    drift: Drift = Drift()
    bias: Bias = Bias()
    feedback: Feedback = Feedback()
    action: ActionScale = ActionScale()
    reward: SortingReward = SortingReward()
    planner: Literal[
        "straight", "straight_flying", "free_direction", "horizontal", "pick_and_place", "ellipse", "auto"
    ] = Field(
        default="straight",
        description="How an object gets to its bin: thrown on a straight line (Hassan 2022), the same with a return "
        "that does not stop after the throw, in a free direction, "
        "or level from above the pick; or carried on a rectangle or over an ellipse (Choe 2023). "
        "`auto` throws a `throwable` object straight and carries every other object over an ellipse.",
    )
    dispatch: Literal["first", "soonest", "atc"] = Field(
        default="atc",
        description="The next object, of those that the hand can meet and throw: the object most downstream "
        "(first), the object with the shortest cycle (soonest), or a quick object that cannot wait "
        "(atc).",
    )
    patience: Positive = Field(
        default=8.0,
        le=1e6,
        description="k of `dispatch: atc`: an object that can wait longer by this time comes first only if its "
        "cycle is shorter by the factor e [s].",
    )
    picks_per_shift: Annotated[int, Field(ge=1)] = Field(
        default=50, description="Throws of an episode on the belt, and of any other shift."
    )

    @classmethod
    def locate(cls, data: dict[str, Any], folder: Path) -> dict[str, Any]:
        """The differences in a level's file, with paths to the files beside it that they name."""
        return locate_robot(super().locate(data, folder), folder)

    def files(self) -> tuple[Path, ...]:
        """Model file of the robot, if the level has one."""
        return () if self.robot.model is None else (Path(self.robot.model.file),)

    def problems(self) -> Iterator[str]:
        """A sentence for each problem of values that are possible alone, and not together."""
        yield from super().problems()
        yield from self.robot_problems()
        yield from self.strangers("mix", self.mix or ())
        definitions = self.item_definitions()
        unheld = [name for name in self.items if name in definitions and definitions[name].seal_force is None]
        if unheld:
            verb, pronoun = ("has", "it") if len(unheld) == 1 else ("have", "them")
            yield f"items: {list_names(unheld)} {verb} no seal_force; a suction cup cannot hold {pronoun}"
        if self.cells.stiffness is not None and self.cup.stiffness is None:
            yield "cells.stiffness is a range, and cup.stiffness is null, a rigid cup; give cup.stiffness a number"
        if self.cells.blow_off is not None and self.spread.blow_off > 0.0 == self.cup.blow_off:
            yield "cells.blow_off is a range and spread.blow_off its spread; give cup.blow_off a number above 0, too"
        for true, row in self.classifier.confusion.items():
            yield from self.strangers(f"classifier.confusion of {true!r}", dict.fromkeys((true, *row)))
            if abs(sum(row.values()) - 1.0) > SUM_TOLERANCE:
                yield (
                    f"classifier.confusion of {true!r} sums to {sum(row.values()):.7g}; the shares of an item must sum "
                    "to 1"
                )
        yield from self.ride_problems()

    def _known_items(self) -> list[Item]:
        """Items of the cell, but those that the catalogue does not have."""
        definitions = self.item_definitions()
        return [definitions[name] for name in self.items if name in definitions]

    def reached_share(self) -> float:
        """Share of the window in which objects are picked that the hand reaches, at the lowest item's height."""
        height = self.belt.height + min((item.size[2] for item in self._known_items()), default=0.0)
        x, y = np.meshgrid(np.linspace(*self.belt.pick_x, GRID), np.linspace(*self.belt.lane_y, GRID))
        return float(self.robot.workspace.contains(np.stack([x, y, np.full_like(x, height)], axis=-1)).mean())

    def robot_problems(self) -> Iterator[str]:
        """What is wrong with the robot in this cell."""
        robot = self.robot
        if self.fidelity == "full" and not robot.has_model:
            yield (
                f"fidelity is 'full' and robot is {robot.name!r}, known by its data sheet alone, without joints and "
                "motors; set fidelity to 'flight'"
            )
        yield from arm_problems(robot)
        heavy = [item for item in self._known_items() if item.mass > robot.payload]
        if heavy:
            yield (
                f"robot {robot.name!r} carries at most {robot.payload:g} kg; "
                f"{list_names([f'{item.name} ({item.mass:g} kg)' for item in heavy])} is heavier"
            )
        (low, high), (left, right), lowest = self.belt.pick_x, self.belt.lane_y, self.belt.height
        if self.reached_share() == 0.0:
            yield (
                f"robot {robot.name!r} covers 0 % of the window in which objects are picked, x {low:g} to {high:g} m "
                f"and y {left:g} to {right:g} m at belt.height {lowest:g} m; move robot.reach or robot.height there"
            )
        if robot.reach.shape == "ring" and self.planner != "straight":
            yield (
                f"planner is {self.planner!r} and robot.reach is a ring, whose hole only the planner 'straight' keeps "
                "clear of"
            )

    @property
    def lift_x(self) -> Range:
        """Range along x in which objects are lifted [m]: the pick window, less the hand's ride before the lift."""
        low, high = self.belt.pick_x
        return (low + self.belt.speed * self.motion.dwell if self.belt.tracking else low), high

    def ride_problems(self) -> Iterator[str]:
        """What is wrong with the ride of a hand with the belt."""
        if not self.belt.tracking:
            return
        speed, fastest = self.belt.speed, fastest_belt(self.robot.limits(np.array(self.limits.percent)))
        if speed > fastest:
            yield (
                f"belt.speed is {speed:g} m/s; a hand at {min(self.limits.percent):g} % of its limits can ride with "
                f"belts up to {fastest:.2f} m/s, see belt.tracking"
            )
        low, high = self.lift_x
        if low > high:
            yield (
                f"motion.dwell is {self.motion.dwell:g} s; a hand that rides with the belt at {speed:g} m/s leaves "
                f"belt.pick_x {self.belt.pick_x} after at most {(high - self.belt.pick_x[0]) / speed:.3g} s"
            )

    @property
    def swings(self) -> bool:
        """Whether objects swing under their cups; at mismatch 0 they do not."""
        return self.cup.stiffness is not None and self.mismatch > 0.0

    @property
    def lip_length(self) -> float:
        """Length of the lip between the tip of a cup and its solid part [m]."""
        return LIP_LENGTH if self.swings else 0.0

    @property
    def pushes(self) -> bool:
        """Whether blown air pushes objects off their cups."""
        fastest = max(self.cup.blow_off, *(self.cells.blow_off or (0.0,)))
        return fastest > 0.0 and self.mismatch > 0.0

    def shares(self) -> Floats:
        """Share of each item among the objects on the belt (K,)."""
        weights = np.array([self.mix.get(name, 0.0) if self.mix else 1.0 for name in self.items])
        return weights / weights.sum()

    def confusion(self) -> Floats:
        """Probability that an item (rows) is classified as an item (columns); errors scale with the mismatch."""
        shares = np.eye(len(self.items))
        for true, row in self.classifier.confusion.items():
            index = self.items.index(true)
            wrong = self.mismatch * np.array([0.0 if name == true else row.get(name, 0.0) for name in self.items])
            wrong /= max(wrong.sum(), 1.0)
            shares[index] = wrong
            shares[index, index] = 1.0 - wrong.sum()
        return shares
