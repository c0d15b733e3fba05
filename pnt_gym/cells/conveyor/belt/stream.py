"""The objects on N belts: positions, which may still be picked, how new objects arrive, and which a carried one meets.

In top view each object is its footprint on the belt, turned by its yaw. In the belt's frame the other objects rest and
the carried object moves, held or in flight. The carried object meets an object whose top is higher than the carried
object's underside while the footprints overlap.

Separating axes: convex outlines are disjoint if their projections on some direction are. For rectangles the directions
of their sides suffice; ellipses are separated along `HEADINGS` more directions.
"""

from __future__ import annotations

import math
from typing import Any, Final, NamedTuple, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, concatenate_records, in_order, join_columns, take
from pnt_gym.cells.base.cell import Generators
from pnt_gym.cells.base.items import ELLIPSOID
from pnt_gym.cells.conveyor.objects.records import Objects, outline_reach
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.compiled import kernel, kernel_part
from pnt_gym.constants import GRAVITY
from pnt_gym.planning.motion.kernel import motion_in, row_at
from pnt_gym.planning.motion.rows import Knot
from pnt_gym.rows import Bools1, Bools2, Floats1, Floats2, Floats3, Ints1, Ints2, Rows1, Rows2

PASSED_PLACES: Final = 8
"""Number of stored objects per belt that are not picked any more; carried objects may still sweep through them."""
AWAY: Final = 1e3
"""Position of places without an object on the belt [m]."""
CHECK_INTERVAL = 0.004
"""Interval between two checks for collisions [s]; a hand moves 10 mm in this time."""
CHECK_AFTER_RELEASE = 0.30
"""Time after the release in which collisions are checked, while objects may still be over the belt [s]."""
BESIDE_DEPTH = 0.02
"""Depth below its place on the belt at which an object is beside the belt [m]."""
HEADINGS = 16
"""Number of directions in a half turn; any direction is within 6 degrees of these."""


class Ride(NamedTuple):
    """How K belts move on."""

    rows: Ints1
    """The belts (K,)."""
    picked: Ints1
    """Place of the picked object behind the passed places (K,); the last place + 1 for none."""
    gone: Ints1
    """Number of other objects that leave each belt (K,)."""
    way: Floats1
    """Way of each belt (K,) [m]."""


class Newcomers(NamedTuple):
    """M new objects on K belts."""

    objects: Rows1[Objects]
    """The objects, those of one belt after those of the other (M,)."""
    fill: Floats2
    """The objects' draws of the content of each bin (M, B)."""
    cosine: Floats1
    """Cosines of the yaws of the last object of each belt, then of the new objects (K + M,)."""
    sine: Floats1
    """Sines of these yaws (K + M,)."""
    has_extent: Bools1
    """Whether gaps begin and end at the edges of these objects, else at their middles (K + M,)."""


class Belts(NamedTuple):
    """Objects on N belts, at P places each."""

    objects: Rows2[Objects]
    """The objects (N, P)."""
    fill: Floats3
    """Their draws of the content of each bin (N, P, B)."""
    x: Floats2
    """Their positions along the belt (N, P) [m]."""
    knocked: Bools2
    """Whether each object was knocked (N, P)."""


class Carried(NamedTuple):
    """N objects that hands carry."""

    shape: Ints1
    """Indices in `items.SHAPES` (N,)."""
    size: Floats2
    """Extents (N, 3) [m]."""
    yaw: Floats1
    """Yaws (N,) [rad]."""
    start: Floats2
    """Picks (N, 3), which are above the objects' middles [m]."""
    way: Floats3
    """Displacements in the belt's frame (N, M, 3) [m]."""


class Neighbours(NamedTuple):
    """K neighbours of each of N carried objects."""

    shape: Ints2
    """Indices in `items.SHAPES` (N, K)."""
    size: Floats3
    """Extents (N, K, 3) [m]."""
    yaw: Floats2
    """Yaws (N, K) [rad]."""
    place: Floats3
    """Middles at the lift (N, K, 2) [m]."""


@final
class BeltStream:
    """The objects on N belts, in rows from the most downstream object to the most upstream.

    The first `PASSED_PLACES` places of a row are objects that are not picked any more. The other places are the queue:
    objects that may be picked in any order. With gaps from edge to edge a row's objects and gaps depend only on the
    row's generator, and not on the picks.

    Args:
        planner: draws the objects.
        generators: one generator per belt.
        length: number Q of objects in a queue.
    """

    def __init__(self, planner: PickPlanner, generators: Generators, length: int) -> None:
        self._planner = planner
        self._generators = generators
        self._belt = planner.config.belt
        self.length = length
        places = len(generators), PASSED_PLACES + length
        placeholder = planner.draw([np.random.default_rng(0)], np.zeros(1, dtype=np.int64), 1)
        self.objects: Objects = take(placeholder, (np.zeros(places, dtype=np.int64), 0))
        """All stored objects (N, PASSED_PLACES + Q)."""
        self.x: Floats = np.full(places, AWAY)
        """Positions of the objects along the belt at the lift of the present pick (N, PASSED_PLACES + Q) [m]."""
        self.knocked: Bools = np.zeros(places, dtype=np.bool_)
        """Which objects a carried object swept through, and cannot be picked any more (N, PASSED_PLACES + Q)."""

    @property
    def queue(self) -> Objects:
        """Objects that may be picked, the most downstream first (N, Q)."""
        return take(self.objects, np.s_[:, np.arange(PASSED_PLACES, PASSED_PLACES + self.length)])

    @property
    def queue_x(self) -> Floats:
        """Positions of the queue's objects along the belt (N, Q) [m]."""
        return self.x[:, PASSED_PLACES:]

    def places(self, rows: Ints) -> Floats:
        """Positions x, y of all stored objects on some belts (K, PASSED_PLACES + Q, 2) [m]."""
        return join_columns(self.x[rows], self.objects.draws.lane_y[rows])

    def begin(self, rows: Ints) -> None:
        """Start new streams in some rows; the first object enters the window one gap after the episode begins."""
        self.x[rows, -1] = self._belt.pick_x[0]
        whole = np.full(len(rows), self.length)
        self.ride(rows, whole, whole, np.zeros(len(rows)), is_empty=True)
        self.x[rows, :PASSED_PLACES], self.knocked[rows] = AWAY, False

    def in_queue(self, rows: Ints, places: Ints) -> tuple[Objects, Floats]:
        """Objects (K,) at places of the queues of some rows (K,), and their positions along the belt (K,) [m]."""
        return take(self.objects, (rows, PASSED_PLACES + places)), self.x[rows, PASSED_PLACES + places]

    def ride(self, rows: Ints, picked: Ints, gone: Ints, way: Floats, is_empty: bool = False) -> None:
        """Move belts on, remove picked objects, and append new objects.

        Args:
            rows: the belts (K,).
            picked: place in the queue of the picked object (K,); Q for none.
            gone: number of other objects, from the front of the queue, that leave unpicked (K,).
            way: ways of the belts (K,) [m].
            is_empty: on an empty belt the first object comes behind the last place.
        """
        stored, counts, draw = self.objects, gone + (picked < self.length), self._planner.draw
        if self._belt.gap == "centre":
            drawn = [draw(self._generators, rows[[k]], count) for k, count in enumerate(counts.tolist())]
            new = take(concatenate_records(drawn, axis=1), 0)
        else:
            # One by one, so that the number of objects in a call does not change the draws.
            new = take(draw(self._generators, np.repeat(rows, counts), 1), np.s_[:, 0])
        yaw = np.concatenate([stored.rows["yaw"][rows, -1], new.yaw])
        has_extent = np.full(len(yaw), self._belt.gap == "edge")
        has_extent[: len(rows)] &= not is_empty
        ride = Ride(*in_order(rows, picked, gone, way))
        belts = Belts(stored.rows, stored.fill, self.x, self.knocked)
        newcomers = Newcomers(*in_order(new.rows, new.fill, np.cos(yaw), np.sin(yaw), has_extent))
        move_belts(ride, newcomers, PASSED_PLACES, belts)
        self.objects = Objects(stored.rows, stored.fill)


class Outline(NamedTuple):
    """One outline in top view: an ellipse or a rectangle, its two extents [m] and its yaw [rad]."""

    is_ellipse: bool
    length: float
    width: float
    yaw: float


_half_extent: Final[Any] = kernel_part(outline_reach)
"""Half extent of one outline."""


@kernel_part
def _half_length(object_: Any, cosine: float, sine: float) -> float:
    """Half extent along the belt of an object, by cosine and sine of its yaw."""
    return _half_extent(object_.shape == ELLIPSOID, object_.size[0], object_.size[1], cosine, sine)


@kernel
def move_belts(ride: Ride, new: Newcomers, passed: int, belts: Belts) -> None:
    """Move belts on, in place: remove picked objects and the first ones of each belt, and append new objects.

    `passed` is the number of places before the queue.
    """
    objects, fill, x, knocked = belts
    first = 0
    for k in range(len(ride.rows)):
        row, picked, gone, way, places = ride.rows[k], passed + ride.picked[k], ride.gone[k], ride.way[k], x.shape[1]
        count = gone + (1 if picked < places else 0)
        kept, position = places - count, x[row, places - 1] + way
        before = _half_length(objects[row, places - 1], new.cosine[k], new.sine[k]) if new.has_extent[k] else 0.0
        # Objects that stay close the gaps of those that left, and move with the belt.
        for place in range(kept):
            old = place + gone
            old += 1 if old >= picked else 0
            objects[row, place], fill[row, place] = objects[row, old], fill[row, old]
            x[row, place], knocked[row, place] = x[row, old] + way, knocked[row, old]
        # New objects lie upstream, one behind the other, each a gap behind the one before.
        distance = 0.0
        for n in range(count):
            newcomer, last = new.objects[first + n], len(ride.rows) + first + n
            objects[row, kept + n], fill[row, kept + n] = newcomer, new.fill[first + n]
            half = _half_length(newcomer, new.cosine[last], new.sine[last]) if new.has_extent[last] else 0.0
            distance += newcomer.draws.gap + before + half
            x[row, kept + n], knocked[row, kept + n], before = position - distance, False, half
        first += count


@kernel
def course(table: Rows2[Knot], pick: Floats2, free_at: Floats1, speed: float) -> Floats3:
    """Displacements of N objects under hands, then in flight, from the belt's moving surface (N, M, 3) [m].

    Args:
        table: paths of the hands (N, R), see `planning.motion.kernel.lay_out`.
        pick: positions of the hands at time 0 (N, 3) [m].
        free_at: times of the releases, after which the objects fly without air (N,) [s].
        speed: speed of the belt along x [m/s].
    """
    last = 0.0
    for row in range(len(free_at)):
        last = max(last, free_at[row])
    moments = math.ceil((last + CHECK_AFTER_RELEASE) / CHECK_INTERVAL)
    way, hand = np.empty((len(free_at), moments, 3)), np.empty((2, 3))
    for row in range(len(way)):
        place, held = 0, -math.inf
        for k in range(moments):
            if held < free_at[row]:  # then the object flies on from where the hand was
                held = min(k * CHECK_INTERVAL, free_at[row])
                place = row_at(table[row], held, place)
                for axis in range(3):
                    hand[0, axis], hand[1, axis], _ = motion_in(table[row, place], held, axis)
            # Long after the release the object is where it was at the end of the checks.
            time = min(k * CHECK_INTERVAL, free_at[row] + CHECK_AFTER_RELEASE)
            since = time - min(time, free_at[row])
            for axis in range(3):
                way[row, k, axis] = hand[0, axis] - pick[row, axis] + since * hand[1, axis]
            way[row, k, 2] -= 0.5 * GRAVITY * (since * since)
            way[row, k, 0] -= speed * time
    return way


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


@kernel
def sweeps_through(carried: Carried, others: Neighbours) -> Bools2:
    """Whether each of N carried objects sweeps through each of K others on its way (N, K)."""
    count, around = others.shape.shape
    collides = np.zeros((count, around), np.bool_)
    for row in range(count):
        size, start, way = carried.size[row], carried.start[row], carried.way[row]
        outline = Outline(carried.shape[row] == ELLIPSOID, size[0], size[1], carried.yaw[row])
        for k in range(around):
            size, place = others.size[row, k], others.place[row, k]
            neighbour, tall = Outline(others.shape[row, k] == ELLIPSOID, size[0], size[1], others.yaw[row, k]), size[2]
            reach = _outer_radius(outline) + _outer_radius(neighbour)
            for moment in range(len(way)):
                # Most of the time a hand is above all objects.
                if -BESIDE_DEPTH < way[moment, 2] < tall:
                    x, y = place[0] - start[0] - way[moment, 0], place[1] - start[1] - way[moment, 1]
                    if x * x + y * y < reach * reach and _overlap(outline, neighbour, x, y):
                        collides[row, k] = True
                        break
    return collides
