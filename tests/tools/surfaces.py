"""Objects with surfaces for tests and benchmarks: as cells draw them, without a cell."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pnt_gym.arrays import Floats, take
from pnt_gym.cells.base.items import Item
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.cells.grasp.surfaces import SurfaceTable, surface_table

SEEN = tuple(name for name in ConveyorConfig.load("waste").items if name != "cork")
UNSEEN = ConveyorConfig.load("unseen").items


def draw_objects(names: Sequence[str | Item], count: int, seed: int = 0) -> tuple[Objects, SurfaceTable]:
    """Objects (count,) of some items, and the surfaces of these items."""
    own = [item for item in names if isinstance(item, Item)]
    level = {
        "base": "waste",
        "items": [item if isinstance(item, str) else item.name for item in names],
        "extra_items": [item.model_dump(mode="json") for item in own],
    }
    config = ConveyorConfig.load(level)
    objects = take(PickPlanner(config).draw([np.random.default_rng(seed)], np.arange(1), count), 0)
    return objects, surface_table(config.item_list())


def to_world(objects: Objects, x: Floats, y: Floats) -> Floats:
    """Places (N, P, 2) along the world's axes, of places (N, P) in the objects' axes."""
    cos, sin = np.cos(objects.yaw)[:, None], np.sin(objects.yaw)[:, None]
    return np.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)
