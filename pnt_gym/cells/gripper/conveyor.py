"""Belt, waste and bins of a conveyor cell, as values of the gripper robot's cell.

The robot hangs beside the conveyor cell's origin, turned by a quarter: its x axis is the conveyor's y axis, across the
belt towards the bins, and its y axis is the conveyor's -x axis, against the belt's travel. The claws close along the
belt, so that they centre an object that is a little early or late.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final, final

import numpy as np
from pydantic import ConfigDict, Field

from pnt_gym.cells.base.config import Finite, Range, Section
from pnt_gym.cells.base.sorting import SortingLine

_TRAVEL: Final = -90.0
"""Direction of the belt's travel, from the robot's x axis [deg]."""


@final
class ConveyorSite(SortingLine):
    """A conveyor cell without its robot: the other entries of its level are ignored."""

    model_config = ConfigDict(frozen=True, extra="ignore")


@final
class Conveyor(Section):
    """Conveyor cell on whose belt the robot sorts, and the robot's place there.

    Values that a section of the gripper robot's cell sets itself take precedence over the conveyor cell's.
    """

    level: str = Field(
        default="nominal",
        description="Level of the conveyor cell: a shipped level's name, or a file. Drift of the level is left out.",
    )
    origin: tuple[Finite, Finite, Finite] = Field(
        description="Origin of this robot, amid its motor axes, in the frame of the conveyor cell [m]."
    )
    pick_x: Range | None = Field(
        default=None,
        description="Range along the belt in which the grip may begin; null for the window of the conveyor cell [m].",
    )

    def sections(self, site: ConveyorSite, items: Sequence[str]) -> dict[str, dict[str, Any]]:
        """Sections `table`, `tray` and `errors` from the conveyor cell, for a robot that picks some of its items."""
        picked = [item for name, item in site.item_definitions().items() if name in items] or site.item_list()
        # Compartments of the size of the largest bin, for items up to a length [m], turned like the robot.
        longest = max(max(item.size) for item in picked)
        bins = site.bins
        if bins.random is None:
            side = max(b.size[1] for b in bins.fixed), max(b.size[0] for b in bins.fixed)
        else:
            largest = max(bins.random.side[1], longest + bins.random.item_clearance)
            side = largest, largest
        tray = {"rim": bins.rim - self.origin[2], "depth": bins.depth, "opening": side, "wall": bins.wall}
        spread, noise = site.spread, site.noise
        errors = {
            "width": float(np.hypot(spread.size, spread.size_axis)),
            "mass": spread.mass,
            "drag": spread.drag,
            "placement": noise.grasp,
            "yaw_deg": float(np.rad2deg(noise.yaw)),
            "camera": noise.size,
            "belt_speed": spread.belt_speed,
            "feedforward": spread.feedforward,
        }
        return {"table": self._table(site), "tray": tray, "errors": errors}

    def _table(self, cell: SortingLine) -> dict[str, Any]:
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
