"""A pick as it stands before the throw: object, pick, target, limits and the nominal plan."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple, Self, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.base.sorting import Belt
from pnt_gym.cells.conveyor.objects.records import Measured, Objects
from pnt_gym.planning.motion.limits import LimitRows
from pnt_gym.planning.straight.plan import ReleaseBatch


@final
class Drifted(NamedTuple):
    """What is off in N cells at a pick, and no sensor tells."""

    delay: Floats
    """Release later by this than the object alone explains (N,) [s]."""
    camera: Floats
    """Objects are off by this from where the camera takes them to be, along x, y (N, 2) [m]."""
    encoder: Floats
    """Relative error of the belt speed that nothing measures (N,)."""
    draught: Floats
    """Velocity of the air along x, y (N, 2) [m/s]."""

    @classmethod
    def nothing(cls, count: int) -> Self:
        """Cells as they were on the day they were set up."""
        return cls(np.zeros(count), np.zeros((count, 2)), np.zeros(count), np.zeros((count, 2)))


@final
class Before(NamedTuple):
    """What N cells know of the throws before, of the same shift."""

    seen: Bools
    """The bin's camera saw the landing (N,)."""
    error: Floats
    """What it says of the landing against the target, along and left of that throw; 0 where unseen (N, 2) [m]."""
    shift: Floats
    """Where that throw was sent against its nominal plan, drag-free, in the same frame (N, 2) [m]."""
    direction: Floats
    """Horizontal unit vector of that throw (N, 2); 0 where there is none."""
    gone: Floats
    """Share of the shift that is over (N,)."""

    @classmethod
    def nothing(cls, count: int) -> Self:
        """A shift begins."""
        nowhere = np.zeros((count, 2))
        return cls(np.zeros(count, dtype=np.bool_), nowhere, nowhere.copy(), nowhere.copy(), np.zeros(count))


@final
@dataclass(frozen=True)
class Context:
    """N picks, each with the object under the cup.

    Positions are of the planner's point mass. At mismatch 1 that is the cup tip, at 0 the centre of mass.
    """

    objects: Objects
    pick: Floats
    """(N, 3) [m]"""
    target: Floats
    """Centre of the opening at the rim plane, (N, 3) [m]."""
    opening: Floats
    """Inner size of the opening along x and y, (N, 2) [m]."""
    bin: Ints
    """Index of the fixed bin, or 0 where the bin is drawn per throw, (N,)."""
    depth: Floats
    """Of all fixed bins, or of the one that is drawn per throw, above what lies in them (N, B) [m]."""
    limits: LimitRows
    """Of the hand, by each object's own speed setting."""
    throw_limits: LimitRows
    """The same for the way to the release and on until the hand stops, where the grip may ask for less."""
    plan: ReleaseBatch
    """The analytic planner's release: object as a point at the cup."""
    belt_speed: float
    ceiling: Floats
    """Highest release z of the nominal plan (N,) [m]."""
    belt_shift: Floats
    """Grasp offset along x that the belt-speed error adds (N,) [m]."""
    drift: Drifted
    """What has changed since the cell was set up."""
    unseen: Floats
    """Grasp offset that the drift adds, which no sensor tells (N, 2) [m]."""
    before: Before
    """What is known of the throws before."""

    @classmethod
    def new(
        cls,
        objects: Objects,
        pick: Floats,
        target: Floats,
        opening: Floats,
        index: Ints,
        depth: Floats,
        *,
        throw_limits: LimitRows,
        plan: ReleaseBatch,
        ceiling: Floats,
        belt: Belt,
    ) -> Context:
        """Picks of cells that have not drifted, and that know of no throw before."""
        nothing = np.zeros((len(pick), 2))
        return cls(
            objects=objects,
            pick=pick,
            target=target,
            opening=opening,
            bin=index,
            depth=depth,
            limits=LimitRows.t3kr(objects.percent),
            throw_limits=throw_limits,
            plan=plan,
            belt_speed=belt.speed,
            ceiling=ceiling,
            belt_shift=belt_shift(objects, pick, belt),
            drift=Drifted.nothing(len(pick)),
            unseen=nothing,
            before=Before.nothing(len(pick)),
        )

    @property
    def kind(self) -> Ints:
        """What the cell's classifier says of each object: index into its items (N,)."""
        return self.objects.measured.kind

    @cached_property
    def bin_depth(self) -> Floats:
        """Depth of each throw's bin (N,) [m]."""
        return self.depth[np.arange(len(self.bin)), self.bin]

    @cached_property
    def direction(self) -> Floats:
        """Horizontal unit vector from pick to target (N, 2)."""
        delta = self.target[:, :2] - self.pick[:, :2]
        return delta / self.distance[:, None]

    @cached_property
    def distance(self) -> Floats:
        """Horizontal distance from pick to target (N,) [m]."""
        delta = self.target[:, :2] - self.pick[:, :2]
        return np.sqrt(delta[:, 0] ** 2 + delta[:, 1] ** 2)

    @cached_property
    def relative_yaw(self) -> Floats:
        """Measured yaw of the object from the throw's heading (N,) [rad]."""
        return self.measured.yaw - np.arctan2(self.direction[:, 1], self.direction[:, 0])

    @cached_property
    def visible_grasp(self) -> Floats:
        """What the sensors could tell of the grasp, but for their noise (N, 2) [m]."""
        return self.objects.grasp + np.stack([self.belt_shift, np.zeros_like(self.belt_shift)], axis=-1)

    @cached_property
    def grasp(self) -> Floats:
        """True centre of mass from the cup axis along x, y (N, 2) [m]."""
        return self.visible_grasp + self.unseen

    @cached_property
    def cup_offset(self) -> Floats:
        """Cup tip from the planner's point (N, 3) [m]."""
        zero = np.zeros_like(self.objects.known_depth)
        return np.stack([zero, zero, self.objects.known_depth], axis=-1)

    @property
    def measured(self) -> Measured:
        """What the sensors say of the objects."""
        return self.objects.measured

    @cached_property
    def measured_grasp(self) -> Floats:
        """What they say of the centre of mass from the cup axis along world x, y (N, 2) [m]."""
        return self.visible_grasp + self.measured.grasp_noise

    def expected(self) -> Context:
        """The same picks without what differs from throw to throw of one object."""
        objects = self.objects
        held = np.ones_like(objects.pick_draw)
        return replace(self, objects=replace(objects, delay=objects.delay - objects.jitter, pick_draw=held))

    def lost(self, rows: Bools) -> Context:
        """The same picks, of which some are lost (N,): nothing sets those spinning."""
        objects = self.objects
        return replace(self, objects=replace(objects, spin=np.where(rows[:, None], 0.0, objects.spin)))

    def to_throw_frame(self, vector: Floats) -> tuple[Floats, Floats]:
        """Horizontal vectors (N, 2+) as components along the throw and to its left, each (N,)."""
        ex, ey = self.direction[:, 0], self.direction[:, 1]
        return vector[:, 0] * ex + vector[:, 1] * ey, vector[:, 1] * ex - vector[:, 0] * ey

    def from_throw_frame(self, along: Floats, across: Floats) -> Floats:
        """Level vectors (N, 3) given along and left of the throw, in the world."""
        ex, ey = self.direction[:, 0], self.direction[:, 1]
        return np.stack([along * ex - across * ey, along * ey + across * ex, np.zeros_like(ex)], axis=-1)


def belt_shift(objects: Objects, pick: Floats, belt: Belt) -> Floats:
    """Grasp offset along x that the belt-speed error adds to objects at picks (N, 3): (N,) [m]."""
    return objects.belt_error * (pick[:, 0] - belt.camera_x)
