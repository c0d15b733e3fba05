"""Picks before their throws: object, pick point, target, limits and nominal plan."""

from __future__ import annotations

from functools import cached_property
from typing import Any, ClassVar, NamedTuple, Self, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, Ints, join_columns, rows_of_words, words
from pnt_gym.cells.base.bodies import turn_back
from pnt_gym.cells.base.sorting import Belt
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.objects import kernel
from pnt_gym.cells.conveyor.objects.drawing import spin_at_grasp
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.planning.motion.limits import LimitRows
from pnt_gym.planning.straight.plan import ReleaseBatch
from pnt_gym.rows import Columns, Pair, Triple, field


class ThrowBins(NamedTuple):
    """ThrowBins at which objects are thrown, of any leading shape S."""

    target: Floats
    """Centres of the openings at the rims, S + (3,) [m]."""
    opening: Floats
    """Inner sizes of the openings along x and y, S + (2,) [m]."""
    bin: Ints
    """Indices of the fixed bins, or 0 where bins are drawn per throw, S."""


@final
class HiddenDrift(Columns):
    """Hidden drift of cells at a pick, which no sensor measures."""

    delay: Floats = field("s", "release delay beyond that of the object")
    camera: Pair = field("m", "true position of an object minus the camera's, along x, y")
    encoder: Floats = field("-", "true belt speed over the encoder's, minus 1")
    scale: Floats = field("-", "true distance from the middle of the lane over the camera's, minus 1")
    draught: Pair = field("m/s", "velocity of the air along x, y")

    def plus(self, other: HiddenDrift) -> HiddenDrift:
        """The sum of two drifts of the same cells."""
        return HiddenDrift(rows_of_words(words(self.rows) + words(other.rows), self.dtype))


@final
class HiddenCell(Columns):
    """Hidden numbers in which a cell differs from others, as `drift.Cells` explains."""

    valve: Floats = field("s", "delay of the valve")
    tau: Floats = field("s", "time constant of the vacuum under a tight seal")
    blow_off: Floats = field("m/s", "speed that blown air gives an object at its release")
    stiffness: Floats = field("N m/rad", "stiffness of the lip; infinite for a rigid cup")
    drag: Floats = field("-", "factor of every item's drag")
    restitution: Floats = field("-", "factor of every object's restitution")
    seal: Floats = field("-", "difference of every item's chance that a cup seals")
    camera: Floats = field("-", "true distance from the middle of the lane over the camera's, minus 1")
    encoder: Floats = field("-", "true belt speed over the encoder's, minus 1")

    @classmethod
    def of_level(cls, config: ConveyorConfig, count: int) -> Self:
        """The numbers of a level's own cell, for N cells."""
        suction, cup = config.suction, config.cup
        return cls.of(
            count, valve=suction.valve, tau=suction.tau, blow_off=cup.blow_off, stiffness=cup.stiffness or np.inf,
            drag=1.0, restitution=1.0,
        )  # fmt: skip


@final
class LastThrow(Columns):
    """Measurements of the previous throws of cells, in the same shift of picks; zeros before the first throw."""

    seen: Bools = field("-", "whether the bin's camera saw the landing")
    error: Pair = field("m", "measured landing minus target, along and left of the previous throw; 0 where unseen")
    shift: Pair = field("m", "offset of the landing from that of the nominal plan, without drag, in the same frame")
    direction: Pair = field("-", "horizontal unit vector of the previous throw")
    gone: Floats = field("-", "share of the shift that is over")


@final
class Context(Columns):
    """N picks, each with the object under the cup.

    Positions are those of the planner's point mass: the cup tip at mismatch 1, the centre of mass at mismatch 0.

    Args:
        rows: the picks.
        objects: the objects.
        throw_limits: limits of the hand from the pick until it stops after the release; lower than `limits` where a
            grip needs less acceleration.
        plan: the analytic planner's releases, with the objects as points at the cups.
        depth: free depth above the content of all fixed bins, or of the one that is drawn per throw (N, B) [m].
    """

    pick: Triple = field("m", "position of the pick")
    target: Triple = field("m", "centre of the opening at the rim plane")
    opening: Pair = field("m", "inner size of the opening along x and y")
    bin: Ints = field("-", "index of the fixed bin, or 0 where the bin is drawn per throw")
    belt_speed: Floats = field("m/s", "nominal speed of the belt")
    ceiling: Floats = field("m", "highest release z of the nominal plan")
    belt_shift: Floats = field("m", "grasp offset along x that the belt-speed error adds")
    unseen: Pair = field("m", "grasp offset that the drift adds, which no sensor measures")
    spent: Floats = field("s", "time of failed tries to grasp the same object, which counts as part of the cycle")
    cell: HiddenCell = field("-", "hidden numbers in which the cell differs from others; zeros where cells are alike")
    drift: HiddenDrift = field("-", "hidden drift of the cell")
    before: LastThrow = field("-", "measurements of the previous throw")

    _fields: ClassVar = ("rows", "objects", "throw_limits", "plan", "depth")

    def __init__(
        self, rows: NDArray[Any], objects: Objects, throw_limits: LimitRows, plan: ReleaseBatch, depth: Floats
    ) -> None:
        super().__init__(rows)
        self.objects, self.throw_limits, self.plan, self.depth = objects, throw_limits, plan, depth

    @classmethod
    def new(
        cls,
        objects: Objects,
        pick: Floats,
        bins: ThrowBins,
        depth: Floats,
        *,
        throw_limits: LimitRows,
        plan: ReleaseBatch,
        ceiling: Floats,
        belt: Belt,
    ) -> Context:
        """Picks of cells without drift and without a previous throw."""
        target, opening, index = bins
        shift = belt_shift(objects, pick, belt)
        rows = cls.zeros(
            len(pick), pick=pick, target=target, opening=opening, bin=index, belt_speed=belt.speed, ceiling=ceiling,
            belt_shift=shift,
        )  # fmt: skip
        return cls(rows, objects, throw_limits, plan, depth)

    @property
    def kind(self) -> Ints:
        """Item that the classifier sees in each object: index into the cell's items (N,)."""
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
        return self.objects.measured.yaw - np.arctan2(self.direction[:, 1], self.direction[:, 0])

    @cached_property
    def visible_grasp(self) -> Floats:
        """Grasp offset that the sensors would measure without noise (N, 2) [m]."""
        return self.objects.grasp + join_columns(self.belt_shift, 0.0)

    @cached_property
    def grasp(self) -> Floats:
        """True centre of mass relative to the cup axis, along x, y (N, 2) [m]."""
        return self.visible_grasp + self.unseen

    @cached_property
    def hanging(self) -> Floats:
        """True centre of mass relative to the cup's tip, of an object that hangs at rest (N, 3) [m]."""
        return np.concatenate([self.grasp, -self.objects.com_depth[:, None]], axis=1)

    @cached_property
    def arm(self) -> Floats:
        """`hanging` in the axes of the object (N, 3) [m]."""
        return turn_back(self.hanging, *self.objects.turn)

    @cached_property
    def lip_inertia(self) -> Floats:
        """Inertia of the object, free to turn about the lip, against a moment about each body axis (N, 3) [kg m2].

        This effective inertia 1 / (I^-1)_kk is less than the moment of inertia I_kk where an offset couples the axes.
        """
        inertia = kernel.inertias_at_tip(self.objects.mass, self.arm, self.objects.inertia)
        return 1.0 / np.asarray(np.linalg.inv(inertia), dtype=np.float64).diagonal(axis1=1, axis2=2)

    @cached_property
    def cup_offset(self) -> Floats:
        """Cup tip relative to the planner's point (N, 3) [m]."""
        offset = self.objects.hand_error.copy()
        offset[:, 2] += self.objects.known_depth
        return offset

    @cached_property
    def measured_grasp(self) -> Floats:
        """Measured centre of mass relative to the cup axis, along world x, y (N, 2) [m]."""
        return self.visible_grasp + self.objects.measured.grasp_noise

    @cached_property
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
    return HiddenDrift.of(count, delay=m * bias.delay, camera=m * np.array(bias.camera), encoder=m * bias.encoder)


def unseen_grasp(hidden: HiddenDrift, pick: Floats, belt: Belt) -> Floats:
    """Grasp offset that camera and encoder add to objects at picks (N, 3), which no sensor measures (N, 2) [m]."""
    offset = hidden.camera.copy()
    offset[:, 0] += hidden.encoder * (pick[:, 0] - belt.camera_x)
    offset[:, 1] += hidden.scale * (pick[:, 1] - sum(belt.lane_y) / 2.0)
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
