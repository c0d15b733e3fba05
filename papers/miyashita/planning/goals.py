"""Random goals within reach of the arm's throws, and the update of virtual goals in learning."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, NamedTuple, final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Bools, Floats
from pnt_gym.errors import PlanningError
from pnt_gym.planning.motion.roots import bisect
from pnt_gym.planning.one_joint.feasibility import ThrowReason, first_reason
from pnt_gym.planning.one_joint.flight import land
from pnt_gym.planning.one_joint.parameters import Arm, Block

ROUNDS: Final = 1000
"""Number of random batches after which `random_goals` gives up."""
HALVINGS: Final = 20
"""Number of bisections of the line back to the last goal that had a throw."""


class GoalBatch(NamedTuple):
    """Landing states (N, 4) = x, y [m], phi [rad], dy [m/s], and a release (N, 4) that reaches each."""

    goal: Floats
    u: Floats


@final
@dataclass(frozen=True)
class ReleaseBox:
    """Ranges of random releases, of which releases beyond the limits of arm and block are left out.

    Raises:
        ValueError: a range is empty, or a speed, radius or flight time is not positive.
    """

    angle: tuple[float, float] = (-0.5, 1.3)
    """Angle theta_t [rad]. At lower angles, most releases need more run-up than the arm's range has below."""
    speed: tuple[float, float] = (4.0, 12.0)
    """Speed omega_t [rad/s]."""
    radius: tuple[float, float] = (0.12, 0.28)
    """Radius r along the arm [m]."""
    flight: tuple[float, float] = (0.12, 0.5)
    """Flight time t_f [s]."""

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
    """Return ``count`` random goals whose releases keep the limits of arm, motor and grasp.

    The acceleration window at each release is not empty. A motion from rest to the release need not exist.

    Raises:
        ValueError: the count is negative, or the box holds (almost) no release within the limits of arm and block.
    """
    if count < 0:
        raise PlanningError(f"count is {count}; it must be at least 0")
    arm, block, box = arm or Arm(), block or Block(), box or ReleaseBox()
    releases = np.zeros((0, 4))
    for _ in range(ROUNDS):
        u = box.releases(generator.random((count - len(releases), 4)), block)
        releases = np.concatenate([releases, u[first_reason(u, arm, block)[0] == ThrowReason.FEASIBLE]])
        if len(releases) == count:
            return GoalBatch(land(releases, block.half_height), releases)
    missing = count - len(releases)
    raise PlanningError(
        f"{missing} of {count} goals were not found: arm and block have hardly any feasible release in {box}"
    )


def next_virtual_goal(virtual: Floats, goal: Floats, measured: Floats, gain: ArrayLike = 0.7) -> Floats:
    """Return the virtual goals (N, 4) of the next throws: virtual + K (goal - measured) (Eqs. 33, 34).

    Args:
        virtual: virtual goals of the last plans (N, 4).
        goal: true goals (N, 4).
        measured: measured states of the last throws (N, 4).
        gain: diagonal of K, one number or (4,).

    Raises:
        ValueError: shapes disagree, or a gain is negative or not finite.
    """
    gains = np.asarray(gain, dtype=np.float64)
    if gains.shape not in ((), (4,)) or not np.isfinite(gains).all() or (gains < 0.0).any():
        raise PlanningError(f"gain must be one or four finite numbers of at least 0, got {gain!r}")
    _check_shapes(virtual=virtual, goal=goal, measured=measured)
    return virtual + gains * (goal - measured)


def pull_back(last: Floats, proposed: Floats, feasible: Callable[[Floats], Bools]) -> tuple[Floats, Bools]:
    """Return the proposed goals, or the nearest goals with a throw on the lines from them to ``last``.

    Args:
        last: goals (N, 4) that have a throw.
        proposed: goals (N, 4) that may have no throw.
        feasible: function that returns whether each of its goals (M, 4) has a throw (M,).

    Returns:
        The goals (N, 4), which have a throw wherever ``last`` has a throw, and whether each was pulled back (N,).
    """
    _check_shapes(last=last, proposed=proposed)
    outside = ~feasible(proposed)
    result = proposed.copy()
    rows = np.nonzero(outside)[0]
    if not rows.size:
        return result, outside
    start, way = last[rows], proposed[rows] - last[rows]

    def has_throw(share: Floats) -> Bools:
        return feasible(start + share[:, None] * way)

    share, _ = bisect(has_throw, np.zeros(rows.size), np.ones(rows.size), HALVINGS)
    # A share of zero is the last goal itself, to the bit.
    result[rows] = np.where(share[:, None] > 0.0, start + share[:, None] * way, start)
    return result, outside


def _check_shapes(**arrays: Floats) -> None:
    shapes = {name: array.shape for name, array in arrays.items()}
    first = next(iter(shapes.values()))
    if len(first) != 2 or first[1] != 4 or any(shape != first for shape in shapes.values()):
        raise PlanningError(f"goals must have one shape (N, 4), got {shapes}")
