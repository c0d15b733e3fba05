"""Grips of N suction cups: whether a cup seals, whether it holds the object until the release, and how they part."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, NamedTuple, Self, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, in_order
from pnt_gym.cells.base.grip import Hold
from pnt_gym.cells.base.rotations import turn_back
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.objects import kernel
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.planning.motion.trajectory import HandPath
from pnt_gym.rows import Bools1, Floats1, Floats2

LEAST_ACCELERATION: Final = 2.0
"""Smallest acceleration of a throw; an object whose grip allows less is not thrown [m/s2]."""


@final
@dataclass(frozen=True)
class Grips:
    """Results of N grips until the valves are commanded."""

    margin: Floats
    """Smallest margin until the release, see `Hold.smallest_margin`; NaN where the cup holds nothing (N,)."""
    lost_at: Ints
    """Physics step at whose beginning the object leaves the cup (N,); -1 where the cup holds it."""

    picked: Bools
    """Whether the cup sealed at all (N,)."""

    @property
    def dropped(self) -> Bools:
        """Which objects leave their cups before the release (N,)."""
        return self.lost_at >= 0

    @property
    def unthrown(self) -> Bools:
        """Which objects are dropped or were never held, and so get no spin from a release (N,)."""
        return self.dropped | ~self.picked


@final
class Parting(NamedTuple):
    """State of N objects at the moment of release, relative to the tips of their cups."""

    centre: Floats2
    """Centre of mass relative to the tip (N, 3) [m]."""
    velocity: Floats2
    """Velocity relative to the hand (N, 3) [m/s]."""
    attitude: Floats2
    """Attitude as quaternions, w first (N, 4)."""
    rate: Floats2
    """Angular velocity in the object's axes (N, 3) [rad/s]."""
    push: Floats1
    """The part of the velocity that comes from blown air, downwards (N,) [m/s]."""
    unsure: Bools1
    """Whether the object touched the belt or the solid part of its cup, which only the engine simulates (N,)."""

    @classmethod
    def hanging(cls, context: Context, push: Floats) -> Self:
        """Objects that hang rigidly under their cups, and get their spin and a push (N,) [m/s] at the release."""
        o = context.objects
        velocity = np.zeros_like(context.hanging)
        velocity[:, 2] = -push
        return cls(
            centre=context.hanging,
            velocity=velocity,
            attitude=o.attitude,
            rate=turn_back(o.spin, *o.turn),
            push=push,
            unsure=np.zeros(len(push), dtype=np.bool_),
        )


def picked(context: Context, config: ConveyorConfig) -> Bools:
    """Which cups seal on their objects (N,)."""
    if not config.pick.fails:
        return np.full(len(context.pick), True)
    return context.objects.pick_draw >= fail_chance(context, config)


def fail_chance(context: Context, config: ConveyorConfig) -> Floats:
    """Probability that a cup does not seal on its object (N,), in levels in which picks fail.

    The probability scales with the mismatch, like every effect that the planner does not model.
    """
    return np.minimum(config.mismatch * (1.0 - seal_chance(context)), 1.0)


def seal_chance(context: Context) -> Floats:
    """Probability that a cup seals at its true place on the object (N,): the item's, less where the lip overhangs.

    The probability is the item's `pick_chance` while the whole lip is inside the outline, 0 where the cup's middle is
    at least the lip's radius outside, and linear in between (assumed).
    """
    objects = context.objects
    inside, radius = inside_outline(objects, -context.grasp), objects.cup_radius
    return objects.pick_chance * np.minimum(np.maximum((inside + radius) / (2.0 * radius), 0.0), 1.0)


def inside_outline(objects: Objects, place: Floats) -> Floats:
    """Distance of points from the outlines of objects in top view (N,) [m]; positive inside, negative outside.

    The distance from an ellipse is scaled by the ellipse's smaller half axis: exact for a circle.

    Args:
        objects: N objects.
        place: one point per object, relative to the object's middle, along world x, y (N, 2) [m].
    """
    return kernel.inside_outline(*in_order(objects.rows, place))


def grips(context: Context, sealed: Bools, path: HandPath, release_time: Floats, config: ConveyorConfig) -> Grips:
    """Grips of the true objects along the hands' paths; `sealed` says which cups sealed (N,).

    The load on the cup scales with the mismatch, like every effect that the planner does not model: at mismatch 0 every
    cup holds.
    """
    times = config.timestep * np.arange(int(max(release_time.tolist()) / config.timestep) + 1)
    held = times <= release_time[:, None]
    counts = np.where(sealed, held.sum(axis=1), 0)
    acceleration = path.sample(np.minimum(times, release_time[:, None])).acceleration
    margin, lost_at = true_hold(context).smallest_margin(acceleration, counts, max(config.mismatch, 1e-9))
    margin[~sealed] = np.nan
    return Grips(margin, lost_at if config.grip.limit else np.full(len(margin), -1), sealed)


def slip(context: Context, config: ConveyorConfig) -> Floats:
    """Distance that N objects slip under their cups while the vacuum builds up (N,) [m].

    Under a hand at rest an object slips by the belt's whole motion, under a hand that rides with the belt by the error
    of the belt speed.
    """
    nominal = config.belt.speed * config.motion.dwell
    error = context.objects.belt_error
    return nominal * np.abs(error if config.belt.tracking else 1.0 + error)


def true_hold(context: Context) -> Hold:
    """True values of objects under their cups."""
    o, e = context.objects, context.grasp
    return Hold(o.seal, o.mass, o.cup_friction, o.com_depth, np.hypot(e[:, 0], e[:, 1]), o.cup_radius)


def measured_hold(objects: Objects, belt_shift: Floats) -> Hold:
    """Measured values of objects under their cups; the centre of mass is assumed at half the height."""
    x, y = (objects.grasp + objects.measured.grasp_noise).T
    return Hold(
        force=objects.measured.seal,
        mass=objects.measured.mass,
        friction=objects.measured.friction,
        depth=objects.measured.size[:, 2] / 2.0,
        offset=np.hypot(x + belt_shift, y),
        radius=objects.cup_radius,
    )
