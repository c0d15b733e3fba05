"""Sections of a line's level: robots, arrivals, values, costs and standstills."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Annotated, Any, Final, final

from pydantic import Field, field_validator

from pnt_gym.cells.base.config import Finite, Label, NonNegative, Positive, Section
from pnt_gym.cells.base.sorting import Bin
from pnt_gym.cells.conveyor.robot import RobotSheet

FARTHEST: Final = 2e5
"""Robots stand no farther from the origin along the belt, where doubles still resolve 3e-11 m [m]."""
Percents = tuple[Annotated[float, Field(ge=1, le=100)], ...]


@final
class Robot(Section):
    """One robot of the line."""

    name: Label = Field(description="Name of the robot.")
    x: Finite = Field(
        ge=-FARTHEST, le=FARTHEST, description="Position of the robot's base along the belt, downstream positive [m]."
    )
    skills: tuple[str, ...] = Field(
        default=(),
        description="Items that the robot takes, as classified by the camera; empty: all items that its bins accept.",
    )
    bins: tuple[Bin, ...] = Field(
        default=(), description="Bins of the robot, with positions from its base; empty: the bins of the `cell`."
    )
    robot: RobotSheet | None = Field(
        default=None,
        description="The robot itself: the name of a shipped data sheet, or a data sheet; null: that of the `cell`.",
    )
    percent: Percents = Field(
        default=(), description="Speed settings from which the robot chooses; empty: the settings of the `cell` [%]."
    )

    def takes(self, item: str, bins: Sequence[Bin]) -> bool:
        """Whether the robot has the skill for an item, and a bin for it; `bins` are those of the cell."""
        has_bin = any(bin_.takes(item) for bin_ in self.bins or bins)
        return has_bin and (not self.skills or item in self.skills)

    def item_names(self) -> Iterator[str]:
        """Items that the robot's skills and bins name."""
        yield from self.skills
        for bin_ in self.bins:
            yield from bin_.accepts


@final
class Arrivals(Section):
    """Arrival of objects along the belt."""

    rate: Annotated[float, Field(gt=0, le=20)] = Field(
        default=1.5, description="Mean number of objects per second [1/s]."
    )
    regularity: Annotated[float, Field(ge=0.1, le=100)] = Field(
        default=1.0,
        description="Shape of the gamma distribution of the gaps: 1 is a Poisson stream, values below 1 make bursts.",
    )
    gap: Annotated[float, Field(ge=0, le=1)] = Field(
        default=0.01,
        description="Least distance between objects, along the belt or across it; a closer object moves upstream [m].",
    )


@final
class Value(Section):
    """Value of an object in a bin that takes the object."""

    of: dict[str, NonNegative] = Field(default={}, description="Value by item; an item that is not listed is worth 1.")
    spread: Annotated[float, Field(ge=0, le=2)] = Field(
        default=0.0,
        description="Spread of the lognormal distribution of single objects' values, whose mean is the item's value; "
        "the camera sees the value of each object.",
    )


@final
class Cost(Section):
    """Costs and proceeds of a line, in any currency; `pnt-gym line plan` computes the money that a plan earns an hour.

    A plan earns what its sorted objects bring, less its robots' hours and its motors' energy.
    """

    robot_hour: NonNegative = Field(default=0.0, description="Cost of an hour of one robot [1/h].")
    joule: NonNegative = Field(
        default=0.0, description="Cost of a joule of the motors' work; 0.30 a kWh are 8.3e-8 [1/J]."
    )
    per_tonne: dict[str, NonNegative] = Field(
        default={}, description="Proceeds of a sorted tonne by item; an item that is not listed brings nothing [1/t]."
    )

    @property
    def applies(self) -> bool:
        """Whether the level names any cost or proceeds."""
        return bool(self.robot_hour or self.joule or any(self.per_tonne.values()))


Share = Annotated[float, Field(ge=0, le=1)]


@final
class TableEntries(Section):
    """A table of throws in the level itself, with the entries of the file that `pnt-gym line calibrate` writes."""

    digest: str = Field(description="Name of the cells for which the throws were counted.")
    percent: tuple[Finite, ...] = Field(description="Speed settings [%].")
    edges: tuple[Finite, ...] = Field(description="Borders between the classes of distance [m].")
    picked: tuple[Share, ...] = Field(description="Share of the picks in which the cup seals, by item.")
    landed: tuple[tuple[tuple[Share, ...], ...], ...] = Field(
        description="Share of the held objects that end in their bin, by item, speed setting and class of distance."
    )


@final
class Down(Section):
    """Standstill of one robot for a part of the work shift."""

    robot: str = Field(
        min_length=1, description="Name of the robot that stands still, or its number, 1 for the most upstream one."
    )
    start: NonNegative = Field(description="Start of the standstill, from the beginning of the work shift on [s].")
    end: Positive = Field(description="End of the standstill, from the beginning of the work shift on [s].")

    @field_validator("robot", mode="before")
    @classmethod
    def _name(cls, value: Any) -> Any:
        """The text of a number: a robot may be given by its number."""
        return str(value) if isinstance(value, int) and not isinstance(value, bool) else value

    def place(self, names: Sequence[str]) -> int | None:
        """Index of the robot among the names of robots; None if no robot has the name or the number."""
        if self.robot in names:
            return names.index(self.robot)
        number = int(self.robot) if self.robot.isdecimal() and len(self.robot) < 4 else 0
        return number - 1 if 1 <= number <= len(names) else None
