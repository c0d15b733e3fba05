"""The belt, the waste and the bins of a conveyor cell, as the gripper robot's cell describes them.

The robot hangs beside the conveyor cell's origin, turned by a quarter: its x axis is the conveyor's y axis, across the
belt towards the bins, and its y axis is the conveyor's -x axis, against the belt's travel. The claws close along the
belt, so that they centre an object that is a little early or late.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final, final

import numpy as np
from pydantic import Field

from pnt_gym.cells.items import Item
from pnt_gym.config import CellConfig, load
from pnt_gym.errors import ConfigError
from pnt_gym.sections import Finite, NonNegative, Range, Section

_TRAVEL: Final = -90.0
"""Direction of the belt's travel, from the robot's x axis [deg]."""


@final
class Conveyor(Section):
    """Whose belt the robot sorts on, and where it hangs there.

    What a section of the gripper robot's cell says itself goes before what the conveyor cell says.
    """

    level: str = Field(default="nominal", description="Level of the conveyor cell: a shipped one's name, or a file.")
    origin: tuple[Finite, Finite, Finite] = Field(
        description="The robot's origin, amid its motor axes, in the conveyor cell's frame [m]."
    )
    items: tuple[str, ...] = Field(default=(), description="Kinds that are picked; empty for those of the level.")
    delay: Mapping[str, NonNegative] = Field(
        default_factory=dict, description="`delay` of the things that items become, 0 when not named [s]."
    )
    pick_x: Range | None = Field(
        default=None, description="Where along the belt the grip may begin; null for the conveyor's own window [m]."
    )

    def sections(self) -> dict[str, dict[str, Any]]:
        """What the conveyor cell says of `table`, `tray` and `errors`.

        Raises:
            ConfigError: no such level.
        """
        cell = load(self.level)
        return {"table": self._table(cell), "tray": self._tray(cell), "errors": _errors(cell)}

    def things(self) -> tuple[dict[str, Any], ...]:
        """The conveyor cell's items as things; they lie with their first axis across the belt.

        Raises:
            ConfigError: no such level or item.
        """
        items = self._items(load(self.level))
        for name in self.delay:
            if name not in (item.name for item in items):
                raise ConfigError(f"conveyor.delay names {name!r}; picked are {', '.join(i.name for i in items)}")
        return tuple(self._thing(item) for item in items)

    def _items(self, cell: CellConfig) -> tuple[Item, ...]:
        known = cell.item_definitions()
        for name in self.items:
            if name not in known:
                raise ConfigError(f"conveyor.items: unknown item {name!r}; known are {', '.join(sorted(known))}")
        return tuple(known[name] for name in self.items or cell.items)

    def _thing(self, item: Item) -> dict[str, Any]:
        same = item.model_dump(include={"name", "shape", "size", "mass", "friction", "drag"})
        return same | {"delay": self.delay.get(item.name, 0.0)}

    def _table(self, cell: CellConfig) -> dict[str, Any]:
        belt, (x, y, z) = cell.belt, self.origin
        window = belt.pick_x if self.pick_x is None else self.pick_x
        return {
            "height": belt.height - z,
            "x": (belt.y[0] - y, belt.y[1] - y),
            "y": (x - belt.x[1], x - belt.x[0]),
            "pick_x": (belt.lane_y[0] - y, belt.lane_y[1] - y),
            "pick_y": (x - window[1], x - window[0]),
            "speed": belt.speed,
            "travel_deg": _TRAVEL,
            "camera": belt.camera_x - x,
        }

    def _tray(self, cell: CellConfig) -> dict[str, Any]:
        """Compartments of the size of the largest bin, turned like the robot."""
        bins, longest = cell.bins, max(max(item.size) for item in self._items(cell))
        if bins.random is None:
            side = max(b.size[1] for b in bins.fixed), max(b.size[0] for b in bins.fixed)
        else:
            largest = max(bins.random.side[1], longest + bins.random.item_clearance)
            side = largest, largest
        return {"rim": bins.rim - self.origin[2], "depth": bins.depth, "opening": side, "wall": bins.wall}


def _errors(cell: CellConfig) -> dict[str, float]:
    """How much the conveyor's objects differ and what its camera misses."""
    spread, noise = cell.spread, cell.noise
    return {
        "width": float(np.hypot(spread.size, spread.size_axis)),
        "mass": spread.mass,
        "drag": spread.drag,
        "placement": noise.grasp,
        "yaw_deg": float(np.rad2deg(noise.yaw)),
        "camera": noise.size,
        "belt_speed": spread.belt_speed,
        "feedforward": spread.feedforward,
    }
