"""Correction: what the numbers of an action mean to a controller that learns from the errors of its throws.

Where each number of an action moves one measured error one to one, a throw that went wrong says by itself what would
have been right: what was asked for minus the error that came out. A `Correction` tells in which units and how far.
What any cell's actions go through before they are a plan is here too: the check of their numbers, and the search for
the nearest feasible plan.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, TypeAlias, TypeVar, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.errors import ActionError
from pnt_gym.planning.arrays import Bools, Floats, Ints

PlanT = TypeVar("PlanT")
CellNames: TypeAlias = Callable[[NDArray[np.float32], Ints], list[tuple[str, str]]]
"""Observations (N, D) and kinds (N,) to a name of the thing thrown and of the place it is thrown to, per throw."""
Possible: TypeAlias = Callable[[NDArray[np.float32], int, Floats], Bools]
"""Observation (D,) and kind of one throw, and shifts (M, E) of it in actions: which of them have a plan (M,)."""

_HALVINGS: Final = 12
"""Bisection of a residual that must shrink: to 1/4096 of its length."""


@final
@dataclass(frozen=True)
class Correction:
    """How the E numbers of an action shift the E errors of a throw."""

    errors: tuple[str, ...]
    """Names of the errors, one per number: keys of a step's info and attributes of a preview, each (N,)."""
    scale: Floats
    """How far an action of 1 moves each error (E,), in the error's unit."""
    exploration: Floats
    """Standard deviation of the shifts that a learner adds in practice (E,), in the errors' units."""
    tolerance: Floats
    """Errors that count alike (E,), in their own units: the size of an error is its length in these."""
    cells: CellNames
    """Which cell of a table each throw belongs to."""
    possible: Possible | None = None
    """Which shifts the robot can do; None where only a throw shows it, by being shortened."""

    @property
    def count(self) -> int:
        """The number of coordinates E."""
        return len(self.errors)


def limited_actions(actions: object, count: int, size: int, mode: str) -> Floats:
    """Actions as a float64 array (count, size), clipped to [-1, 1].

    Args:
        actions: what the caller gave.
        count: number of cells.
        size: numbers in one action.
        mode: name of the action mode, for the error.

    Raises:
        ActionError: wrong shape, or NaN or infinite values.
    """
    try:
        array = np.asarray(actions, dtype=np.float64)
    except (TypeError, ValueError):
        raise ActionError(f"action is {actions!r}; it must be an array of numbers") from None
    expected = (count, size)
    if array.shape != expected:
        raise ActionError(f"action has shape {array.shape}; {mode!r} with {count} cells needs {expected}")
    bad = ~np.isfinite(array)
    if bad.any():
        row = int(np.argwhere(bad)[0][0])
        raise ActionError(f"action of cell {row} is {array[row].tolist()}; it must be finite and within [-1, 1]")
    return np.clip(array, -1.0, 1.0)


def nearest_feasible(
    plan: Callable[[Floats], PlanT], is_feasible: Callable[[PlanT], Bools], actions: Floats
) -> tuple[PlanT, Bools]:
    """The plans of the longest feasible part of each residual, and which residuals had to be shortened (N,).

    The nominal plan (zero) is feasible by construction, so shortening towards it ends at a feasible plan.

    Args:
        plan: actions (N, size) to N plans.
        is_feasible: the plan check, (N,).
        actions: (N, size).
    """
    wanted = plan(actions)
    clipped = ~is_feasible(wanted)
    if not clipped.any():
        return wanted, clipped
    low, high = np.zeros(len(actions)), np.ones(len(actions))
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        good = is_feasible(plan(actions * middle[:, None]))
        low, high = np.where(good, middle, low), np.where(good, high, middle)
    share = np.where(clipped, low, 1.0)
    return plan(actions * share[:, None]), clipped
