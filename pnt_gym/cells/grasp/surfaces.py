"""Surfaces of objects: height, leak and look at every point, and how a suction cup seals at a place.

An object's surface is a pure function of the object: a hash of the object's own draws is the key of the surface's
draws. So surfaces need no generator and are never stored, and one object has one surface, alone or in a batch.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final, NamedTuple, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, Ints, in_order
from pnt_gym.cells.base.items import Item
from pnt_gym.cells.base.zones import MOST_ZONES, ZONE_SHAPES, Look
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.cells.grasp import random_kernel, seal_kernel, surface_kernel
from pnt_gym.cells.grasp.config import GraspConfig, Surface
from pnt_gym.cells.grasp.rows import ItemSurface, ItemZone, SurfaceBody, Surfaces, SurfaceTable, SurfaceZone
from pnt_gym.constants import GRAVITY

Keys = NDArray[np.uint64]
SURFACE, IMAGE, TRY = 1, 2, 3
"""Purposes of an object's keys; the streams of different purposes are independent."""
_SMOOTH: Final = (0.0, 0.05)
"""Relief of an item without one: no amplitude, and any wavelength."""
_AS_AROUND: Final[Look] = (-1.0, 0.0, 0.0, 0.0)


@final
class Seals(NamedTuple):
    """Seals of cups at places."""

    force: Floats
    """Force of the vacuum F0 (N, P) [N]."""
    leak: Floats
    """Leak under the cup in multiples of that of the item's own surface (N, P)."""


def surface_table(items: Sequence[Item]) -> SurfaceTable:
    """The surfaces of items as arrays."""
    rows = [
        (bool(item.zones) or item.relief is not None, *(item.relief or _SMOOTH), item.look, item.com) for item in items
    ]
    zones = ItemZone.zeros(len(items), MOST_ZONES, shape=-1)
    for own, item in zip(zones, items, strict=True):
        for row, zone in enumerate(item.zones):
            # -1 where the zone is as the surface around it.
            leak, relief = (-1.0 if value is None else value for value in (zone.leak, zone.relief))
            own[row] = (
                ZONE_SHAPES.index(zone.shape), zone.at, zone.size, zone.chance, zone.depth, leak, relief,
                *(zone.ribs or (-1.0, 1.0)), zone.look or _AS_AROUND, zone.spread,
            )  # fmt: skip
    surfaces: Any = np.array(rows, dtype=ItemSurface.dtype)
    return SurfaceTable(surfaces, zones)


def object_keys(objects: Objects, purpose: int) -> Keys:
    """Keys S of objects for a purpose: hashes of the objects' draws."""
    place = objects.draws.place
    bits = np.ascontiguousarray(place).reshape(-1, place.shape[-1]).view(np.uint64)
    keys = np.empty(len(bits), dtype=np.uint64)
    random_kernel.hash_rows(bits, np.uint64(purpose), keys)
    return keys.reshape(place.shape[:-1])


def later_keys(keys: Keys, number: Ints | int) -> Keys:
    """Keys of the draws that belong to numbers, as those of tries; keys and numbers are broadcast."""
    pairs = np.stack(np.broadcast_arrays(keys, np.asarray(number, dtype=np.uint64)), axis=-1)
    later = np.empty(pairs.size // 2, dtype=np.uint64)
    random_kernel.hash_rows(pairs.reshape(-1, 2), np.uint64(0), later)
    return later.reshape(pairs.shape[:-1])


def normal_draw(keys: Keys) -> Floats:
    """A standard normal draw of each key."""
    normals = np.empty(keys.size)
    random_kernel.normal_draw(np.ascontiguousarray(keys).reshape(-1), normals)
    return normals.reshape(keys.shape)


def outline_errors(objects: Objects, config: GraspConfig) -> Floats:
    """True middles of N outlines from the places at which the camera sees them (N, 2) [m]; 0 without surfaces."""
    if config.surface is None:
        return np.zeros((len(objects.kind), 2))
    keys = object_keys(objects, IMAGE)
    draws = np.stack([normal_draw(later_keys(keys, axis + 1)) for axis in range(2)], axis=-1)
    return config.camera.outline * draws


def draw_surfaces(table: SurfaceTable, objects: Objects) -> Surfaces:
    """The surfaces of objects of any leading shape."""
    shape = objects.kind.shape
    bodies = SurfaceBody.zeros(*shape, shape=objects.shape, size=objects.size, yaw=objects.yaw)
    surfaces = Surfaces(bodies, SurfaceZone.zeros(*shape, MOST_ZONES))
    keys = object_keys(objects, SURFACE).reshape(-1)
    surface_kernel.draw_surfaces(objects.kind.reshape(-1), keys, table, surfaces.flat())
    return surfaces


def seal_at(surfaces: Surfaces, objects: Objects, places: Floats) -> Seals:
    """Seals of cups at places of N objects.

    Args:
        surfaces: surfaces of the objects.
        objects: N objects; `seal` is the force on the item's own surface.
        places: axes of the cups from the middles of the outlines, along the world's axes (N, P, 2) [m].
    """
    force, leak = (np.empty(places.shape[:2]) for _ in range(2))
    seal_kernel.seal_at(surfaces, *in_order(objects.seal, objects.cup_radius, places), force, leak)
    return Seals(force, leak)


def least_force(objects: Objects, surface: Surface) -> Floats:
    """Least force of a seal that holds its object (N,) [N]: the gauge must report a vacuum, and the seal carry more."""
    area = np.pi * objects.cup_radius**2
    return np.maximum(surface.pressure * area, surface.weights * objects.mass * GRAVITY)


def seal_holds(force: Floats, objects: Objects, draw: Floats, surface: Surface) -> Bools:
    """Whether cups hold their objects.

    Args:
        force: forces of the seals, (N,) or (N, P) [N].
        objects: N objects.
        draw: standard normal draws of the tries, like `force`.
        surface: the level's rules.
    """
    least = least_force(objects, surface)
    return force * np.exp(surface.spread * draw) >= (least if force.ndim == 1 else least[:, None])
