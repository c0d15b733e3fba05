"""Rules of the hand in a throw in a free direction, besides the limits of its motion.

In the throw of Hassan et al. 2022 the hand moves on a straight line from the pick to the release, so a low ceiling
forces flat and slow throws. Here hand and object separate with a velocity of any direction; `HandRules` keeps the hand
off the object, below a cap and inside the workspace.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, final

from pnt_gym.errors import PlanningError
from pnt_gym.planning.motion.limits import EllipticWorkspace

TOLERANCE: Final = 1e-6
"""Relative excess of a limit, and excess of a height or distance [m], that count as rounding."""


@final
@dataclass(frozen=True)
class HandRules:
    """Rules of the hand before and after the release.

    Attributes:
        approach: height of the vertical approach to the next pick, Z_off [m], above 0.
        window: time of constant velocity after the release [s].
        hand_cap: greatest rise of the hand above the release ceiling [m]; inf for no bound.
        clear_distance: sideways distance from the object at which the hand may move freely [m].
        margin: up to the clear distance the hand stays above the falling object by at least margin x g t^2 / 2, with
            t the time since the release.
        workspace: region that contains the hand; None for no bound.

    Raises:
        ValueError: a value is negative or not a number, the approach is 0, or the margin is not below 1.
    """

    approach: float = 0.05
    window: float = 0.0
    hand_cap: float = 0.15
    clear_distance: float = 0.12
    margin: float = 0.3
    workspace: EllipticWorkspace | None = None

    def __post_init__(self) -> None:
        if not (math.isfinite(self.approach) and self.approach > 0.0):
            raise PlanningError(f"approach must be finite and above 0 [m], got {self.approach}")
        for name in ("window", "clear_distance", "hand_cap"):
            value = getattr(self, name)
            if math.isnan(value) or value < 0.0 or (math.isinf(value) and name != "hand_cap"):
                raise PlanningError(f"{name} must be finite and not negative, got {value}")
        if not 0.0 <= self.margin < 1.0:
            raise PlanningError(f"margin must lie in [0, 1), got {self.margin}: at 1 the hand may not fall at all")
