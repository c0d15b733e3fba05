"""The objects on N belts: positions, which may still be picked, how new objects arrive, and which a carried one meets.

In top view each object is its footprint on the belt, turned by its yaw. In the belt's frame the other objects rest and
the carried object moves, held or in flight. The carried object meets an object whose top is higher than the carried
object's underside while the footprints overlap.
"""

from __future__ import annotations

from typing import Final, TypeAlias, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, concatenate_records, in_order, join_columns, take
from pnt_gym.cells.base.cell import Generators
from pnt_gym.cells.conveyor.belt import sweep
from pnt_gym.cells.conveyor.movers.straight import ThrowMotion
from pnt_gym.cells.conveyor.objects.records import Measured, Objects
from pnt_gym.cells.conveyor.planner import PickPlanner

PASSED_PLACES: Final = 8
"""Number of stored objects per belt that are not picked any more; carried objects may still sweep through them."""
AWAY: Final = 1e3
"""Position of places without an object on the belt [m]."""
CHECK_INTERVAL: Final = 0.004
"""Interval between two checks for collisions [s]; a hand moves 10 mm in this time."""
CHECK_AFTER_RELEASE: Final = 0.30
"""Time after the release in which collisions are checked, while objects may still be over the belt [s]."""
Footprints: TypeAlias = Objects | Measured
"""Objects with true or with measured shapes, sizes and yaws."""


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
        ride = sweep.Ride(*in_order(rows, picked, gone, way))
        belts = sweep.Belts(stored.rows, stored.fill, self.x, self.knocked)
        newcomers = sweep.Newcomers(*in_order(new.rows, new.fill, np.cos(yaw), np.sin(yaw), has_extent))
        sweep.move_belts(ride, newcomers, PASSED_PLACES, belts)
        self.objects = Objects(stored.rows, stored.fill)


def course(motion: ThrowMotion, free_at: Floats, speed: float) -> Floats:
    """Displacements of carried objects from their places on the belt, in the belt's frame (N, M, 3) [m].

    Args:
        motion: motion of the hands.
        free_at: times of the releases, after which the objects fly without air (N,) [s].
        speed: speed of the belt [m/s].
    """
    times = np.arange(0.0, float(free_at.max(initial=0.0)) + CHECK_AFTER_RELEASE, CHECK_INTERVAL)
    inputs = in_order(motion.path.table, motion.pick, free_at, times)
    return sweep.course(*inputs, CHECK_AFTER_RELEASE, speed)


def sweeps_through(carried: Footprints, start: Floats, way: Floats, neighbours: Footprints, place: Floats) -> Bools:
    """Whether each of N carried objects sweeps through each of K others (N, K).

    Args:
        carried: the N carried objects.
        start: middles of the carried objects on the belt (N, 2) [m].
        way: displacements of the carried objects in the belt's frame (N, M, 3) [m].
        neighbours: the other objects (N, K).
        place: middles of the other objects at the lift (N, K, 2) [m].
    """
    outlines = sweep.Carried(*in_order(carried.shape, carried.size, carried.yaw, start, way))
    others = sweep.Neighbours(*in_order(neighbours.shape, neighbours.size, neighbours.yaw, place))
    return sweep.sweeps_through(outlines, others)
