"""Objects with surfaces for tests and benchmarks: as cells draw them, without a cell."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pnt_gym.arrays import Floats, take
from pnt_gym.cells.base.items import CYLINDER, ELLIPSOID, Item
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.cells.grasp.rows import Surfaces, SurfaceTable
from pnt_gym.cells.grasp.surfaces import surface_table

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


def height_and_leak(
    objects: Objects, surfaces: Surfaces, row: int | tuple[int, ...], x: Floats, y: Floats
) -> tuple[Floats, Floats]:
    """Height above the belt [m], -1 beside the object, and leak of one object at places S in its axes, by NumPy alone.

    The height is the body's, less the depth of the zones, with the bumps and the ribs of the last zone; so is the leak.
    """
    (length, width, tall), shape, body = objects.size[row], objects.shape[row], surfaces.bodies[row]
    p, q = 2.0 * x / length, 2.0 * y / width
    if shape == ELLIPSOID:
        inside, height = p**2 + q**2 <= 1.0, tall / 2.0 * (1.0 + np.sqrt(np.maximum(1.0 - p**2 - q**2, 0.0)))
    else:
        inside = (np.abs(p) <= 1.0) & (np.abs(q) <= 1.0)
        round_height = tall / 2.0 * (1.0 + np.sqrt(np.maximum(1.0 - q**2, 0.0)))
        height = round_height if shape == CYLINDER else np.full(x.shape, tall)
    leak, relief, ribs = np.ones(x.shape), np.full(x.shape, body["relief"]), np.zeros(x.shape)
    for zone in surfaces.zones[row][: max(body["count"], 0)]:
        kind, (middle_x, middle_y), (a, b), depth, zone_leak, bumps, rib, number, _ = zone
        u, v = (x - middle_x) / a, (y - middle_y) / b
        within = (np.abs(u) <= 1.0) & (np.abs(v) <= 1.0) if kind == 0 else u**2 + v**2 <= 1.0
        height = height - np.where(within, depth * (1.0 - u**2 - v**2 if kind == 2 else 1.0), 0.0)
        leak = np.where(within & (zone_leak >= 0.0), zone_leak, leak)
        relief = np.where(within & (bumps >= 0.0), bumps, relief)
        ribs = np.where(within & (rib >= 0.0), rib * np.sin(number * x + body["phase"][0]), ribs)
    waves = np.sin(x[..., None] * body["wave_x"] + y[..., None] * body["wave_y"] + body["phase"]).sum(axis=-1)
    height = np.maximum(height + relief * waves / np.sqrt(5.0) + ribs, 0.001) if body["count"] >= 0 else height
    return np.where(inside, height, -1.0), np.where(inside, leak, 1.0)
