"""Surfaces of objects from their keys, and height and leak at points of surfaces. Compiled; see `pnt_gym.compiled`.

Points are in an object's own axes: x along its length, y across, from the middle of its outline [m].
"""

from __future__ import annotations

import math
from typing import NamedTuple

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.items import CYLINDER, ELLIPSOID
from pnt_gym.cells.base.zones import MOST_ZONES
from pnt_gym.cells.grasp.random_kernel import uniform
from pnt_gym.compiled import kernel, kernel_part
from pnt_gym.rows import Floats1, Floats2, Floats3, Ints1, Keys1

RECT, DISC, BOWL = range(3)
WAVES = 5
"""Plane waves of a relief."""
# Columns of an object's surface: number of zones (-1 for an object without a surface, on which every cup seals);
# amplitude of the relief; brightness, warmth, gloss and texture; wave vectors and phases.
COUNT, RELIEF, LOOK = 0, 1, 2
KX, KY, PHASE = 6, 6 + WAVES, 6 + 2 * WAVES
BODY_COLUMNS = 6 + 3 * WAVES
# Columns of a zone: shape, middle and half extents [m]; depth; leak, relief and brightness (-1: as around the zone);
# amplitude and wave number of the ribs; the rest of the look.
SHAPE, X, Y, A, B, DEPTH, LEAK, ZONE_RELIEF, RIBS, RIB_K, ZONE_LOOK = range(11)
ZONE_COLUMNS = 15
# Columns of an item: whether it has a surface, relief, wavelength, look, centre of mass.
I_IS_REAL, I_RELIEF, I_WAVELENGTH, I_LOOK, I_COM = 0, 1, 2, 3, 7
ITEM_COLUMNS = 8
# Columns of an item's zone: shape (-1: no zone), place, size, chance, depth, leak, relief, ribs, look, spread.
(Z_SHAPE, Z_X, Z_Y, Z_LENGTH, Z_WIDTH, Z_CHANCE, Z_DEPTH, Z_LEAK, Z_RELIEF, Z_RIBS, Z_RIB_LENGTH, Z_LOOK) = range(12)
Z_SPREAD = Z_LOOK + 4
ITEM_ZONE_COLUMNS = Z_SPREAD + 1
GRAY_SPREAD = 0.08
"""Largest deviation of an object's brightness from that of its item; assumed."""
LOWEST = 0.001
"""Lowest height of a surface above the belt, below any relief [m]."""
# Numbers of draws in an object's stream: ends, sides, brightness; three a wave; three a zone.
U_END, U_SIDE, U_GRAY, U_WAVES = 0, 1, 2, 3
U_ZONES = U_WAVES + 3 * WAVES


class SurfaceRows(NamedTuple):
    """Bodies of N objects with their surfaces."""

    shape: Ints1
    """Shapes (N,)."""
    size: Floats2
    """Extents (N, 3) [m]."""
    yaw: Floats1
    """Yaws (N,) [rad]."""
    body: Floats2
    """Relief, look and waves (N, BODY_COLUMNS)."""
    zones: Floats3
    """Zones (N, MOST_ZONES, ZONE_COLUMNS)."""


@kernel_part
def _place(at: float, extent: float, spread: float, draw: float) -> float:
    """Middle of a zone in shares of a half extent of the item: as near its place as the zone stays on the item."""
    room = max(1.0 - extent, 0.0)
    return min(max(at + spread * (2.0 * draw - 1.0), -room), room)


@kernel_part
def _write_zone(item: Floats, length: float, width: float, x: float, y: float, lighter: float, zone: Floats) -> None:
    """Write a zone of an object with half extents `length` and `width`, with its middle at shares x, y of these."""
    zone[SHAPE], zone[X], zone[Y] = item[Z_SHAPE], x * length, y * width
    zone[A], zone[B] = item[Z_LENGTH] * length, item[Z_WIDTH] * width
    zone[DEPTH], zone[LEAK], zone[ZONE_RELIEF] = item[Z_DEPTH], item[Z_LEAK], item[Z_RELIEF]
    zone[RIBS], zone[RIB_K] = item[Z_RIBS], 2.0 * math.pi / item[Z_RIB_LENGTH]
    for part in range(4):
        zone[ZONE_LOOK + part] = item[Z_LOOK + part]
    if item[Z_LOOK] >= 0.0:
        zone[ZONE_LOOK] = min(max(item[Z_LOOK] + lighter, 0.0), 1.0)


@kernel
def draw_rows(
    kind: Ints1, keys: Keys1, items: Floats2, item_zones: Floats3, surfaces: SurfaceRows, com: Floats2
) -> None:
    """Draw the surfaces of N objects.

    Args:
        kind: items of the objects (N,).
        keys: keys of the objects' draws (N,).
        items: the items (K, ITEM_COLUMNS).
        item_zones: their zones (K, MOST_ZONES, ITEM_ZONE_COLUMNS).
        surfaces: bodies and zones are written; the zones that an object has come first.
        com: written with the centre of mass from the middle of the outline, along the world's axes (N, 2) [m].
    """
    size, yaw, body, zones = surfaces.size, surfaces.yaw, surfaces.body, surfaces.zones
    for row in range(len(kind)):
        key, item, length, width = keys[row], items[kind[row]], size[row, 0] / 2.0, size[row, 1] / 2.0
        end = 1.0 if uniform(key, U_END) < 0.5 else -1.0
        side = 1.0 if uniform(key, U_SIDE) < 0.5 else -1.0
        lighter = GRAY_SPREAD * (2.0 * uniform(key, U_GRAY) - 1.0)
        body[row, RELIEF] = item[I_RELIEF]
        for part in range(4):
            body[row, LOOK + part] = item[I_LOOK + part]
        body[row, LOOK] = min(max(item[I_LOOK] + lighter, 0.0), 1.0)
        # Directions, lengths (0.7 to 1.4 times the wavelength) and phases of the waves.
        for wave in range(WAVES):
            heading = math.pi * (wave + uniform(key, U_WAVES + 3 * wave)) / WAVES
            rate = 2.0 * math.pi / (item[I_WAVELENGTH] * (0.7 + 0.7 * uniform(key, U_WAVES + 3 * wave + 1)))
            body[row, KX + wave], body[row, KY + wave] = rate * math.cos(heading), rate * math.sin(heading)
            body[row, PHASE + wave] = 2.0 * math.pi * uniform(key, U_WAVES + 3 * wave + 2)
        along = end * item[I_COM] * size[row, 0]
        com[row, 0], com[row, 1] = along * math.cos(yaw[row]), along * math.sin(yaw[row])
        count = 0
        zones[row] = 0.0
        for number in range(MOST_ZONES):
            zone, first = item_zones[kind[row], number], U_ZONES + 3 * number
            if zone[Z_SHAPE] >= 0.0 and uniform(key, first) < zone[Z_CHANCE]:
                x = end * _place(zone[Z_X], zone[Z_LENGTH], zone[Z_SPREAD], uniform(key, first + 1))
                y = side * _place(zone[Z_Y], zone[Z_WIDTH], zone[Z_SPREAD], uniform(key, first + 2))
                _write_zone(zone, length, width, x, y, lighter, zones[row, count])
                count += 1
        body[row, COUNT] = count if item[I_IS_REAL] > 0.0 else -1.0


@kernel_part
def base_height(shape: int, size: Floats, x: float, y: float) -> float:
    """Height above the belt of the upper face of a body without a surface; -1 beside the body [m]."""
    p, q = 2.0 * x / size[0], 2.0 * y / size[1]
    if shape == ELLIPSOID:
        inside = 1.0 - p * p - q * q
        return size[2] / 2.0 * (1.0 + math.sqrt(inside)) if inside >= 0.0 else -1.0
    if abs(p) > 1.0 or abs(q) > 1.0:
        return -1.0
    return size[2] / 2.0 * (1.0 + math.sqrt(1.0 - q * q)) if shape == CYLINDER else size[2]


@kernel_part
def _depth_inside(zone: Floats, x: float, y: float) -> float:
    """How deep a point is in a zone, as a share of the zone's depth; -1 outside of the zone."""
    p, q = (x - zone[X]) / zone[A], (y - zone[Y]) / zone[B]
    if zone[SHAPE] == RECT:
        return 1.0 if abs(p) <= 1.0 and abs(q) <= 1.0 else -1.0
    inside = 1.0 - p * p - q * q
    if inside < 0.0:
        return -1.0
    return inside if zone[SHAPE] == BOWL else 1.0


@kernel_part
def surface_point(surfaces: SurfaceRows, row: int, x: float, y: float) -> tuple[float, float, int]:
    """Height above the belt [m] (-1 beside the object) and leak at a point, and the zone that gives the look or -1.

    The point lies at x, y in the axes of the object of a row.
    """
    body, zones = surfaces.body[row], surfaces.zones[row]
    height = base_height(surfaces.shape[row], surfaces.size[row], x, y)
    if height < 0.0 or body[COUNT] < 0.0:
        return height, 1.0, -1
    relief, leak, look, ribs, rib_number = body[RELIEF], 1.0, -1, 0.0, 0.0
    for number in range(int(body[COUNT])):
        zone = zones[number]
        share = _depth_inside(zone, x, y)
        if share >= 0.0:
            height -= share * zone[DEPTH]
            leak = zone[LEAK] if zone[LEAK] >= 0.0 else leak
            relief = zone[ZONE_RELIEF] if zone[ZONE_RELIEF] >= 0.0 else relief
            look = number if zone[ZONE_LOOK] >= 0.0 else look
            if zone[RIBS] >= 0.0:
                ribs, rib_number = zone[RIBS], zone[RIB_K]
    if relief > 0.0:
        total = 0.0
        for wave in range(WAVES):
            total += math.sin(body[KX + wave] * x + body[KY + wave] * y + body[PHASE + wave])
        height += relief * total / math.sqrt(WAVES)
    if ribs > 0.0:
        height += ribs * math.sin(rib_number * x + body[PHASE])
    return max(height, LOWEST), leak, look
