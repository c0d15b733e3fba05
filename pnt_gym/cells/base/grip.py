"""Holding force of a suction cup: statics of a rigid object under the cup of an accelerated hand.

The vacuum presses object and lip together with a force F0. In motion this force carries the weight and the inertia of
the object. The object slips once friction cannot carry the sideways load, F0 < m (g + a_z) + m a_h / mu, and peels off
once the moment about the edge of the lip exceeds the vacuum's, F0 r < m a_h z + m (g + a_z) (e + r). The formula for
slip is the theoretical holding force of a maker's handbook (Schmalz, "Theoretical holding force of a suction cup", load
case II); the moment is added here. The safety factors that the handbook advises stand in `SURFACES`.
"""

from __future__ import annotations

from typing import Final, Literal, NamedTuple, TypeAlias, final

import numpy as np

from pnt_gym.arrays import Floats, Ints, in_order
from pnt_gym.cells.base import recorded
from pnt_gym.constants import GRAVITY
from pnt_gym.rows import Floats1

CUP_RADIUS: Final = 0.018
"""Bellows suction cup for light waste, 36 mm wide [m]."""
Surface: TypeAlias = Literal["smooth", "rough", "wet"]


class Contact(NamedTuple):
    """Constants of the contact between a cup's lip and a surface."""

    friction: float
    safety: float
    """Smallest factor by which a holding force should be divided."""


SURFACES: Final[dict[str, Contact]] = {
    "smooth": Contact(0.5, 1.5),
    "rough": Contact(0.6, 2.0),
    "wet": Contact(0.25, 2.0),
}
"""Schmalz, same source: friction 0.5 on wood, metal, glass and stone, 0.6 on rough, 0.2 to 0.3 on wet ones; safety at
least 1.5 on smooth and dense workpieces, 2 on others."""


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

    def smallest_margin(self, accelerations: Floats, counts: Ints, scale: float = 1.0) -> tuple[Floats, Ints]:
        """Smallest holding force over load (N,), and the first acceleration at which the object leaves the cup (N,).

        The load is the larger of those against slip and peel; below a margin of 1 the object leaves the cup.

        Args:
            accelerations: accelerations of the hand (N, K, 3) [m/s2].
            counts: numbers of accelerations that count, from the first (N,); the margin without any is inf.
            scale: factor of the load.

        Returns:
            The margins, and the indices of the first accelerations with a margin below 1; -1 where there is none.
        """
        return recorded.smallest_margin(Hold(*in_order(*self)), *in_order(accelerations, counts), scale)

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
