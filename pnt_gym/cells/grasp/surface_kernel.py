"""Surfaces of objects from their keys, and height and leak at points of surfaces. Compiled; see `pnt_gym.compiled`.

Points are in an object's own axes: x along its length, y across, from the middle of its outline [m].
"""

from __future__ import annotations

import math
from typing import Any

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.items import CYLINDER, ELLIPSOID
from pnt_gym.cells.base.zones import MOST_ZONES
from pnt_gym.cells.grasp.random_kernel import uniform
from pnt_gym.cells.grasp.rows import WAVES, Surfaces, SurfaceTable
from pnt_gym.compiled import kernel, kernel_part
from pnt_gym.rows import Ints1, Keys1

RECT, DISC, BOWL = range(3)
GRAY_SPREAD = 0.08
"""Largest deviation of an object's brightness from that of its item; assumed."""
LOWEST = 0.001
"""Lowest height of a surface above the belt, below any relief [m]."""
# Numbers of draws in an object's stream: ends, sides, brightness; three a wave; three a zone.
U_END, U_SIDE, U_GRAY, U_WAVES = 0, 1, 2, 3
U_ZONES = U_WAVES + 3 * WAVES


@kernel_part
def _place(at: float, extent: float, spread: float, draw: float) -> float:
    """Middle of a zone in shares of a half extent of the item: as near its place as the zone stays on the item."""
    room = max(1.0 - extent, 0.0)
    return min(max(at + spread * (2.0 * draw - 1.0), -room), room)


@kernel_part
def _draw_zone(item: Any, size: Floats, x: float, y: float, lighter: float, zone: Any) -> None:
    """Write a zone of an object with extents `size`, with its middle at shares x, y of the half extents."""
    length, width = size[0] / 2.0, size[1] / 2.0
    zone.shape, zone.middle[0], zone.middle[1] = item.shape, x * length, y * width
    zone.half[0], zone.half[1] = item.size[0] * length, item.size[1] * width
    zone.depth, zone.leak, zone.relief = item.depth, item.leak, item.relief
    zone.ribs, zone.rib_number = item.ribs, 2.0 * math.pi / item.rib_length
    for part in range(4):
        zone.look[part] = item.look[part]
    if item.look[0] >= 0.0:
        zone.look[0] = min(max(item.look[0] + lighter, 0.0), 1.0)


@kernel
def draw_surfaces(kind: Ints1, keys: Keys1, table: SurfaceTable, surfaces: Surfaces) -> None:
    """Draw the surfaces of N objects.

    Args:
        kind: items of the objects (N,).
        keys: keys of the objects' draws (N,).
        table: the surfaces of the items.
        surfaces: the objects' shapes, extents and yaws, and zones of zeros; the rest is written.
    """
    for row in range(len(kind)):
        key, item, body = keys[row], table.items[kind[row]], surfaces.bodies[row]
        end = 1.0 if uniform(key, U_END) < 0.5 else -1.0
        side = 1.0 if uniform(key, U_SIDE) < 0.5 else -1.0
        lighter = GRAY_SPREAD * (2.0 * uniform(key, U_GRAY) - 1.0)
        body.relief = item.relief
        for part in range(4):
            body.look[part] = item.look[part]
        body.look[0] = min(max(item.look[0] + lighter, 0.0), 1.0)
        # Directions, lengths (0.7 to 1.4 times the wavelength) and phases of the waves.
        for wave in range(WAVES):
            heading = math.pi * (wave + uniform(key, U_WAVES + 3 * wave)) / WAVES
            number = 2.0 * math.pi / (item.wavelength * (0.7 + 0.7 * uniform(key, U_WAVES + 3 * wave + 1)))
            body.wave_x[wave], body.wave_y[wave] = number * math.cos(heading), number * math.sin(heading)
            body.phase[wave] = 2.0 * math.pi * uniform(key, U_WAVES + 3 * wave + 2)
        along = end * item.com * body.size[0]
        body.com[0], body.com[1] = along * math.cos(body.yaw), along * math.sin(body.yaw)
        count = 0
        for number in range(MOST_ZONES):
            zone, first = table.zones[kind[row], number], U_ZONES + 3 * number
            if zone.shape >= 0 and uniform(key, first) < zone.chance:
                x = end * _place(zone.at[0], zone.size[0], zone.spread, uniform(key, first + 1))
                y = side * _place(zone.at[1], zone.size[1], zone.spread, uniform(key, first + 2))
                _draw_zone(zone, body.size, x, y, lighter, surfaces.zones[row, count])
                count += 1
        body.count = count if item.is_real else -1


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
def _depth_inside(zone: Any, x: float, y: float) -> float:
    """How deep a point is in a zone, as a share of the zone's depth; -1 outside of the zone."""
    p, q = (x - zone.middle[0]) / zone.half[0], (y - zone.middle[1]) / zone.half[1]
    if zone.shape == RECT:
        return 1.0 if abs(p) <= 1.0 and abs(q) <= 1.0 else -1.0
    inside = 1.0 - p * p - q * q
    if inside < 0.0:
        return -1.0
    return inside if zone.shape == BOWL else 1.0


@kernel_part
def surface_point(surfaces: Surfaces, row: int, x: float, y: float) -> tuple[float, float, int]:
    """Height above the belt [m] (-1 beside the object) and leak at a point, and the zone that gives the look or -1.

    The point lies at x, y in the axes of the object of a row.
    """
    body = surfaces.bodies[row]
    height = base_height(body.shape, body.size, x, y)
    if height < 0.0 or body.count < 0:
        return height, 1.0, -1
    relief, leak, look, ribs, rib_number = body.relief, 1.0, -1, 0.0, 0.0
    for number in range(body.count):
        zone = surfaces.zones[row, number]
        # Zones lie one over the other: depths add up, and of the rest a zone sets only what it names.
        share = _depth_inside(zone, x, y)
        if share >= 0.0:
            height -= share * zone.depth
            leak = zone.leak if zone.leak >= 0.0 else leak
            relief = zone.relief if zone.relief >= 0.0 else relief
            look = number if zone.look[0] >= 0.0 else look
            if zone.ribs >= 0.0:
                ribs, rib_number = zone.ribs, zone.rib_number
    if relief > 0.0:
        total = 0.0
        for wave in range(WAVES):
            total += math.sin(body.wave_x[wave] * x + body.wave_y[wave] * y + body.phase[wave])
        # The relief's variance does not depend on the number of waves.
        height += relief * total / math.sqrt(WAVES)
    if ribs > 0.0:
        height += ribs * math.sin(rib_number * x + body.phase[0])
    return max(height, LOWEST), leak, look
