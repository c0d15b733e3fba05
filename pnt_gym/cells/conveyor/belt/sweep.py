"""Belts that move on, and the outlines that carried objects sweep through. Compiled; see `pnt_gym.compiled`.

Separating axes: convex outlines are disjoint if their projections on some direction are. For rectangles the directions
of their sides suffice; ellipses are separated along `HEADINGS` more directions.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.base.items import ELLIPSOID
from pnt_gym.cells.conveyor.objects.records import columns_of_objects
from pnt_gym.compiled import compile_for, kernel_part
from pnt_gym.constants import GRAVITY
from pnt_gym.planning.motion.kernel import motion_in, row_at

COLUMN = columns_of_objects()
SHAPE, SIZE, TURN, GAP = (COLUMN[name] for name in ("shape", "size", "yaw", "draws.gap"))
# Depth below its place on the belt at which an object is beside the belt [m].
BESIDE_DEPTH = 0.02
# Number of directions in a half turn; any direction is within 6 degrees of these.
HEADINGS = 16


class Outline(NamedTuple):
    """One outline in top view: an ellipse or a rectangle, its two extents [m] and its yaw [rad]."""

    is_ellipse: bool
    length: float
    width: float
    yaw: float


@kernel_part
def _half_extent(is_ellipse: bool, length: float, width: float, cosine: float, sine: float) -> float:
    """Half extent of an outline along a direction that is turned from its length, as `objects.records.half_extent`."""
    along, across = 0.5 * length * abs(cosine), 0.5 * width * abs(sine)
    return math.sqrt(along * along + across * across) if is_ellipse else along + across


@kernel_part
def _half_length(object_: Floats, cosine: float, sine: float) -> float:
    """Half extent along the belt of an object in a block, by cosine and sine of its yaw."""
    return _half_extent(object_[SHAPE] == ELLIPSOID, object_[SIZE], object_[SIZE + 1], cosine, sine)


@compile_for(
    "void(i8[::1], i8[::1], i8[::1], f8[::1], f8[:, :], f8[::1], f8[::1], b1[::1], i8, f8[:, :, ::1], f8[:, ::1],"
    "b1[:, ::1])"
)
def move_belts(
    rows: Ints,
    picked: Ints,
    gone: Ints,
    way: Floats,
    new: Floats,
    cosine: Floats,
    sine: Floats,
    has_extent: Bools,
    passed: int,
    block: Floats,
    x: Floats,
    knocked: Bools,
) -> None:
    """Move belts on, in place: remove picked objects and the first ones of each belt, and append new objects.

    Args:
        rows: the belts (K,).
        picked: place of the picked object behind the passed places (K,); the last place + 1 for none.
        gone: number of other objects that leave each belt (K,).
        way: way of each belt (K,) [m].
        new: the M new objects, those of one belt after those of the other (M, C).
        cosine: cosines of the yaws of the last object of each belt, then of the new objects (K + M,).
        sine: sines of these yaws (K + M,).
        has_extent: whether gaps begin and end at the edges of these objects, else at their middles (K + M,).
        passed: number of places before the queue.
        block: the objects at all places (N, P, C).
        x: their positions along the belt (N, P) [m].
        knocked: whether each object was knocked (N, P).
    """
    first = 0
    for k in range(len(rows)):
        row, places = rows[k], x.shape[1]
        count = gone[k] + (1 if passed + picked[k] < places else 0)
        kept, position = places - count, x[row, places - 1] + way[k]
        before = _half_length(block[row, places - 1], cosine[k], sine[k]) if has_extent[k] else 0.0
        for place in range(kept):
            old = place + gone[k]
            old += 1 if old >= passed + picked[k] else 0
            block[row, place] = block[row, old]
            x[row, place], knocked[row, place] = x[row, old] + way[k], knocked[row, old]
        distance = 0.0
        for n in range(count):
            block[row, kept + n] = new[first + n]
            object_ = len(rows) + first + n
            half = _half_length(new[first + n], cosine[object_], sine[object_]) if has_extent[object_] else 0.0
            distance += new[first + n, GAP] + before + half
            x[row, kept + n], knocked[row, kept + n], before = position - distance, False, half
        first += count


@compile_for("void(f8[:, :, ::1], f8[:, :], f8[:], f8[::1], f8, f8, f8[:, :, ::1])")
def move_objects(
    table: Floats, pick: Floats, free_at: Floats, times: Floats, flight: float, speed: float, way: Floats
) -> None:
    """Write displacements of N objects under hands, then in flight, from the belt's moving surface.

    Args:
        table: paths of the hands (N, R, COLUMNS), see `planning.motion.kernel.lay_out`.
        pick: positions of the hands at time 0 (N, 3) [m].
        free_at: times of the releases, after which the objects fly without air (N,) [s].
        times: times since the lift (M,) [s].
        flight: longest time after the release; at later times the objects are where they were then [s].
        speed: speed of the belt along x [m/s].
        way: written (N, M, 3) [m].
    """
    for row in range(len(way)):
        place = 0
        for k in range(len(times)):
            held = min(times[k], free_at[row])
            place = row_at(table[row], held, place)
            time = min(times[k], free_at[row] + flight)
            since = time - min(time, free_at[row])
            for axis in range(3):
                position, velocity, _ = motion_in(table[row, place], held, axis)
                way[row, k, axis] = position - pick[row, axis] + since * velocity
            way[row, k, 2] -= 0.5 * GRAVITY * (since * since)
            way[row, k, 0] -= speed * time


@kernel_part
def _overlap_along(first: Outline, second: Outline, x: float, y: float, heading: float) -> bool:
    """Whether the projections of two outlines on a direction overlap, for the distance x, y of their middles [m]."""
    turned = heading - first.yaw
    reach = _half_extent(first.is_ellipse, first.length, first.width, math.cos(turned), math.sin(turned))
    turned = heading - second.yaw
    reach += _half_extent(second.is_ellipse, second.length, second.width, math.cos(turned), math.sin(turned))
    return abs(x * math.cos(heading) + y * math.sin(heading)) < reach


@kernel_part
def _overlap(first: Outline, second: Outline, x: float, y: float) -> bool:
    """Whether two outlines overlap, for the distance x, y of their middles [m]."""
    for yaw in (first.yaw, second.yaw, first.yaw + 0.5 * math.pi, second.yaw + 0.5 * math.pi):
        if not _overlap_along(first, second, x, y, yaw):
            return False
    k = 0
    while k < HEADINGS and _overlap_along(first, second, x, y, k * math.pi / HEADINGS):
        k += 1
    return k == HEADINGS


@kernel_part
def _outer_radius(outline: Outline) -> float:
    """Radius of a circle around an outline [m]."""
    return 0.5 * math.sqrt(outline.length * outline.length + outline.width * outline.width)


@kernel_part
def _meets(carried: Outline, way: Floats, neighbour: Outline, tall: float, x: float, y: float) -> bool:
    """Whether a carried object meets a neighbour on its way (M, 3), at a distance x, y from its begin [m]."""
    reach = _outer_radius(carried) + _outer_radius(neighbour)
    for k in range(len(way)):
        # Most of the time a hand is above all objects.
        if -BESIDE_DEPTH < way[k, 2] < tall:
            east, north = x - way[k, 0], y - way[k, 1]
            if east * east + north * north < reach * reach and _overlap(carried, neighbour, east, north):
                return True
    return False


@compile_for(
    "void(i8[:], f8[:, :], f8[:], f8[:, :], f8[:, :, ::1], i8[:, :], f8[:, :, :], f8[:, :], f8[:, :, :], b1[:, ::1])"
)
def find_sweeps(
    shape: Ints,
    size: Floats,
    yaw: Floats,
    start: Floats,
    way: Floats,
    others_shape: Ints,
    others_size: Floats,
    others_yaw: Floats,
    place: Floats,
    collides: Bools,
) -> None:
    """Write to `collides` (N, K) which of K neighbours each of N carried objects sweeps through.

    Args:
        shape: indices of the carried objects in `items.SHAPES` (N,).
        size: extents of the carried objects (N, 3) [m].
        yaw: yaws of the carried objects (N,) [rad].
        start: middles of the carried objects on the belt (N, 2) [m].
        way: displacements of the carried objects in the belt's frame (N, M, 3) [m].
        others_shape: as `shape`, of the neighbours (N, K).
        others_size: extents of the neighbours (N, K, 3) [m].
        others_yaw: yaws of the neighbours (N, K) [rad].
        place: middles of the neighbours at the lift (N, K, 2) [m].
        collides: overwritten by the result.
    """
    for row in range(len(way)):
        carried = Outline(shape[row] == ELLIPSOID, size[row, 0], size[row, 1], yaw[row])
        for k in range(place.shape[1]):
            extents = others_size[row, k]
            neighbour = Outline(others_shape[row, k] == ELLIPSOID, extents[0], extents[1], others_yaw[row, k])
            x, y = place[row, k, 0] - start[row, 0], place[row, k, 1] - start[row, 1]
            collides[row, k] = _meets(carried, way[row], neighbour, extents[2], x, y)
