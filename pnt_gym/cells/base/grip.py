"""What a suction cup can hold: statics of a rigid object under it, and of what its hand may ask.

The vacuum presses object and lip together with a force F0. Under way it has to carry the weight and the inertia of the
object: it slips once friction cannot take what is sideways, F0 < m (g + a_z) + m a_h / mu, and peels off once the
moment about the edge of the lip exceeds the vacuum's, F0 r < m a_h z + m (g + a_z) (e + r). This is the theoretical
holding force of a maker's handbook (Schmalz, "Theoretical holding force of a suction cup", load case II, to which the
moment is added), and what it advises to divide by stands in `SURFACES`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal, NamedTuple, TypeAlias, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.constants import GRAVITY

CUP_RADIUS: Final = 0.018
"""Bellows suction cup for light waste, 36 mm wide [m]."""
Surface: TypeAlias = Literal["smooth", "rough", "wet"]


class Contact(NamedTuple):
    """Of a cup's lip and a surface."""

    friction: float
    safety: float
    """What a holding force should be divided by, at least."""


SURFACES: Final[dict[str, Contact]] = {
    "smooth": Contact(0.5, 1.5),
    "rough": Contact(0.6, 2.0),
    "wet": Contact(0.25, 2.0),
}
"""Schmalz, same source: friction 0.5 on wood, metal, glass and stone, 0.6 on rough, 0.2 to 0.3 on wet ones; safety at
least 1.5 on smooth and dense workpieces, 2 on others."""
_LIGHTEST: Final = 1e-9
"""A load that is no load any more: the hand falls faster than the object [N]."""


@final
@dataclass(frozen=True)
class Hold:
    """N objects under their cups, as they are or as they are measured."""

    force: Floats
    """Of the vacuum, F0 (N,) [N]."""
    mass: Floats
    """(N,) [kg]"""
    friction: Floats
    """Between lip and object (N,)."""
    depth: Floats
    """Centre of mass below the lip, z (N,) [m]."""
    offset: Floats
    """Centre of mass from the cup's axis, e (N,) [m]."""
    radius: Floats
    """Of the lip, r (N,) [m]."""

    def margin(self, acceleration: Floats) -> Floats:
        """How many times the load the cup could hold (N, K), for accelerations of the hand (N, K, 3) [m/s2].

        The lesser one of slip and peel; below 1 the object leaves the cup.
        """
        mass, force = self.mass[:, None], self.force[:, None]
        sideways = mass * np.sqrt(acceleration[..., 0] ** 2 + acceleration[..., 1] ** 2)
        down = mass * (GRAVITY + acceleration[..., 2])
        slip = down + sideways / self.friction[:, None]
        radius = self.radius[:, None]
        peel = sideways * self.depth[:, None] / radius + down * (self.offset[:, None] / radius + 1.0)
        return force / np.maximum(np.maximum(slip, peel), _LIGHTEST)

    def least_margin(self, acceleration: Floats) -> Floats:
        """The margin under an acceleration (N,) [m/s2] in the worst direction (N,); the inverse of `acceleration`."""
        slip = GRAVITY + acceleration * np.sqrt(1.0 + self.friction**-2.0)
        arm = self.offset + self.radius
        peel = (GRAVITY * arm + acceleration * np.sqrt(self.depth**2 + arm**2)) / self.radius
        return np.asarray(self.force / (self.mass * np.maximum(slip, peel)))

    def acceleration(self, safety: float | Floats) -> Floats:
        """Largest acceleration in any direction at which the margin stays above a safety (N,) [m/s2].

        Not positive where the object cannot even be held at rest with it.
        """
        free = self.force / (np.asarray(safety) * self.mass)
        slip = (free - GRAVITY) / np.sqrt(1.0 + self.friction**-2.0)
        arm = self.offset + self.radius
        peel = (free * self.radius - GRAVITY * arm) / np.sqrt(self.depth**2 + arm**2)
        return np.minimum(slip, peel)


def first_below(margin: Floats, counts: Bools) -> Ints:
    """First step at which margins (N, K) are below 1, of those that count (N, K): (N,); -1 where none is."""
    low = (margin < 1.0) & counts
    return np.where(low.any(axis=1), low.argmax(axis=1), -1)
