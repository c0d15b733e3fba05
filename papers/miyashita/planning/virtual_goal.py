"""Learning from throw to throw: the virtual goal (Miyashita et al. 2010, section 5)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Bools, Floats
from pnt_gym.errors import PlanningError
from pnt_gym.planning.motion.roots import bisect

HALVINGS: Final = 20
"""Of the way back to the last goal that had a throw."""


def next_virtual_goal(virtual: Floats, goal: Floats, measured: Floats, gain: ArrayLike = 0.7) -> Floats:
    """Return the virtual goals (N, 4) of the next throws: virtual + K (goal - measured) (Eqs. 33, 34).

    Args:
        virtual: goals that were planned for (N, 4).
        goal: goals that are meant (N, 4).
        measured: where the throws arrived (N, 4).
        gain: diagonal of K, one number or (4,).

    Raises:
        ValueError: shapes disagree, or a gain is negative or not finite.
    """
    gains = np.asarray(gain, dtype=np.float64)
    if gains.shape not in ((), (4,)) or not np.isfinite(gains).all() or (gains < 0.0).any():
        raise PlanningError(f"gain must be one or four finite numbers of at least 0, got {gain!r}")
    _one_shape(virtual=virtual, goal=goal, measured=measured)
    return virtual + gains * (goal - measured)


def pull_back(last: Floats, proposed: Floats, feasible: Callable[[Floats], Bools]) -> tuple[Floats, Bools]:
    """Return the proposed goals, or the nearest ones to them on the lines to ``last`` that have a throw.

    Args:
        last: goals (N, 4) that have a throw.
        proposed: goals (N, 4) that may have none.
        feasible: which of some goals (N, 4) have a throw (N,).

    Returns:
        The goals (N, 4), each of which has a throw if its ``last`` one has, and which rows were pulled back (N,).
    """
    _one_shape(last=last, proposed=proposed)
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


def _one_shape(**arrays: Floats) -> None:
    shapes = {name: array.shape for name, array in arrays.items()}
    first = next(iter(shapes.values()))
    if len(first) != 2 or first[1] != 4 or any(shape != first for shape in shapes.values()):
        raise PlanningError(f"goals must have one shape (N, 4), got {shapes}")
