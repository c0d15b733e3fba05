"""Random goals that have a release the arm can do."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, NamedTuple, final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.errors import PlanningError
from pnt_gym.planning.one_joint.feasibility import ThrowReason, first_reason
from pnt_gym.planning.one_joint.flight import land
from pnt_gym.planning.one_joint.parameters import Arm, Block

ROUNDS: Final = 1000
"""Draws of a whole batch after which `random_goals` gives up."""


class GoalBatch(NamedTuple):
    """Landing states (N, 4) = x, y [m], phi [rad], dy [m/s], and a release (N, 4) that reaches each."""

    goal: Floats
    u: Floats


@final
@dataclass(frozen=True)
class ReleaseBox:
    """Ranges from which releases are drawn; arm and block cut off what they cannot do.

    Raises:
        ValueError: a range is empty, or a speed, radius or flight time is not positive.
    """

    angle: tuple[float, float] = (-0.5, 1.3)
    """theta_t [rad]. Further down, most releases ask for more run-up than there is below."""
    speed: tuple[float, float] = (4.0, 12.0)
    """omega_t [rad/s]"""
    radius: tuple[float, float] = (0.12, 0.28)
    """r along the arm [m]"""
    flight: tuple[float, float] = (0.12, 0.5)
    """t_f [s]"""

    def __post_init__(self) -> None:
        for name, (low, high) in self.ranges().items():
            if not (np.isfinite([low, high]).all() and low < high):
                raise PlanningError(f"{name} runs from {low} to {high}; the range must be finite and not empty")
            if name != "angle" and low <= 0.0:
                raise PlanningError(f"{name} starts at {low}; it must be positive")

    def ranges(self) -> dict[str, tuple[float, float]]:
        """The four ranges in the order of a release."""
        return {"angle": self.angle, "speed": self.speed, "radius": self.radius, "flight": self.flight}

    def releases(self, shares: Floats, block: Block) -> Floats:
        """Return the releases (N, 4) at ``shares`` (N, 4) in [0, 1] of the ranges."""
        low, high = np.array(list(self.ranges().values())).T
        u = low + (high - low) * shares
        u[:, 2] = np.sqrt(u[:, 2] ** 2 + block.half_height**2)
        return u


def random_goals(
    generator: np.random.Generator,
    count: int,
    *,
    arm: Arm | None = None,
    block: Block | None = None,
    box: ReleaseBox | None = None,
) -> GoalBatch:
    """Return ``count`` goals whose release keeps the limits of arm, motor and grasp.

    The acceleration window at the release is not empty; whether a motion from rest leads there is for a planner to
    say.

    Raises:
        ValueError: the count is negative, or the box holds (almost) no release that arm and block can do.
    """
    if count < 0:
        raise PlanningError(f"count is {count}; it must be at least 0")
    arm, block, box = arm or Arm(), block or Block(), box or ReleaseBox()
    found = np.zeros((0, 4))
    for _ in range(ROUNDS):
        u = box.releases(generator.random((count - len(found), 4)), block)
        found = np.concatenate([found, u[first_reason(u, arm, block)[0] == ThrowReason.FEASIBLE]])
        if len(found) == count:
            return GoalBatch(land(found, block.half_height), found)
    missing = count - len(found)
    raise PlanningError(f"{missing} of {count} goals were not found: arm and block can do next to nothing of {box}")
