"""Config sections of sorting from a belt into bins, without the robot: belt, bins, spread, sensor noise, reward.

The conveyor cell uses them, and the gripper robot's cell can take belt, items and bins from a conveyor level.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self, cast

import numpy as np
from pydantic import Field, model_validator

from pnt_gym.arrays import Bools
from pnt_gym.cells.base.catalogue import ItemsConfig
from pnt_gym.cells.base.config import Finite, Label, NonNegative, Positive, Range, Section, check_ranges
from pnt_gym.cells.base.merging import MergeRules
from pnt_gym.names import BRIEF, list_names, unknown_names


class Belt(Section):
    """The conveyor: a surface that moves along +x, and the stream of objects on it."""

    height: Finite = Field(
        default=-0.90,
        description="z of the belt's surface [m]; an object of 50 mm is then picked at the paper's -0.85.",
    )
    speed: Positive = Field(default=0.25, description="Speed of the surface along +x [m/s].")
    x: Range = Field(default=(-1.4, 0.8), description="Extent of the belt along x [m].")
    y: Range = Field(default=(-0.55, -0.08), description="Extent of the belt along y [m].")
    pick_x: Range = Field(default=(-0.30, 0.30), description="Window in which an object may be picked, along x [m].")
    lane_y: Range = Field(default=(-0.45, -0.20), description="Range across the belt in which objects lie [m].")
    spacing: Range = Field(
        default=(0.02, 0.18),
        description="Gap between consecutive objects along x, drawn uniformly from this range [m].",
    )
    gap: Literal["centre", "edge"] = Field(
        default="edge",
        description="Where `spacing` is measured: between the edges of the objects as they lie, or between their "
        "centres, so that long objects overlap.",
    )
    tracking: bool = Field(
        default=True,
        description="Whether the hand rides with the belt while the cup grips, and throws from there. If not, the "
        "hand stands still and the object slips.",
    )
    neighbours: Literal["ghosts", "solid"] = Field(
        default="solid",
        description="What happens to a neighbour that a carried object sweeps through: nothing (ghosts), or the "
        "neighbour is knocked, rides on and cannot be picked any more (solid). With solid neighbours, "
        "picks that touch no neighbour come first.",
    )
    camera_x: Finite = Field(
        default=-0.80, description="Place of the camera along x, from which the error of the belt's speed grows [m]."
    )

    @model_validator(mode="after")
    def _check(self) -> Self:
        check_ranges(self, "belt", "x", "y", "pick_x", "lane_y", "spacing")
        if self.spacing[0] <= 0:
            raise ValueError(f"belt.spacing starts at {self.spacing[0]}; gaps must be greater than 0 m")
        if not (self.x[0] <= self.pick_x[0] and self.pick_x[1] <= self.x[1]):
            raise ValueError(f"belt.pick_x {self.pick_x} leaves the belt, which spans x {self.x}")
        if not (self.y[0] <= self.lane_y[0] and self.lane_y[1] <= self.y[1]):
            raise ValueError(f"belt.lane_y {self.lane_y} leaves the belt, which spans y {self.y}")
        return self


class Bin(Section):
    """One fixed bin: the centre of its opening and the inner size of the opening."""

    name: Label = Field(description="Name of the bin.")
    x: Finite = Field(description="Centre of the opening along x [m].")
    y: Finite = Field(description="Centre of the opening along y [m].")
    size: tuple[Positive, Positive] = Field(default=(0.22, 0.22), description="Inner opening along x and y [m].")
    accepts: tuple[str, ...] = Field(default=(), description="Items that belong in this bin; empty: every item.")

    def takes(self, item: str) -> bool:
        """Whether an item belongs in the bin."""
        return not self.accepts or item in self.accepts


class RandomBins(Section):
    """One square bin per throw, drawn at random for every throw: a cell with very many bins."""

    x: Range = Field(
        default=(-0.50, 0.50), description="Centre of the opening along x, drawn uniformly from this range [m]."
    )
    y: Range = Field(
        default=(0.25, 0.75), description="Centre of the opening along y, drawn uniformly from this range [m]."
    )
    side: Range = Field(
        default=(0.12, 0.14), description="Inner side of the opening, drawn uniformly from this range [m]."
    )
    item_clearance: NonNegative = Field(
        default=0.0,
        description="Least length by which the opening exceeds the item's longest side [m]; 0 switches the rule off.",
    )

    @model_validator(mode="after")
    def _check(self) -> Self:
        check_ranges(self, "bins.random", "x", "y", "side")
        if self.side[0] <= 0:
            raise ValueError(f"bins.random.side starts at {self.side[0]}; an opening must be wider than 0 m")
        return self


class Bins(Section):
    """The bins: a fixed list, or one random bin per throw."""

    fixed: tuple[Bin, ...] = Field(default=(), description="Fixed bins; exclusive with `random`.")
    random: RandomBins | None = Field(
        default=None, description="One square bin, drawn anew for every throw; exclusive with `fixed`."
    )
    rim: Finite = Field(
        default=-0.85, description="z of the plane of the bins' rims, in which landings are measured [m]."
    )
    depth: Positive = Field(default=0.30, description="Inner depth of the bins below the rim [m].")
    emptied: Annotated[int, Field(ge=1, le=100_000)] | None = Field(
        default=None,
        description="Number of objects after which a bin is emptied. A fixed bin fills up to this number; a bin that "
        "is drawn for a throw holds a random number of objects. null: every throw meets an empty bin. For the "
        "conveyor only.",
    )
    packing: Annotated[float, Field(gt=0, le=1)] = Field(
        default=0.5,
        description="Share of objects (without air) in the volume of a filling; assumed: objects are poured loosely.",
    )
    wall: Annotated[float, Field(ge=0.004, le=0.1)] = Field(
        default=0.010, description="Thickness of the walls [m]; fast objects pass through walls thinner than 4 mm."
    )

    @model_validator(mode="after")
    def _check(self) -> Self:
        if bool(self.fixed) == (self.random is not None):
            raise ValueError("bins needs either a list `fixed` or a section `random`, and not both")
        names = [b.name for b in self.fixed]
        if len(set(names)) != len(names):
            raise ValueError(f"bins.fixed names {names} must differ from one another")
        return self


class Spread(Section):
    """How much throws of one item differ in their hidden values (assumed unless noted)."""

    former: ClassVar[Mapping[str, str]] = {
        "residue_chance": "each item has a mean `residue`, and `spread.residue` is the spread of its logarithm"
    }

    mass: NonNegative = Field(default=0.22, le=1, description="Lognormal spread of the mass.")
    size: NonNegative = Field(
        default=0.08, le=0.5, description="Lognormal spread of the size, common to the three axes."
    )
    size_axis: NonNegative = Field(
        default=0.04, le=0.5, description="Lognormal spread of the size, drawn for each axis."
    )
    drag: NonNegative = Field(default=0.12, le=1, description="Lognormal spread of the drag coefficient.")
    seal: NonNegative = Field(default=0.40, le=5, description="Lognormal spread of the seal force.")
    restitution: NonNegative = Field(
        default=0.35,
        le=1,
        description="Lognormal spread of the restitution of contacts, drawn for each throw, which is at most 1; the "
        "spread scales with the mismatch, for the conveyor only. Single drops of one and the same square fit a spread "
        "of 0.43 (study `reality`, data of `DAIRLab/ImpactModeling`).",
    )
    friction: NonNegative = Field(
        default=0.3,
        le=1,
        description="Lognormal spread of the friction of contacts, drawn for each throw; the spread scales with the "
        "mismatch, for the conveyor only.",
    )
    blow_off: NonNegative = Field(
        default=0.0,
        le=1,
        description="Lognormal spread of the speed `cup.blow_off`, drawn for each throw, for the conveyor only.",
    )
    com_depth: NonNegative = Field(
        default=0.06,
        le=1,
        description="Standard deviation of the depth of the centre of mass, as a share of the object's height.",
    )
    grasp: NonNegative = Field(
        default=0.008,
        le=0.5,
        description="Standard deviation of the cup's place against the centre of mass, per axis [m].",
    )
    height: NonNegative = Field(
        default=0.002,
        le=0.5,
        description="Standard deviation of the height, by the compression of the lip and the error of the camera [m].",
    )
    belt_speed: NonNegative = Field(
        default=0.005, le=1, description="Standard deviation of the relative error of the belt's speed."
    )
    spin: NonNegative = Field(
        default=1.0,
        le=100,
        description="Standard deviation of the spin about x and about y at the release [rad/s]; about z a third of "
        "this.",
    )
    spin_per_offset: NonNegative = Field(
        default=30.0, le=300, description="Spin at the release per metre of grasp offset [rad/s/m]."
    )
    feedforward: NonNegative = Field(
        default=0.10, description="Share of the torque that the motors' feed-forward lacks."
    )
    yaw: NonNegative = Field(
        default=1.5707963267948966, description="Largest yaw of objects on the belt, to both sides [rad]."
    )
    residue: NonNegative = Field(
        default=0.7,
        le=1,
        description="Lognormal spread of the residue about the item's mean. With the mean of 949 milk cartons, 6.6 g, "
        "a lognormal reaches their largest residue of 71.9 g at a spread of 0.85, and their least of 1.0 g at 0.54 "
        "(Belle et al. 2025, BioResources); 0.7 lies in the middle.",
    )


class Noise(Section):
    """Noise of the cell's sensors (one standard deviation)."""

    size: NonNegative = Field(
        default=0.003, description="Standard deviation of each extent that the camera measures [m]."
    )
    mass: NonNegative = Field(default=0.10, description="Relative standard deviation of the measured mass.")
    seal: NonNegative = Field(default=0.10, description="Relative standard deviation of the measured vacuum.")
    yaw: NonNegative = Field(default=0.05, description="Standard deviation of the measured yaw [rad].")
    grasp: NonNegative = Field(
        default=0.004,
        description="Standard deviation of the measured grasp offset, from the outline in the camera and the place "
        "of the cup [m].",
    )


class SortingReward(Section):
    """Weights of the reward's terms, each of which lies in [0, 1]."""

    landing: NonNegative = Field(default=1.0, description="Weight of max(0, 1 - landing error / landing_scale).")
    success: NonNegative = Field(
        default=0.1, description="Weight of the success: the object crossed its opening and lies in its bin."
    )
    time: NonNegative = Field(default=0.1, description="Weight of max(0, 1 - cycle time / time_scale).")
    landing_scale: Positive = Field(default=0.25, description="Landing error at which the landing term reaches 0 [m].")
    time_scale: Positive = Field(default=3.0, description="Cycle time at which the time term reaches 0 [s].")


class SortingLine(ItemsConfig):
    """Abstract: the part of a level that describes belt, items, bins and sensors."""

    folder: ClassVar[str | Path] = "conveyor"
    rules: ClassVar[MergeRules] = MergeRules(alternatives={"bins": ("fixed", "random")})

    items: tuple[str, ...] = Field(
        default=("paper", "metal_can", "plastic_package"),
        min_length=1,
        description="Names of the items on the belt; see the catalogue of items.",
    )
    belt: Belt = Belt()
    bins: Bins = Field(description="The bins: a list `fixed`, or a section `random`.")
    spread: Spread = Spread()
    noise: Noise = Noise()

    @classmethod
    def merge(cls, below: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
        """Differences `above` merged into the values `below`; of the items added below those that still come stay."""
        merged = super().merge(below, above)
        entries, items = merged.get("extra_items"), merged.get("items")
        if "items" in above and "extra_items" not in above and isinstance(entries, list) and isinstance(items, list):
            merged["extra_items"] = [
                entry
                for entry in cast("list[Any]", entries)
                if (
                    cast("Mapping[str, Any]", entry).get("name")
                    if isinstance(entry, Mapping)
                    else getattr(entry, "name", None)
                )
                in items
            ]
        return merged

    def problems(self) -> Iterator[str]:
        """A sentence for each problem of values that are possible alone, and not together."""
        yield from super().problems()
        if unused := [item.name for item in self.extra_items if item.name not in self.items]:
            verb, pronoun = ("is", "it") if len(unused) == 1 else ("are", "them")
            yield f"extra_items: {list_names(unused)} {verb} not in `items`, {self.items}; name {pronoun} there"
        yield from self._wrong_acceptance()
        yield from self.bin_place_problems()

    def bin_place_problems(self) -> Iterator[str]:
        """What is wrong with the places of the bins: on the belt, or on each other."""
        wall = self.bins.wall
        if self.bins.random is not None:
            r, reach = self.bins.random, self.bins.random.side[1] / 2 + wall
            yield from self._on_belt("bins.random", (r.x[0] - reach, r.x[1] + reach), (r.y[0] - reach, r.y[1] + reach))
        for i, b in enumerate(self.bins.fixed):
            x, y = b.size[0] / 2 + wall, b.size[1] / 2 + wall
            yield from self._on_belt(f"bin {b.name!r}", (b.x - x, b.x + x), (b.y - y, b.y + y))
            for neighbour in self.bins.fixed[:i]:
                along, across = _overlap(b, neighbour, wall)
                if min(along, across) > 1e-9:
                    x, y = (b.x + neighbour.x) / 2.0, (b.y + neighbour.y) / 2.0
                    yield (
                        f"bin {b.name!r} overlaps bin {neighbour.name!r} by {1000.0 * along:.0f} mm along the belt and "
                        f"{1000.0 * across:.0f} mm across, around x {x:.2f} m, y {y:.2f} m; move one of them"
                    )

    @property
    def has_clear_items(self) -> bool:
        """Whether all items are defined and all added items come; else other complaints about items only repeat it."""
        items, extra = set(self.items), {item.name for item in self.extra_items}
        return extra <= items <= set(self.item_definitions())

    def strangers(self, where: str, names: Iterable[str]) -> Iterator[str]:
        """A clause on items that a part of the level names, and that do not come."""
        if self.has_clear_items and (unknown := [name for name in names if name not in self.items]):
            yield f"{where}: {unknown_names('item', unknown, self.items, room=BRIEF)}"

    def _wrong_acceptance(self) -> Iterator[str]:
        """Items that a bin accepts and that do not come, and items that come and that no bin accepts."""
        if not self.has_clear_items:
            return
        for b in self.bins.fixed:
            yield from self.strangers(f"bin {b.name!r}", b.accepts)
        if self.bins.fixed and all(b.accepts for b in self.bins.fixed):
            accepted = {name for b in self.bins.fixed for name in b.accepts}
            if homeless := [name for name in self.items if name not in accepted]:
                items, pronoun = ("item", "it") if len(homeless) == 1 else ("items", "them")
                yield (
                    f"no bin accepts {items} {list_names(homeless)}; add {pronoun} to a bin or leave one bin's "
                    "`accepts` empty"
                )

    def acceptance(self) -> Bools:
        """Whether each fixed bin (columns) accepts each item (rows)."""
        fixed = self.bins.fixed
        return np.array([[b.takes(name) for b in fixed] for name in self.items], dtype=np.bool_)

    def _on_belt(self, label: str, x: Range, y: Range) -> Iterator[str]:
        belt = self.belt
        if x[0] < belt.x[1] and belt.x[0] < x[1] and y[0] < belt.y[1] and belt.y[0] < y[1]:
            yield (
                f"{label} spans y {y[0]:.3f}..{y[1]:.3f} m and lies on the belt, "
                f"which spans y {belt.y[0]}..{belt.y[1]} m; move it off the belt"
            )


def _overlap(a: Bin, b: Bin, wall: float) -> tuple[float, float]:
    """Lengths along x and y by which two bins overlap, negative for a gap [m]; neighbours may share a wall."""
    return (
        (a.size[0] + b.size[0]) / 2 + wall - abs(a.x - b.x),
        (a.size[1] + b.size[1]) / 2 + wall - abs(a.y - b.y),
    )
