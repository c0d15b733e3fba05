"""Whether N cups hold their objects until they are to let go, and how fast hands may be so that they do."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.cells.base.grip import Hold, first_below
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.cup.seal import picked
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


def grips(thrown: Context, path: HandPath, release_time: Floats, config: ConveyorConfig) -> Grips:
    """How the true objects fare under their cups.

    Load on the cup scales with the mismatch, as every effect does that the planner knows nothing of: at 0 all is held.
    """
    held = picked(thrown, config)
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
    x, y = (objects.grasp + objects.grasp_noise).T
    return Hold(
        force=objects.measured_seal,
        mass=objects.measured_mass,
        friction=objects.measured_friction,
        depth=objects.measured_size[:, 2] / 2.0,
        offset=np.hypot(x + belt_shift, y),
        radius=objects.cup_radius,
    )
