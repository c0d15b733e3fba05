"""Grips of N suction cups: whether a cup seals, whether it holds the object until the release, and how they part.

The holding force is statics of a rigid object under the cup of an accelerated hand. The vacuum presses object and lip
together with a force F0. In motion this force carries the weight and the inertia of the object. The object slips once
friction cannot carry the sideways load, F0 < m (g + a_z) + m a_h / mu, and peels off once the moment about the edge of
the lip exceeds the vacuum's, F0 r < m a_h z + m (g + a_z) (e + r). The formula for slip is the theoretical holding
force of a maker's handbook (Schmalz, "Theoretical holding force of a suction cup", load case II); the moment is added
here. The safety factors that the handbook advises stand in `items.SURFACES`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, NamedTuple, Self, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.base.bodies import turn_back
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.objects.kernel import inside_outline
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.compiled import kernel, kernel_part
from pnt_gym.constants import GRAVITY
from pnt_gym.planning.motion.trajectory import HandPath
from pnt_gym.rows import Bools1, Floats1, Floats2, Floats3, Ints1

LEAST_ACCELERATION: Final = 2.0
"""Smallest acceleration of a throw; an object whose grip allows less is not thrown [m/s2]."""
# Smallest load in a quotient [N]; the load is negative where the hand falls faster than the object.
LIGHTEST = 1e-9


@final
class Hold(NamedTuple):
    """N objects under their suction cups, with true or with measured values."""

    force: Floats1
    """Force of the vacuum, F0 (N,) [N]."""
    mass: Floats1
    """(N,) [kg]"""
    friction: Floats1
    """Friction coefficient mu between lip and object (N,)."""
    depth: Floats1
    """Centre of mass below the lip, z (N,) [m]."""
    offset: Floats1
    """Centre of mass from the cup's axis, e (N,) [m]."""
    radius: Floats1
    """Radius of the lip, r (N,) [m]."""

    def least_margin(self, acceleration: Floats) -> Floats:
        """The margin (N,) under an acceleration (N,) [m/s2] in the worst direction; the inverse of `acceleration`."""
        # The worst direction of a: slip g + a sqrt(1 + 1/mu^2), peel (g (e + r) + a sqrt(z^2 + (e + r)^2)) / r.
        slip = GRAVITY + acceleration * np.sqrt(1.0 + self.friction**-2.0)
        arm = self.offset + self.radius
        peel = (GRAVITY * arm + acceleration * np.sqrt(self.depth**2 + arm**2)) / self.radius
        return np.asarray(self.force / (self.mass * np.maximum(slip, peel)))

    def acceleration(self, safety: float | Floats) -> Floats:
        """Largest acceleration in any direction at which the margin stays above a safety (N,) [m/s2].

        The value is not positive where the cup cannot even hold the object at rest with this safety.
        """
        # `least_margin` solved for the acceleration: F0 / (safety m) is what the vacuum can carry per mass.
        free = self.force / (np.asarray(safety) * self.mass)
        slip = (free - GRAVITY) / np.sqrt(1.0 + self.friction**-2.0)
        arm = self.offset + self.radius
        peel = (free * self.radius - GRAVITY * arm) / np.sqrt(self.depth**2 + arm**2)
        return np.minimum(slip, peel)


@kernel_part
def _load(hold: Hold, row: int, acceleration: Floats) -> float:
    """Holding force that the vacuum needs against slip and peel under an acceleration (3,) of the hand [N]."""
    mass, radius = hold.mass[row], hold.radius[row]
    x, y = acceleration[0], acceleration[1]
    sideways = mass * math.sqrt(x * x + y * y)
    down = mass * (GRAVITY + acceleration[2])
    slip = down + sideways / hold.friction[row]
    peel = sideways * hold.depth[row] / radius + down * (hold.offset[row] / radius + 1.0)
    return max(slip, peel, LIGHTEST)


@kernel
def smallest_margin(hold: Hold, accelerations: Floats3, counts: Ints1, scale: float) -> tuple[Floats1, Ints1]:
    """Smallest holding force over load (N,), and the first acceleration at which the object leaves the cup (N,).

    The load is the larger of those against slip and peel; below a margin of 1 the object leaves the cup.

    Args:
        hold: the N objects under their cups.
        accelerations: accelerations of the hands (N, K, 3) [m/s2].
        counts: numbers of accelerations that count, from the first (N,); the margin without any is inf.
        scale: factor of the load.

    Returns:
        The margins, and the indices of the first accelerations with a margin below 1; -1 where there is none.
    """
    margin, lost_at = np.empty(len(counts)), np.empty(len(counts), dtype=np.int64)
    for row in range(len(accelerations)):
        margin[row], lost_at[row] = math.inf, -1
        for k in range(counts[row]):
            value = hold.force[row] / _load(hold, row, accelerations[row, k]) / scale
            margin[row] = min(margin[row], value)
            if value < 1.0 and lost_at[row] < 0:
                lost_at[row] = k
    return margin, lost_at


@final
@dataclass(frozen=True)
class Grips:
    """Results of N grips until the valves are commanded."""

    margin: Floats
    """Smallest margin until the release, see `smallest_margin`; NaN where the cup holds nothing (N,)."""
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

    A cup seals with the item's `pick_chance` while the whole lip is inside the outline, never where the cup's middle is
    at least the lip's radius outside, and linearly in between (assumed). The probability of a failure scales with the
    mismatch, like every effect that the planner does not model.
    """
    objects = context.objects
    inside, radius = inside_outline(objects.rows, -context.grasp), objects.cup_radius
    chance = objects.pick_chance * np.minimum(np.maximum((inside + radius) / (2.0 * radius), 0.0), 1.0)
    return np.minimum(config.mismatch * (1.0 - chance), 1.0)


def grips(context: Context, sealed: Bools, path: HandPath, release_time: Floats, config: ConveyorConfig) -> Grips:
    """Grips of the true objects along the hands' paths; `sealed` says which cups sealed (N,).

    The load on the cup scales with the mismatch, like every effect that the planner does not model: at mismatch 0 every
    cup holds.
    """
    times = config.timestep * np.arange(int(max(release_time.tolist()) / config.timestep) + 1)
    held = times <= release_time[:, None]
    counts = np.where(sealed, held.sum(axis=1), 0)
    acceleration = path.sample(np.minimum(times, release_time[:, None])).acceleration
    margin, lost_at = smallest_margin(true_hold(context), acceleration, counts, max(config.mismatch, 1e-9))
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
