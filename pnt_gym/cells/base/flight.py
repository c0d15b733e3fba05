"""The recorded flight of a free object towards its bin, and where it came to lie."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.constants import GRAVITY
from pnt_gym.planning.motion.ballistics import landing_point

TOUCH: Final = 1e-5
"""A contact counts when the surfaces are closer than this [m]; predicted contacts of fast objects are farther."""


def touching(contact: Floats) -> Bools:
    """Which sensed contacts (..., 2), number found and smallest distance, are more than predicted (...,)."""
    return np.asarray((contact[..., 0] > 0.0) & (contact[..., 1] < TOUCH))


@final
@dataclass(frozen=True)
class ObjectFlight:
    """N recorded throws, M steps each, cut to what decides where the object goes."""

    position: Floats
    """Object (N, M, 3) at the start of each step [m]."""
    velocity: Floats
    """Object (N, M, 3) [m/s]."""
    hand_touch: Bools
    """Whether the hand touches it (N, M)."""
    any_touch: Bools
    """Whether anything does (N, M)."""
    release_step: Ints
    """First step without grip (N,)."""
    last_step: Ints
    """Last step that counts (N,)."""

    @property
    def free(self) -> Bools:
        """Steps after the release that count, (N, M)."""
        steps = np.arange(self.position.shape[1], dtype=np.int64)
        return (steps > self.release_step[:, None]) & (steps <= self.last_step[:, None])

    def recontact(self) -> Bools:
        """Whether the hand touched the object after the release (N,)."""
        return np.asarray((self.hand_touch & self.free).any(axis=1))

    def landing(self, plane_z: Floats) -> Floats:
        """Where the free flight crosses height plane_z (N,), going down: x, y (N, 2) [m].

        An object that first touches a rim, a wall or the belt is carried on ballistically from that moment, so this
        measures the throw and not the bin.
        """
        rows = np.arange(len(self.position))
        free, height = self.free, self.position[..., 2] - plane_z[:, None]
        touched = self.any_touch & ~self.hand_touch & free
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

    def lies_in(self, centre: Floats, opening: Floats, rim: float, bottom: float) -> Bools:
        """Whether the objects lie in their bins for good at the end (N,); arguments as for `lies_in`."""
        return lies_in(*self.final(), centre, opening, rim, bottom)


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
