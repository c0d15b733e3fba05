"""What became of a throw, read from the recorded motion of object and hand."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.cells.scene import SENSORS
from pnt_gym.planning.arrays import Bools, Floats, Ints
from pnt_gym.planning.ballistics import GRAVITY, landing_point

TOUCH: Final = 1e-5
"""A contact counts when the surfaces are closer than this [m]; predicted contacts of fast objects are farther."""


@final
@dataclass(frozen=True)
class Outcome:
    """N throws as the simulator measured them; every field has shape (N,) unless noted."""

    landing: Floats
    """Where the free flight crosses the rim plane, x, y (N, 2) [m]; an object that first touches a rim, a wall or the
    belt is carried on ballistically from that moment, so this measures the throw and not the bin."""
    landing_along: Floats
    """Landing from the target, along the throw [m]."""
    landing_across: Floats
    """Landing from the target, to the left of the throw [m]."""
    landing_error: Floats
    """Distance of the landing from the target [m]."""
    in_opening: Bools
    """The landing lies inside the opening."""
    in_bin: Bools
    """At the end the object lies in its bin: inside the walls, below the rim, too slow to leave."""
    sorted: Bools
    """In the opening and in the bin."""
    rim: Bools
    """In the opening but not in the bin: hanging on the rim or bounced out."""
    recontact: Bools
    """The cup touched the object after the release."""
    final: Floats
    """Position of the object at the end (N, 3) [m]."""
    cycle_time: Floats
    """From lift to lift, dwell included [s]."""
    wait_time: Floats
    """Part of the cycle spent waiting above the belt for the next object [s]."""
    peak_torque: Floats
    """Largest motor torque [N m]."""
    tracking_error: Floats
    """Distance of the hand from its reference at the moment of release [m]."""
    clipped: Bools
    """The residual was infeasible and was shortened."""


@final
@dataclass(frozen=True)
class Flight:
    """Recorded throws, cut to what decides their outcome."""

    position: Floats
    """Object (N, M, 3) at the start of each step [m]."""
    velocity: Floats
    """Object (N, M, 3) [m/s]."""
    cup_touch: Bools
    """(N, M)"""
    any_touch: Bools
    """(N, M)"""
    release_step: Ints
    """First step without grip (N,)."""
    last_step: Ints
    """Last step that counts (N,)."""

    @classmethod
    def from_sensors(cls, sensordata: Floats, release_step: Ints, last_step: Ints) -> Flight:
        """Flight from recorded sensordata (N, M, columns of `SENSORS`)."""

        def touch(name: str) -> Bools:
            found, distance = np.moveaxis(sensordata[..., SENSORS[name]], -1, 0)
            return (found > 0.0) & (distance < TOUCH)

        return cls(
            position=sensordata[..., SENSORS["object_position"]],
            velocity=sensordata[..., SENSORS["object_velocity"]],
            cup_touch=touch("cup_contact"),
            any_touch=touch("any_contact"),
            release_step=release_step,
            last_step=last_step,
        )

    @property
    def free(self) -> Bools:
        """Steps after the release that count, (N, M)."""
        steps = np.arange(self.position.shape[1], dtype=np.int64)
        return (steps > self.release_step[:, None]) & (steps <= self.last_step[:, None])

    def recontact(self) -> Bools:
        """Whether the cup touched the object after the release (N,)."""
        return np.asarray((self.cup_touch & self.free).any(axis=1))

    def landing(self, plane_z: Floats) -> Floats:
        """Where the free flight crosses height plane_z (N,), going down: x, y (N, 2) [m]."""
        rows = np.arange(len(self.position))
        free, height = self.free, self.position[..., 2] - plane_z[:, None]
        touched = self.any_touch & ~self.cup_touch & free
        below = np.zeros_like(free)
        below[:, 1:] = (height[:, 1:] < 0.0) & (height[:, :-1] >= 0.0) & free[:, 1:]
        event = np.where((touched | below).any(axis=1), np.argmax(touched | below, axis=1), self.last_step)
        before = np.maximum(event - 1, 0)
        start = self.position[rows, before]
        crossing = landing_point(start, self.velocity[rows, before], plane_z)
        # Never above the plane after the release: it fell short, and counts where it lies.
        end = self.position[rows, self.last_step, :2]
        return np.where(np.isfinite(crossing[:, :1]), crossing[:, :2], end)

    def final(self) -> tuple[Floats, Floats]:
        """Position and velocity at the last step that counts, (N, 3) each."""
        rows = np.arange(len(self.position))
        return self.position[rows, self.last_step], self.velocity[rows, self.last_step]


@final
@dataclass(frozen=True)
class Simulated:
    """N throws as the simulator ran them, before they are judged."""

    flight: Flight
    hand: Floats
    """Cup tip (N, M, 3) at the start of each step [m]."""
    start: Floats
    """Time on the path's own clock at the first step (N,) [s]."""
    tracking_error: Floats
    """Distance of the hand from its reference at the moment of release (N,) [m]."""
    peak_torque: Floats
    """Largest motor torque (N,) [N m]."""


def lies_in(position: Floats, velocity: Floats, centre: Floats, opening: Floats, rim: float, bottom: float) -> Bools:
    """Whether objects lie in their bins for good (N,).

    An object inside the walls, below the rim, whose upward speed does not lift it to the rim any more will stay.

    Args:
        position: centre of mass (N, 3) [m].
        velocity: (N, 3) [m/s].
        centre: of the opening (N, 2) [m].
        opening: inner size (N, 2) [m].
        rim: height of the rim [m].
        bottom: height of the inner bottom [m].
    """
    offset = np.abs(position[:, :2] - centre)
    inside = (offset <= opening / 2).all(axis=1)
    reach = position[:, 2] + velocity[:, 2] ** 2 / (2.0 * GRAVITY)
    return inside & (reach < rim) & (position[:, 2] > bottom)
