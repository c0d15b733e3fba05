"""Level of a line: its robots, the objects that come along their belt, their value, and how throws are computed."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, ClassVar, Final, Literal, Self, cast, final

import numpy as np
from pydantic import Field, ValidationInfo, field_validator

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.base.config import LevelConfig, NonNegative, Positive, locate_files
from pnt_gym.cells.base.merging import MergeRules
from pnt_gym.cells.conveyor.arm import content_of
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.robot import T3KR, RobotSheet, locate_robot
from pnt_gym.cells.line.sections import Arrivals, Cost, Down, Robot, TableEntries, Value
from pnt_gym.constants import WORLD
from pnt_gym.errors import ConfigError, one_sentence
from pnt_gym.names import BRIEF, list_names, unknown_name

MOST_ROBOTS: Final = 4
FULLEST: Final = 0.5
"""Share of the belt's lanes that objects may cover; denser arrivals would lie on each other."""
SPARE: Final = 6.0
"""Standard deviations of the number of objects that are drawn beyond the mean, so that no belt runs empty."""
MOST_OBJECTS: Final = 400_000
"""Objects that are drawn for a shift at most: four hours of 20 a second are 300,000, some 250 MB."""
MADE_TABLES: Final = Path("runs") / "chances"
"""Folder of the tables that commands make, in the working folder."""
_UNCONCERNED: Final = {
    "name", "mix", "fidelity", "dispatch", "patience", "picks_per_shift", "reward", "timestep", "cells",
}  # fmt: skip
"""Fields of a cell on which a line's table of throws does not depend."""
_GHOSTS: Final = {"belt": {"neighbours": "ghosts"}}
"""Neighbours on a line, where carried objects pass over the objects on the belt."""


_RANDOM_BINS: Final = (
    "level {!r} of a line has cell.bins.random, which draws a bin for every throw; the robots of a line have fixed "
    "bins: leave random out and list the bins in cell.bins.fixed, or in the bins of each robot"
)


@final
class LineConfig(LevelConfig):
    """A line of robots along one belt.

    Robots, belt, items and bins are given by a conveyor cell, `cell`, in the form of the conveyor's levels. Positions
    in the cell count from each robot's base.
    """

    folder: ClassVar[str | Path] = "line"
    trial: ClassVar[str] = "work_shifts"

    rules: ClassVar[MergeRules] = MergeRules(
        wholes=frozenset({"value.of", "cost.per_tonne", "chances"}),
        dependents={"cell.items": ("value.of", "cost.per_tonne")},
    )

    cell: ConveyorConfig = Field(
        description="A level of the conveyor: its name, a YAML file, or differences from the `cell` of the line's "
        "base. A name, a file and differences with a `base` of their own leave the `cell` of the line's base out."
    )
    robots: tuple[Robot, ...] = Field(
        default=(Robot(name="first", x=0.0),),
        min_length=1,
        max_length=MOST_ROBOTS,
        description="The robots, upstream first.",
    )
    arrivals: Arrivals = Arrivals()
    value: Value = Value()
    cost: Cost = Cost()
    down: tuple[Down, ...] = Field(default=(), description="Standstills of robots.")
    camera: Positive = Field(
        default=1.0, le=20, description="Distance of the camera upstream of the first robot's window [m]."
    )
    duration: Annotated[float, Field(ge=5, le=14400)] = Field(default=120.0, description="Length of a work shift [s].")
    horizon: Annotated[float, Field(gt=0, le=10)] = Field(
        default=3.0, description="Objects that can be lifted within this time are among the choices [s]."
    )
    price_of_time: NonNegative = Field(
        default=1.0,
        description="Value that a second of time costs, in the reward and in the order of the choices [1/s].",
    )
    throws: Literal["table", "flight", "full"] = Field(
        default="table",
        description="How the result of a throw is found: from a table of chances counted in the full physics, "
        "from a simulated flight, or from simulated robot and flight.",
    )
    chances: str | TableEntries | None = Field(
        default=None,
        description="File with the table of throws, as `pnt-gym line calibrate` writes it, or the table itself; null: "
        "the shipped table of the level's cells.",
    )

    @classmethod
    def locate(cls, data: dict[str, Any], folder: Path) -> dict[str, Any]:
        """The differences in a level's file, with paths to the files beside it that they name."""
        data = locate_files(data, folder, "base", "cell", "chances")
        if isinstance(data.get("cell"), dict):
            data["cell"] = locate_robot(locate_files(data["cell"], folder, "base"), folder)
        if isinstance(robots := data.get("robots"), list):
            data["robots"] = [locate_robot(robot, folder) for robot in cast("list[Any]", robots)]
        return data

    @classmethod
    def merge(cls, below: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
        """Differences `above` merged into the values `below`; a cell with a base of its own replaces the cell below."""
        cell: Any = above.get("cell")
        if isinstance(cell, str | Path):
            cell = {"base": cell}
        if not isinstance(cell, Mapping):
            return super().merge(below, above)
        cell = cast("Mapping[str, Any]", cell)
        if "base" in cell:
            below = super().merge(below, {"cell": {"items": ()}})  # drops what speaks of the items below
            return {**super().merge(below, above), "cell": dict(cell)}
        under: Any = below.get("cell", {})
        return {**super().merge(below, above), "cell": ConveyorConfig.merge(under, cell)}

    @field_validator("cell", mode="before")
    @classmethod
    def _read(cls, value: object, info: ValidationInfo) -> object:
        """The conveyor level that the differences in `cell` describe; on a line its neighbours are ghosts."""
        if isinstance(value, str | Path):
            value = {"base": value}
        if isinstance(value, ConveyorConfig):
            return value
        if not isinstance(value, dict):
            raise ValueError(
                f"cell is {one_sentence(repr(value), 60)}; it must be a level of the conveyor, a YAML file or a section"
            )
        cell = cast("dict[str, Any]", value)
        if misplaced := [key for key in cell if key in set(cls.model_fields) - set(ConveyorConfig.model_fields)]:
            raise ValueError(f"cell: {list_names(misplaced)} must stand beside `cell`, and not in it")
        if cell.get("robot") is not None:  # how much of a throw is simulated, `throws` of the line says
            cell = {"fidelity": "flight", **cell}
        bins: object = cell.get("bins")
        if isinstance(bins, dict) and cast("dict[str, Any]", bins).get("random") is not None:
            raise ValueError(_RANDOM_BINS.format(info.data.get("name")))
        try:
            return ConveyorConfig.load(ConveyorConfig.merge(_GHOSTS, cell) if "base" in cell else dict(cell))
        except ConfigError as error:
            problems = error.args[1:] or (str(error).removeprefix("config: "),)
            raise ValueError(*(f"cell: {problem}" for problem in problems)) from None

    def problems(self) -> Iterator[str]:
        """A sentence for each problem of values that are possible alone, and not together."""
        yield from self._cell_problems()
        cell = self.cell
        covered, room = self.arrivals.rate * footprint(cell), np.ptp(cell.belt.lane_y) * cell.belt.speed
        if covered > FULLEST * room:
            yield (
                f"arrivals.rate is {self.arrivals.rate:g} objects a second; the belt's lanes have room for at most "
                f"{FULLEST * room / footprint(cell):.3g} of these items a second"
            )
        if not self.objects <= MOST_OBJECTS:
            low, high = self.reach
            yield (
                f"a shift of {self.duration:g} s with arrivals.rate {self.arrivals.rate:g} and {high - low:g} m of a "
                f"belt that runs {self.cell.belt.speed:g} m/s takes {self.objects:.3g} objects; at most "
                f"{MOST_OBJECTS} are drawn: shorten the shift, or move the robots closer together"
            )
        yield from self._sheet_problems()
        yield from self.robot_problems()
        yield from self.cell.strangers("value.of", self.value.of)
        yield from self.cell.strangers("cost.per_tonne", self.cost.per_tonne)
        yield from self._skill_problems()
        for robot in self.robots:
            # What is wrong with a robot's skills, bins and speed settings.
            names = [bin_.name for bin_ in robot.bins]
            if len(set(names)) != len(names):
                yield f"bins of robot {robot.name!r} are called {names}; the names must differ from one another"
            yield from self.cell.strangers(f"skills of robot {robot.name!r}", robot.skills)
            for bin_ in robot.bins:
                yield from self.cell.strangers(f"bin {bin_.name!r} of robot {robot.name!r}", bin_.accepts)
            if robot.bins:
                bins = self.cell.bins.model_copy(update={"fixed": robot.bins})
                for clause in self.cell.model_copy(update={"bins": bins}).bin_place_problems():
                    yield f"robot {robot.name!r}: {clause}"
            if robot.percent and robot.robot is None:
                limits = self.cell.limits.model_copy(update={"percent": robot.percent})
                for clause in self.cell.model_copy(update={"limits": limits}).ride_problems():
                    yield f"robot {robot.name!r}: {clause}"

    def _cell_problems(self) -> Iterator[str]:
        cell = self.cell
        if cell.bins.random is not None:
            yield _RANDOM_BINS.format(self.name)
        if cell.belt.neighbours != "ghosts":
            yield (
                "cell.belt.neighbours is 'solid'; on a line carried objects pass over the belt's objects: use 'ghosts'"
            )
        if cell.planner == "auto" or any(
            getattr(cell.throwable, name) is not None for name in type(cell.throwable).model_fields
        ):
            yield (
                "cell.planner 'auto' and cell.throwable select the thrown objects; on a line the robots' skills do: "
                "leave both out"
            )
        elif cell.planner != "straight":
            yield f"cell.planner is {cell.planner!r}; on a line hands move on straight lines: leave cell.planner out"
        if cell.grip.safety is not None:
            yield (
                f"cell.grip.safety is {cell.grip.safety!r}; on a line throws are not slowed for the grip: "
                "leave cell.grip.safety out"
            )
        if cell.drift.moves:
            yield "cell.drift is not zero; a line has no drift: leave cell.drift out"
        if cell.cells.ranges:
            yield "cell.cells has ranges; a line's throws are those of one cell: leave cell.cells out"

    def _sheet_problems(self) -> Iterator[str]:
        """What is wrong with the robots' data sheets."""
        strange = [*dict.fromkeys(sheet.name for sheet in self.sheets() if not sheet.has_model)]
        if self.throws == "full" and strange:
            yield (
                f"throws is 'full' and robot is {list_names(strange)}, known by the data sheet alone, "
                "without joints and motors; set throws to 'table' or 'flight'"
            )
        for robot in self.robots:
            if robot.robot is not None:
                limits = self.cell.limits.model_copy(update={"percent": robot.percent or self.cell.limits.percent})
                cell = self.cell.model_copy(update={"robot": robot.robot, "fidelity": "flight", "limits": limits})
                for clause in (*cell.robot_problems(), *cell.ride_problems()):
                    yield f"robot {robot.name!r}: {clause}"

    def robot_problems(self) -> Iterator[str]:
        """What is wrong with the robots beside each other: names, bins that fill, windows and standstills."""
        names = [robot.name for robot in self.robots]
        if len(set(names)) != len(names):
            yield f"robots are called {names}; the names must differ from one another"
        counts = [len(robot.bins or self.cell.bins.fixed) for robot in self.robots]
        if self.cell.bins.emptied is not None and len(set(counts)) > 1:
            yield (
                f"cell.bins.emptied is {self.cell.bins.emptied}; robots with {counts} bins fill their bins "
                "unequally: set cell.bins.emptied to null"
            )
        low, high = self.cell.belt.pick_x
        for before, robot in zip(self.robots, self.robots[1:], strict=False):
            if robot.x + low < before.x + high:
                yield (
                    f"robots {before.name!r} at x {before.x:g} m and {robot.name!r} at {robot.x:g} m have windows that "
                    f"overlap; each reaches from {low:g} to {high:g} m, upstream robots come first"
                )
        for down in self.down:
            if down.place(names) is None:
                numbers = f", or a number from 1 to {len(names)}"
                yield f"down: {unknown_name('robot', down.robot, names, numbers, room=BRIEF)}"
            if down.start >= down.end:
                yield f"down.start is {down.start:g} s; it must be smaller than down.end, {down.end:g} s"

    def _skill_problems(self) -> Iterator[str]:
        """Items that no robot takes, and robots that take no item; a misspelled name has a clause of its own."""
        if any(name not in self.cell.items for robot in self.robots for name in robot.item_names()):
            return
        can_take, shares = self.can_take(), self.cell.shares()
        items = [self.cell.items[index] for index in np.flatnonzero(~can_take.any(axis=0) & (shares > 0.0))]
        if items:
            noun = "item" if len(items) == 1 else "items"
            yield f"no robot takes {noun} {list_names(items)}; give a robot the skill and a bin for the item"
        for index in np.flatnonzero(~can_take.any(axis=1)):
            yield f"robot {self.robots[index].name!r} takes no item; give the robot skills that its bins accept"

    def assumed(self) -> dict[str, dict[str, Any]]:
        """Assumed values of the items that the cell adds."""
        return self.cell.assumed()

    def files(self) -> tuple[Path, ...]:
        """File of the table of throws, if the level names one or a command has made one, and models of its robots."""
        models = tuple(Path(sheet.model.file) for sheet in self.sheets() if sheet.model is not None)
        if isinstance(self.chances, str):
            return (Path(self.chances), *models)
        return (self.made_table(), *models) if self.chances is None and self.made_table().is_file() else models

    def digest(self) -> str:
        """Name of the line's table of throws, from everything on which its robots' throws depend."""
        return hashlib.sha256("\n".join([f"world {WORLD}", *sorted({*self.kinds()})]).encode()).hexdigest()[:16]

    def kinds(self) -> list[str]:
        """Everything on which the throws of each robot depend, as text (R,)."""
        kinds: list[str] = []
        for cell in self.cells():
            left_out: dict[str, Any] = dict.fromkeys(_UNCONCERNED, True)
            if not cell.bias.applies:
                left_out["bias"] = True
            # What the file of a model says counts, and not where it lies.
            left_out["robot"] = cell.robot == T3KR or {"model": {"file"} if cell.robot.model else True}
            data = cell.model_dump(mode="json", exclude=left_out)
            kinds.append(json.dumps(data, sort_keys=True) + content_of(cell.robot))
        return kinds

    def made_table(self, folder: Path = MADE_TABLES) -> Path:
        """File of the line's table of throws, as commands name the tables that they make."""
        return folder / f"{self.digest()}.json"

    def cells(self) -> list[ConveyorConfig]:
        """Each robot as a conveyor cell of its own."""
        alike = [(robot.robot, robot.percent, robot.bins) for robot in self.robots]
        first = [alike.index(own) for own in alike]
        made = {index: self.cell_of(index) for index in sorted(set(first))}
        return [made[index] for index in first]

    def cell_of(self, index: int) -> ConveyorConfig:
        """One robot as a conveyor cell of its own."""
        robot, cell = self.robots[index], self.cell
        changes: dict[str, Any] = {"fidelity": self.finest if self.throws == "table" else self.throws}
        if robot.robot is not None:
            changes["robot"] = robot.robot
        if robot.percent:
            changes["limits"] = cell.limits.model_copy(update={"percent": robot.percent})
        if not robot.bins:
            return ConveyorConfig.model_validate({**dict(cell), **changes})
        # A robot's own bins need not take every item. Their places are validated with bins that take all items.
        open_bins = [bin_.model_copy(update={"accepts": ()}) for bin_ in robot.bins]
        changes["bins"] = cell.bins.model_copy(update={"fixed": tuple(open_bins)})
        checked = ConveyorConfig.model_validate({**dict(cell), **changes})
        cell_config = checked.model_copy(update={"bins": cell.bins.model_copy(update={"fixed": robot.bins})})
        items: Ints = np.flatnonzero(cell_config.acceptance().sum(axis=1))
        return cell_config.model_copy(update={"mix": {cell.items[k]: float(cell.shares()[k] or 1.0) for k in items}})

    def sheets(self) -> list[RobotSheet]:
        """Data sheet of each robot."""
        return [robot.robot or self.cell.robot for robot in self.robots]

    @property
    def finest(self) -> Literal["flight", "full"]:
        """The most that can be simulated: all of the throws, or flights where a robot is known by its sheet alone."""
        return "full" if all(sheet.has_model for sheet in self.sheets()) else "flight"

    def simulated(self, **changes: Any) -> Self:
        """The line with throws that are simulated as far as its robots are known."""
        return self.load(self, throws=self.finest, **changes)

    def can_take(self) -> Bools:
        """Whether each robot (rows) takes an object classified as each item (columns)."""
        takes = [[robot.takes(item, self.cell.bins.fixed) for item in self.cell.items] for robot in self.robots]
        return np.array(takes, dtype=np.bool_)

    def robot_x(self) -> Floats:
        """Positions of the robots along the belt (R,) [m]."""
        return np.array([robot.x for robot in self.robots])

    def values(self) -> Floats:
        """Mean value of each item (K,)."""
        return np.array([self.value.of.get(name, 1.0) for name in self.cell.items])

    @property
    def reach(self) -> tuple[float, float]:
        """Where objects are known and can be taken: from the camera to the end of the last window [m]."""
        low, high = self.cell.belt.pick_x
        return self.robots[0].x + low - self.camera, self.robots[-1].x + high

    @property
    def objects(self) -> float:
        """Number of objects that are drawn for a shift; almost certainly the last one never comes into sight."""
        upstream, downstream = self.reach
        # A renewal stream of mean m and regularity k has a standard deviation of about sqrt(m / k).
        belt = (downstream - upstream) / self.cell.belt.speed + self.duration + self.horizon
        mean = max(self.arrivals.rate * belt, 0.0)  # of robots in a wrong order, `problems` tells
        return float(np.ceil(mean + SPARE * np.sqrt(mean / self.arrivals.regularity)) + 1)

    def standstills(self) -> tuple[Ints, Floats, Floats]:
        """Robots that stand still, with the begins and ends of their standstills, (D,) each."""
        names = [robot.name for robot in self.robots]
        robots = np.array([down.place(names) for down in self.down], dtype=np.int64)
        return robots, np.array([d.start for d in self.down]), np.array([d.end for d in self.down])


def distinct_cells(cells: Sequence[ConveyorConfig]) -> tuple[list[ConveyorConfig], Ints]:
    """The distinct cells among some cells, in order, and the index of each cell's distinct cell (R,)."""
    texts = [cell.model_dump_json() for cell in cells]
    distinct = list(dict.fromkeys(texts))
    return [cells[texts.index(text)] for text in distinct], np.array([distinct.index(text) for text in texts])


def footprint(cell: ConveyorConfig) -> float:
    """Mean area of the belt that an object covers, as a rectangle [m2]."""
    return float(cell.shares() @ [item.size[0] * item.size[1] for item in cell.item_list()])
