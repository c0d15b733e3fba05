"""Parts, pallets and kinds of throw of the three tasks, as data.

* throw: the block passes a state in the air; nothing stands there. States are drawn from a region, or, where the
  stoppers push the block and no release reaches that region, from a list.
* sort: the block is thrown into one of three pallets, drawn anew for each throw.
* assembly: an H is thrown onto a fixed T, and then a T onto the H.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, Self, final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.one_joint.config import Goal, GoalRegion, Goals, OneJointConfig
from pnt_gym.cells.one_joint.pallets import ASSEMBLY, SORTING, STAND, Pallet, pocket
from pnt_gym.cells.one_joint.parts import Part
from pnt_gym.errors import ConfigError

PUSHED: Final = (
    Goal(name="a", x=0.023, y=0.082, phi_deg=82.0, dy=-0.67),
    Goal(name="b", x=-0.063, y=0.126, phi_deg=105.0, dy=-1.38),
    Goal(name="c", x=-0.020, y=0.110, phi_deg=124.0, dy=-1.27),
    Goal(name="d", x=-0.058, y=0.061, phi_deg=107.0, dy=-1.43),
    Goal(name="e", x=0.055, y=0.176, phi_deg=101.0, dy=0.13),
    Goal(name="f", x=0.304, y=0.103, phi_deg=49.0, dy=0.74),
    Goal(name="g", x=-0.073, y=0.193, phi_deg=105.0, dy=-1.04),
    Goal(name="h", x=0.255, y=0.119, phi_deg=68.0, dy=-0.46),
)
"""Goals of the task `throw` where the stoppers push the block: the first goals above the braked arm for which a seeded
search over simulated releases found a release within 5 mm and 2 deg."""


@final
@dataclass(frozen=True)
class Target:
    """One kind of throw."""

    name: str
    state: Floats
    """Goal x, y [m], phi [rad], dy [m/s] (4,)."""
    part: int
    """Index of the thrown part."""


@final
@dataclass(frozen=True)
class Job:
    """The parts and pallets of a task, and the kinds of throw that occur."""

    parts: tuple[Part, ...]
    pallets: tuple[Pallet, ...]
    targets: tuple[Target, ...]
    """One target per kind; with a region, one target at the region's middle."""
    region: GoalRegion | None = None
    """Region from which goals are drawn; None for the targets themselves."""
    in_order: bool = False
    """Whether the kinds follow each other, each on the result of the previous throw; otherwise kinds are drawn."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the kinds."""
        return tuple(target.name for target in self.targets)

    @classmethod
    def of(cls, config: OneJointConfig) -> Self:
        """Job of a level's task.

        Raises:
            ConfigError: `sort` or `assembly` is given goals, although their pallets are the goals.
        """
        if config.task != "throw" and (config.goals.fixed or config.goals.region is not None):
            raise ConfigError(f"task {config.task!r} throws at its own pallets; leave `goals` empty")
        if config.task == "assembly":
            parts = tuple(part for part, _ in ASSEMBLY)
            targets = tuple(Target(part.name, np.array(goal), k) for k, (part, goal) in enumerate(ASSEMBLY))
            return cls(parts, (STAND,), targets, in_order=True)
        block = config.block
        h, d = block.half_length, block.half_height
        part = Part(
            name="block",
            outline=((-h, -d), (h, -d), (h, d), (-h, d)),
            boxes=((0.0, 0.0, h, d, 0.0),),
            depth=block.depth,
            density=block.mass / (4.0 * h * d * block.depth),
        )
        if config.task == "sort":
            pallets = tuple(replace(pallet, boxes=pocket(part)) for pallet in SORTING)
            return cls((part,), pallets, tuple(Target(p.name, p.state, 0) for p in pallets))
        pushes = config.release == "contact" and config.goals == Goals()
        if fixed := PUSHED if pushes else config.goals.fixed:
            return cls((part,), (), tuple(Target(g.name, g.state(), 0) for g in fixed))
        region = config.goals.region or GoalRegion()
        low, high = region.bounds()
        return cls((part,), (), (Target("goal", 0.5 * (low + high), 0),), region)
