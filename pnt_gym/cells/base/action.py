"""Actions: their meaning for a robot, their feasible plans, and their meaning for a learner."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, Generic, Protocol, TypeAlias, TypeVar, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, Ints, replaced, take
from pnt_gym.errors import ActionError, ConfigError, PlanningError, one_sentence
from pnt_gym.planning.motion.roots import bisect

_HALVINGS: Final = 12
"""Bisection of a residual that must shrink: to 1/4096 of its length."""

Buckets: TypeAlias = Callable[[NDArray[np.float32], Ints], list[tuple[str, str]]]
"""Observations (N, D) and kinds (N,) to a name of the thing thrown and of the place it is thrown to, per throw."""
Possible: TypeAlias = Callable[[NDArray[np.float32], int, Floats], Bools]
"""Observation (D,) and kind of one throw, and shifts (M, E) of it in actions: which of them have a plan (M,)."""


class Plans(Protocol):
    """N plans: a record of arrays."""

    @property
    def feasible(self) -> Bools:
        """Which of them the robot can carry out (N,)."""
        ...


PlannerT = TypeVar("PlannerT")
ContextT = TypeVar("ContextT")
PlansT = TypeVar("PlansT", bound=Plans)


@final
@dataclass(frozen=True)
class ActionMode(Generic[PlannerT, ContextT, PlansT]):
    """One way to read an action in [-1, 1] as a residual on the nominal plan; zero is the nominal plan itself.

    Attributes:
        name: for level and command line.
        numbers: what each of its A numbers moves, for people.
        scale: a cell's config to what 1 is worth in each number (A,).
        plan: planner, coming throws and residual (N, A) in units to plans, feasible or not; a row's plan does not
            depend on the other rows.
        errors: the measured errors of a throw that the numbers shift one to one; none where they do not.
    """

    name: str
    numbers: tuple[str, ...]
    scale: Callable[[Any], Floats]
    plan: Callable[[PlannerT, ContextT, Floats], PlansT]
    errors: tuple[str, ...] = ()


Modes: TypeAlias = Mapping[str, ActionMode[Any, Any, Any]]
"""A robot's action modes by name, the default first."""


def by_name(*modes: ActionMode[Any, Any, Any]) -> Modes:
    """Action modes by their names."""
    return {mode.name: mode for mode in modes}


def mode_of(modes: Modes, name: str) -> ActionMode[Any, Any, Any]:
    """The action mode of a name.

    Raises:
        ConfigError: there is none.
    """
    if not isinstance(name, str) or name not in modes:  # pyright: ignore[reportUnnecessaryIsInstance] - users' values
        raise ConfigError(f"action_mode is {one_sentence(repr(name), 80)}; it must be one of {', '.join(modes)}")
    return modes[name]


def corrected(
    mode: ActionMode[PlannerT, ContextT, PlansT], planner: PlannerT, context: ContextT, actions: Floats, scale: Floats
) -> tuple[PlansT, Bools]:
    """Feasible plans for actions, and a mask of the residuals that had to be shortened (N,).

    A residual without a feasible plan is shortened to the longest part that has one, by bisection; the nominal plan is
    feasible by construction, so shortening towards it ends at a feasible plan.

    Args:
        mode: how the actions are read.
        planner: the robot's.
        context: the coming throws.
        actions: (N, A) within [-1, 1].
        scale: what an action of 1 is worth (A,).
    """
    plans = mode.plan(planner, context, actions * scale)
    clipped = ~plans.feasible
    rows = np.flatnonzero(clipped)
    if rows.size == 0:
        return plans, clipped
    there, wanted = take(context, rows), actions[rows]

    def part(share: Floats) -> PlansT:
        return mode.plan(planner, there, wanted * share[:, None] * scale)

    longest, _ = bisect(lambda share: part(share).feasible, np.zeros(rows.size), np.ones(rows.size), _HALVINGS)
    return replaced(plans, rows, part(longest)), clipped


@final
@dataclass(frozen=True)
class Correction:
    """How the E numbers of an action shift the E errors of a throw.

    Each number of an action shifts one measured error one to one. So one throw shows the right offset: the offset of
    its action minus its error.
    """

    errors: tuple[str, ...]
    """Names of the errors, one per number: attributes of a preview, each (N,)."""
    scale: Floats
    """How far an action of 1 moves each error (E,), in the error's unit."""
    exploration: Floats
    """Standard deviation of the offsets that a learner adds in practice (E,), in the errors' units."""
    tolerance: Floats
    """Errors of equal weight (E,), in their units; the size of an error is its length in these units."""
    buckets: Buckets
    """Which bucket of a table each throw belongs to."""
    possible: Possible | None = None
    """Offsets that the robot can carry out; None where only a throw shows that, by `residual_clipped`."""
    seen: tuple[str, ...] = ()
    """Keys of a step's info that tell of the errors, NaN where nothing is known; where there are none, `errors` are."""

    @property
    def told(self) -> tuple[str, ...]:
        """Keys of a step's info under which a learner finds the errors, each (N,)."""
        return self.seen or self.errors

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
        array = np.asarray(actions)
    except ValueError:  # rows of different lengths
        array = np.empty(0, dtype=object)
    # Booleans, texts, dates and masked or complex numbers would be taken for numbers that nobody meant.
    if array.dtype.kind not in "iuf" or np.ma.isMA(actions):
        raise ActionError(f"action is {one_sentence(repr(actions), 80)}; it must be an array of real numbers")
    expected = (count, size)
    if array.shape != expected:
        raise ActionError(f"action has shape {array.shape}; {mode!r} with {count} cells needs {expected}")
    array = array.astype(np.float64, copy=False)
    bad = ~np.isfinite(array)
    if bad.any():
        row = int(np.argwhere(bad)[0][0])
        raise ActionError(f"action of cell {row} is {array[row].tolist()}; it must be finite and within [-1, 1]")
    return np.clip(array, -1.0, 1.0)


def padded(residual: Floats, size: int) -> Floats:
    """Residuals (N, A) with zeros for the numbers that their mode leaves out, (N, size)."""
    return np.concatenate([residual, np.zeros((len(residual), size - residual.shape[1]))], axis=1)


def quarters(x: Floats, y: Floats, middle: Sequence[float], names: tuple[str, str]) -> list[str]:
    """Names of the quarters of an area that points (N,) lie in.

    Args:
        x: of the points.
        y: of the points.
        middle: x, y of the area's middle.
        names: of its far and its near half along y.
    """
    right, far = x > middle[0], y > middle[1]
    return [f"{'right' if r else 'left'}-{names[0] if f else names[1]}" for r, f in zip(right, far, strict=True)]


def require_feasible(plans: Plans) -> None:
    """Make sure that every cell has a plan that it can carry out.

    Raises:
        PlanningError: one has not.
    """
    if not plans.feasible.all():
        row = int(np.flatnonzero(~plans.feasible)[0])
        raise PlanningError(f"the plan of cell {row} is not feasible; throw only plans whose `feasible` is True")
