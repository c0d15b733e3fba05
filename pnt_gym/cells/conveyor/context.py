"""Picks before their throws: object, pick point, target, limits and nominal plan."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import NamedTuple, Self, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, in_order, join_columns
from pnt_gym.cells.base.rotations import turn_back
from pnt_gym.cells.base.sorting import Belt
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.objects import kernel
from pnt_gym.cells.conveyor.objects.drawing import spin_at_grasp
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.planning.motion.limits import LimitRows
from pnt_gym.planning.straight.plan import ReleaseBatch
from pnt_gym.records import Record, computed


@final
class HiddenDrift(NamedTuple):
    """Hidden drift of N cells at a pick, which no sensor measures."""

    delay: Floats
    """Release delay beyond that of the object (N,) [s]."""
    camera: Floats
    """True position of an object minus the camera's, along x, y (N, 2) [m]."""
    encoder: Floats
    """True belt speed over the encoder's, minus 1 (N,)."""
    draught: Floats
    """Velocity of the air along x, y (N, 2) [m/s]."""

    @classmethod
    @cache
    def zero(cls, count: int) -> Self:
        """No drift in `count` cells; nobody overwrites its arrays."""
        return cls(np.zeros(count), np.zeros((count, 2)), np.zeros(count), np.zeros((count, 2)))


@final
class LastThrow(NamedTuple):
    """Measurements of the previous throws of N cells, in the same shift of picks."""

    seen: Bools
    """Whether the bin's camera saw the landing (N,)."""
    error: Floats
    """Measured landing minus target, along and left of the previous throw; 0 where unseen (N, 2) [m]."""
    shift: Floats
    """Offset of the previous throw's landing from its nominal plan, without drag, in the same frame (N, 2) [m]."""
    direction: Floats
    """Horizontal unit vector of the previous throw (N, 2); 0 before the first throw."""
    gone: Floats
    """Share of the shift that is over (N,)."""

    @classmethod
    @cache
    def none(cls, count: int) -> Self:
        """No previous throw in `count` cells: their shifts begin; nobody overwrites its arrays."""
        nowhere = np.zeros((count, 2))
        return cls(np.zeros(count, dtype=np.bool_), nowhere, nowhere.copy(), nowhere.copy(), np.zeros(count))


@final
@dataclass(frozen=True)
class Context(Record):
    """N picks, each with the object under the cup.

    Positions are those of the planner's point mass: the cup tip at mismatch 1, the centre of mass at mismatch 0.
    """

    objects: Objects
    pick: Floats
    """Position of the pick (N, 3) [m]."""
    target: Floats
    """Centre of the opening at the rim plane, (N, 3) [m]."""
    opening: Floats
    """Inner size of the opening along x and y, (N, 2) [m]."""
    bin: Ints
    """Index of the fixed bin, or 0 where the bin is drawn per throw, (N,)."""
    depth: Floats
    """Free depth above the content of all fixed bins, or of the one that is drawn per throw (N, B) [m]."""
    limits: LimitRows
    """Limits of the hand, by each object's speed setting."""
    throw_limits: LimitRows
    """Limits of the hand from the pick until it stops after the release; lower where a grip needs less acceleration."""
    plan: ReleaseBatch
    """The analytic planner's release, with the object as a point at the cup."""
    belt_speed: float
    ceiling: Floats
    """Highest release z of the nominal plan (N,) [m]."""
    belt_shift: Floats
    """Grasp offset along x that the belt-speed error adds (N,) [m]."""
    drift: HiddenDrift
    """Hidden drift of the cells."""
    unseen: Floats
    """Grasp offset that the drift adds, which no sensor measures (N, 2) [m]."""
    before: LastThrow
    """Measurements of the previous throws."""
    spent: Floats
    """Time of failed tries to grasp the same objects, which counts as part of the cycles (N,) [s]."""

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
        """Picks of cells without drift and without a previous throw."""
        no_offset = np.zeros((len(pick), 2))
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
            drift=HiddenDrift.zero(len(pick)),
            unseen=no_offset,
            before=LastThrow.none(len(pick)),
            spent=np.zeros(len(pick)),
        )

    @property
    def kind(self) -> Ints:
        """Item that the classifier sees in each object: index into the cell's items (N,)."""
        return self.objects.measured.kind

    @computed
    def bin_depth(self) -> Floats:
        """Depth of each throw's bin (N,) [m]."""
        return self.depth[np.arange(len(self.bin)), self.bin]

    @computed
    def direction(self) -> Floats:
        """Horizontal unit vector from pick to target (N, 2)."""
        delta = self.target[:, :2] - self.pick[:, :2]
        return delta / self.distance[:, None]

    @computed
    def distance(self) -> Floats:
        """Horizontal distance from pick to target (N,) [m]."""
        delta = self.target[:, :2] - self.pick[:, :2]
        return np.sqrt(delta[:, 0] ** 2 + delta[:, 1] ** 2)

    @computed
    def relative_yaw(self) -> Floats:
        """Measured yaw of the object from the throw's heading (N,) [rad]."""
        return self.objects.measured.yaw - np.arctan2(self.direction[:, 1], self.direction[:, 0])

    @computed
    def visible_grasp(self) -> Floats:
        """Grasp offset that the sensors would measure without noise (N, 2) [m]."""
        return self.objects.grasp + join_columns(self.belt_shift, 0.0)

    @computed
    def grasp(self) -> Floats:
        """True centre of mass relative to the cup axis, along x, y (N, 2) [m]."""
        return self.visible_grasp + self.unseen

    @computed
    def hanging(self) -> Floats:
        """True centre of mass relative to the cup's tip, of an object that hangs at rest (N, 3) [m]."""
        return np.concatenate([self.grasp, -self.objects.com_depth[:, None]], axis=1)

    @computed
    def arm(self) -> Floats:
        """`hanging` in the axes of the object (N, 3) [m]."""
        return turn_back(self.hanging, *self.objects.turn)

    @computed
    def lip_inertia(self) -> Floats:
        """Inertia of the object, free to turn about the lip, against a moment about each body axis (N, 3) [kg m2].

        This effective inertia 1 / (I^-1)_kk is less than the moment of inertia I_kk where an offset couples the axes.
        """
        inertia = np.empty((len(self.arm), 3, 3))
        kernel.fill_inertias(*in_order(self.objects.mass, self.arm, self.objects.inertia), inertia)
        return 1.0 / np.asarray(np.linalg.inv(inertia), dtype=np.float64).diagonal(axis1=1, axis2=2)

    @computed
    def cup_offset(self) -> Floats:
        """Cup tip relative to the planner's point (N, 3) [m]."""
        offset = np.zeros((len(self.objects.known_depth), 3))
        offset[:, 2] = self.objects.known_depth
        return offset

    @computed
    def measured_grasp(self) -> Floats:
        """Measured centre of mass relative to the cup axis, along world x, y (N, 2) [m]."""
        return self.visible_grasp + self.objects.measured.grasp_noise

    @computed
    def measured_grasp_in_throw(self) -> tuple[Floats, Floats]:
        """Measured centre of mass relative to the cup axis, along the throw and to its left, each (N,) [m]."""
        return self.to_throw_frame(self.measured_grasp)

    def without_jitter(self) -> Context:
        """The same picks without the values that differ from throw to throw of one object: jitter and failed picks."""
        objects = self.objects
        sure_draw = np.ones_like(objects.pick_draw)
        return self.replace(objects=objects.replace(delay=objects.delay - objects.jitter, pick_draw=sure_draw))

    def without_spin(self, rows: Bools) -> Context:
        """The same picks with zero spin where the object is lost (N,)."""
        if not any(rows.tolist()):
            return self
        objects = self.objects
        return self.replace(objects=objects.replace(spin=np.where(rows[:, None], 0.0, objects.spin)))

    def to_throw_frame(self, vector: Floats) -> tuple[Floats, Floats]:
        """Horizontal vectors (N, 2+) as components along the throw and to its left, each (N,)."""
        ex, ey = self.direction[:, 0], self.direction[:, 1]
        return vector[:, 0] * ex + vector[:, 1] * ey, vector[:, 1] * ex - vector[:, 0] * ey

    def from_throw_frame(self, along: Floats, across: Floats) -> Floats:
        """World vectors (N, 3), horizontal, of components along the throw and to its left, (N,) each."""
        ex, ey = self.direction[:, 0], self.direction[:, 1]
        return join_columns(along * ex - across * ey, along * ey + across * ex, 0.0)


def belt_shift(objects: Objects, pick: Floats, belt: Belt) -> Floats:
    """Grasp offset along x that the belt-speed error adds to objects at picks (N, 3): (N,) [m]."""
    return objects.belt_error * (pick[:, 0] - belt.camera_x)


def constant_bias(config: ConveyorConfig, count: int) -> HiddenDrift:
    """The constants of the level's section `bias` as hidden values of N cells, scaled by the mismatch."""
    bias, m = config.bias, config.mismatch
    return HiddenDrift.zero(count)._replace(
        delay=np.full(count, m * bias.delay),
        camera=np.tile(m * np.array(bias.camera), (count, 1)),
        encoder=np.full(count, m * bias.encoder),
    )


def unseen_grasp(hidden: HiddenDrift, pick: Floats, belt: Belt) -> Floats:
    """Grasp offset that camera and encoder add to objects at picks (N, 3), which no sensor measures (N, 2) [m]."""
    offset = hidden.camera.copy()
    offset[:, 0] += hidden.encoder * (pick[:, 0] - belt.camera_x)
    return offset


def apply_bias(context: Context, config: ConveyorConfig) -> Context:
    """Picks whose objects have the constants of the section `bias`; measurements and plans do not change."""
    objects, hidden = context.objects, constant_bias(config, len(context.pick))
    unseen = unseen_grasp(hidden, context.pick, config.belt)
    changed = objects.replace(
        drag=objects.drag * (1.0 + config.mismatch * config.bias.drag),
        delay=np.maximum(objects.delay + hidden.delay, 0.0),
        spin=spin_at_grasp(objects, objects.grasp + unseen, config),
    )
    return context.replace(objects=changed, drift=hidden, unseen=unseen)
