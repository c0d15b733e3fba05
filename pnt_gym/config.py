"""Every number that describes a conveyor cell, once, with its unit and its reason.

A level is a YAML file that holds only differences from these defaults: `load("waste")` reads one of the
shipped levels, `load("my_cell.yaml")` a user's own. Unknown keys and impossible values raise `ConfigError`.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from pnt_gym import levels
from pnt_gym.cells.items import CATALOGUE, Item
from pnt_gym.errors import ConfigError
from pnt_gym.sections import (
    ActionScale,
    Belt,
    Bin,
    Bins,
    FollowThrough,
    Limits,
    Motion,
    Noise,
    RandomBins,
    Range,
    Reward,
    Section,
    Spread,
    Suction,
)

__all__ = [
    "ActionScale",
    "Belt",
    "Bin",
    "Bins",
    "CellConfig",
    "ConfigError",
    "FollowThrough",
    "Limits",
    "Motion",
    "Noise",
    "RandomBins",
    "Reward",
    "Section",
    "Spread",
    "Suction",
    "level_names",
    "load",
]


class CellConfig(Section):
    """A conveyor cell. The defaults are the level `nominal` without its bins."""

    name: str = Field(default="custom", min_length=1)
    mismatch: Annotated[float, Field(ge=0, le=3)] = Field(
        default=1.0,
        description="The dial m: 0 is the planner's own world, 1 is realistic; scales every unmodelled effect.",
    )
    timestep: Annotated[float, Field(ge=0.0001, le=0.002)] = Field(
        default=0.001,
        description="Physics step [s]; 1 ms for training, 0.4 ms for evaluation, above 2 ms the loops drift.",
    )
    items: tuple[str, ...] = Field(default=("paper", "metal_can", "plastic_package"), min_length=1)
    extra_items: tuple[Item, ...] = Field(default=(), description="A user's own items, usable in `items` by name.")
    limits: Limits = Limits()
    belt: Belt = Belt()
    bins: Bins
    motion: Motion = Motion()
    suction: Suction = Suction()
    spread: Spread = Spread()
    noise: Noise = Noise()
    action: ActionScale = ActionScale()
    reward: Reward = Reward()
    planner: Literal["straight", "free_direction"] = Field(
        default="straight",
        description="How the throw is planned: on a straight line (Hassan 2022), or with a free release direction.",
    )
    picks_per_shift: Annotated[int, Field(ge=1)] = Field(default=50, description="Episode length of PnTConveyor-v0.")

    @model_validator(mode="after")
    def _check(self) -> Self:
        known = self.item_definitions()
        for name in self.items:
            if name not in known:
                raise ValueError(f"items: unknown item {name!r}; known are {', '.join(sorted(known))}")
        self._check_bins()
        return self

    def item_definitions(self) -> Mapping[str, Item]:
        """The catalogue together with this cell's own items, by name."""
        return {**CATALOGUE, **{item.name: item for item in self.extra_items}}

    def item_list(self) -> tuple[Item, ...]:
        """The items that occur in this cell, in the order of `items`."""
        known = self.item_definitions()
        return tuple(known[name] for name in self.items)

    def _check_bins(self) -> None:
        wall = self.bins.wall
        if self.bins.random is not None:
            r = self.bins.random
            reach = (r.side[1] / 2 + wall, r.side[1] / 2 + wall)
            self._check_off_belt(
                "bins.random", (r.x[0] - reach[0], r.x[1] + reach[0]), r.y[0] - reach[1], r.y[1] + reach[1]
            )
        for i, b in enumerate(self.bins.fixed):
            half = (b.size[0] / 2 + wall, b.size[1] / 2 + wall)
            self._check_off_belt(f"bin {b.name!r}", (b.x - half[0], b.x + half[0]), b.y - half[1], b.y + half[1])
            for other in self.bins.fixed[:i]:
                if _overlap(b, other, wall):
                    raise ValueError(f"bin {b.name!r} overlaps bin {other.name!r}; move one of them")
            for item in b.accepts:
                if item not in self.items:
                    raise ValueError(f"bin {b.name!r} accepts {item!r}, which is not among the items {self.items}")
        if self.bins.fixed and all(b.accepts for b in self.bins.fixed):
            for name in self.items:
                if not any(name in b.accepts for b in self.bins.fixed):
                    raise ValueError(
                        f"no bin accepts item {name!r}; add it to a bin or leave one bin's `accepts` empty"
                    )

    def _check_off_belt(self, what: str, x: Range, y_low: float, y_high: float) -> None:
        belt = self.belt
        if x[0] < belt.x[1] and belt.x[0] < x[1] and y_low < belt.y[1] and belt.y[0] < y_high:
            raise ValueError(
                f"{what} spans y {y_low:.3f}..{y_high:.3f} m and lies on the belt, "
                f"which spans y {belt.y[0]}..{belt.y[1]} m; move it off the belt"
            )


def _overlap(a: Bin, b: Bin, wall: float) -> bool:
    """Whether two bins stand in each other; neighbours may share a wall."""
    return (
        abs(a.x - b.x) < (a.size[0] + b.size[0]) / 2 + wall - 1e-9
        and abs(a.y - b.y) < (a.size[1] + b.size[1]) / 2 + wall - 1e-9
    )


def level_names() -> tuple[str, ...]:
    """Names of the conveyor's shipped levels."""
    return levels.level_names()


def load(level: str | Path | CellConfig | Mapping[str, Any] = "nominal", **changes: Any) -> CellConfig:
    """A cell from a shipped level's name, a YAML file, a mapping or a config.

    Args:
        level: "nominal", a path to a YAML file, a mapping in the file's form, or a config as it is.
        changes: top-level values that replace those of the level, e.g. `mismatch=0.5`.

    Raises:
        ConfigError: no such level or file, unknown key, or a value out of its range.
    """
    return levels.read_level("", CellConfig, level, changes)
