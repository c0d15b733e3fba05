"""Random goals that have a release the arm can do."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, NamedTuple, final

import numpy as np

from pnt_gym.planning.arrays import Bools, Floats
from pnt_gym.planning.one_joint._flight import land
from pnt_gym.planning.one_joint.feasibility import ThrowReason, first_reason
from pnt_gym.planning.one_joint.parameters import Arm, Block

ROUNDS: Final = 1000
"""Draws of a whole batch after which `random_goals` gives up."""


class Goals(NamedTuple):
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
                raise ValueError(f"{name} runs from {low} to {high}; the range must be finite and not empty")
            if name != "angle" and low <= 0.0:
                raise ValueError(f"{name} starts at {low}; it must be positive")

    def ranges(self) -> dict[str, tuple[float, float]]:
        """The four ranges in the order of a release."""
        return {"angle": self.angle, "speed": self.speed, "radius": self.radius, "flight": self.flight}

    def releases(self, shares: Floats, block: Block) -> Floats:
        """Return the releases (..., 4) at ``shares`` (..., 4) in [0, 1] of the ranges."""
        low, high = np.array(list(self.ranges().values())).T
        u = low + (high - low) * shares
        u[..., 2] = np.sqrt(u[..., 2] ** 2 + block.half_height**2)
        return u


def goals_from_uniform(
    shares: Floats, *, arm: Arm | None = None, block: Block | None = None, box: ReleaseBox | None = None
) -> tuple[Goals, Bools]:
    """Return the goal of the first feasible one of K candidates in each row, and whether there was one (N,).

    Args:
        shares: uniform numbers in [0, 1], (N, K, 4): K candidates per row.
        arm: the paper's when not given.
        block: the paper's when not given.
        box: where releases lie.
    """
    arm, block, box = arm or Arm(), block or Block(), box or ReleaseBox()
    if shares.ndim != 3 or shares.shape[2] != 4 or shares.shape[1] == 0:
        raise ValueError(f"shares must have shape (N, K, 4) with K >= 1, got {shares.shape}")
    u = box.releases(shares, block)
    reason = first_reason(u.reshape(-1, 4), arm, block)[0]
    good = (reason == ThrowReason.FEASIBLE).reshape(u.shape[:2])
    first = u[np.arange(u.shape[0]), good.argmax(axis=1)]
    return Goals(land(first, block.half_height), first), good.any(axis=1)


def random_goals(
    generator: np.random.Generator,
    count: int,
    *,
    arm: Arm | None = None,
    block: Block | None = None,
    box: ReleaseBox | None = None,
) -> Goals:
    """Return ``count`` goals whose release keeps the limits of arm, motor and grasp.

    The acceleration window at the release is not empty; whether a motion from rest leads there is for a planner to
    say.

    Raises:
        ValueError: the count is negative, or the box holds (almost) no release that arm and block can do.
    """
    if count < 0:
        raise ValueError(f"count is {count}; it must be at least 0")
    found: list[Goals] = []
    missing = count
    for _ in range(ROUNDS):
        if missing == 0:
            break
        goals, good = goals_from_uniform(generator.random((missing, 1, 4)), arm=arm, block=block, box=box)
        found.append(Goals(goals.goal[good], goals.u[good]))
        missing -= int(good.sum())
    if missing:
        raise ValueError(f"{missing} of {count} goals were not found: arm and block can do next to nothing of {box}")
    if not found:
        return Goals(np.zeros((0, 4)), np.zeros((0, 4)))
    return Goals(*(np.concatenate(part) for part in zip(*found, strict=True)))
