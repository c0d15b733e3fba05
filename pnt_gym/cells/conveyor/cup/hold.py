"""Whether N cups seal on their objects and hold them until they are to let go, and how fast hands may be then."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.base.grip import Hold, first_below
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.objects.outline import inside_outline
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.planning.motion.trajectory import HandPath

LEAST_ACCELERATION: Final = 2.0
"""An object that must be thrown more slowly than this is not thrown at all [m/s2]."""


@final
@dataclass(frozen=True)
class Grips:
    """How N grips fare until the valves are commanded."""

    margin: Floats
    """Least margin on the way, see `Hold.margin`; NaN where nothing is held (N,)."""
    lost_at: Ints
    """Physics step at whose beginning the object leaves the cup (N,); -1 where it does not."""

    picked: Bools
    """Whether the cup sealed at all (N,)."""

    @property
    def dropped(self) -> Bools:
        """Which objects are lost (N,)."""
        return self.lost_at >= 0

    @property
    def unthrown(self) -> Bools:
        """Which objects are lost or were never held: nothing sets those spinning (N,)."""
        return self.dropped | ~self.picked


def picked(thrown: Context, config: ConveyorConfig) -> Bools:
    """Which objects their cups hold (N,).

    The chance to fail scales with the mismatch, as every effect does that the planner knows nothing of.
    """
    if not config.pick.fails:
        return np.full(len(thrown.pick), True)
    fails: Floats = np.minimum(config.mismatch * (1.0 - seal_chance(thrown)), 1.0)
    return thrown.objects.pick_draw >= fails


def seal_chance(thrown: Context) -> Floats:
    """Chance that a cup seals where it truly stands on its object (N,): its kind's, less where the lip hangs over.

    All of it while the whole lip is inside the outline, nothing from where the cup's middle is the lip's radius
    outside, and linear between (assumed).
    """
    objects = thrown.objects
    inside, radius = inside_outline(objects, -thrown.grasp), objects.cup_radius
    return objects.pick_chance * np.clip((inside + radius) / (2.0 * radius), 0.0, 1.0)


def grips(thrown: Context, held: Bools, path: HandPath, release_time: Floats, config: ConveyorConfig) -> Grips:
    """How the true objects fare under their cups, of which some hold theirs at first (N,).

    Load on the cup scales with the mismatch, as every effect does that the planner knows nothing of: at 0 all is held.
    """
    steps = np.arange(int(np.floor(release_time.max() / config.timestep)) + 1, dtype=np.int64)
    times = np.asarray(steps * config.timestep, dtype=np.float64)
    counts = (times <= release_time[:, None]) & held[:, None]
    acceleration = path.sample(np.minimum(times, release_time[:, None])).acceleration
    margin = true_hold(thrown).margin(acceleration) / max(config.mismatch, 1e-9)
    lost = first_below(margin, counts) if config.grip.limit else np.full(len(margin), -1)
    return Grips(np.where(held, np.where(counts, margin, np.inf).min(axis=1), np.nan), lost, held)


def slip(thrown: Context, config: ConveyorConfig) -> Floats:
    """How far N objects slip under their cups while the vacuum builds up [m].

    A hand that stands still loses all that the belt moves on, one that rides with it what the speed is off.
    """
    nominal = config.belt.speed * config.motion.dwell
    error = thrown.objects.belt_error
    return nominal * np.abs(error if config.belt.tracking else 1.0 + error)


def true_hold(thrown: Context) -> Hold:
    """Objects as they hang under their cups."""
    o, e = thrown.objects, thrown.grasp
    return Hold(o.seal, o.mass, o.cup_friction, o.com_depth, np.hypot(e[:, 0], e[:, 1]), o.cup_radius)


def measured_hold(objects: Objects, belt_shift: Floats) -> Hold:
    """Objects as the sensors see them hang, taken for as heavy above as below their middle."""
    x, y = (objects.grasp + objects.measured.grasp_noise).T
    return Hold(
        force=objects.measured.seal,
        mass=objects.measured.mass,
        friction=objects.measured.friction,
        depth=objects.measured.size[:, 2] / 2.0,
        offset=np.hypot(x + belt_shift, y),
        radius=objects.cup_radius,
    )
