"""Actions: how a robot reads an action, how the action becomes a feasible plan, and how it moves a throw's errors."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, Generic, Protocol, TypeAlias, TypeVar, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, Ints, replace_rows, take
from pnt_gym.errors import ActionError, ConfigError, PlanningError, one_sentence
from pnt_gym.names import unknown_name
from pnt_gym.planning.motion.roots import bisect

_HALVINGS: Final = 12
"""Bisection steps of a residual without a feasible plan: resolution 1/4096 of the residual's length."""

Buckets: TypeAlias = Callable[[NDArray[np.float32], Ints], list[tuple[str, str]]]
"""Function from observations (N, D) and kinds (N,) to a name of the item and a name of the target area, per throw."""
"""Function from observation (D,) and kind of one throw, and offsets (M, E) in units of actions, to whether each offset
has a feasible plan (M,)."""


class Plans(Protocol):
    """N plans: a record of arrays."""

    @property
    def feasible(self) -> Bools:
        """Which plans the robot can carry out (N,)."""
        ...


PlannerT = TypeVar("PlannerT")
ContextT = TypeVar("ContextT")
PlansT = TypeVar("PlansT", bound=Plans)


@final
@dataclass(frozen=True)
class ActionMode(Generic[PlannerT, ContextT, PlansT]):
    """One way to read an action in [-1, 1] as a residual on a plan; zero is that plan, usually the nominal one.

    Attributes:
        name: name in levels and command lines.
        numbers: meaning of each of the A numbers of an action, for people.
        scale: function from a cell's config to the residual (A,) of an action of 1, in the numbers' units.
        plan: function from planner, coming throws and residual (N, A) in the numbers' units to plans, feasible or not;
            a row's plan does not depend on the other rows.
        errors: the measured errors of a throw that the numbers move one to one; empty where the numbers do not.
        unseen: entries of the observation that are 0 in this mode.
        planners: values of the config's `planner` for which the mode exists; empty: it exists for all.
    """

    name: str
    numbers: tuple[str, ...]
    scale: Callable[[Any], Floats]
    plan: Callable[[PlannerT, ContextT, Floats], PlansT]
    errors: tuple[str, ...] = ()
    unseen: tuple[str, ...] = ()
    planners: tuple[str, ...] = ()


Modes: TypeAlias = Mapping[str, ActionMode[Any, Any, Any]]
"""A robot's action modes by name, the default first."""


def by_name(*modes: ActionMode[Any, Any, Any]) -> Modes:
    """Action modes in a mapping by their names."""
    return {mode.name: mode for mode in modes}


def mode_of(modes: Modes, name: str) -> ActionMode[Any, Any, Any]:
    """The action mode with a name.

    Raises:
        ConfigError: no action mode has this name.
    """
    if not isinstance(name, str) or name not in modes:  # pyright: ignore[reportUnnecessaryIsInstance] - users' values
        raise ConfigError(unknown_name("action_mode", name, modes))
    return modes[name]


def corrected(
    mode: ActionMode[PlannerT, ContextT, PlansT], planner: PlannerT, context: ContextT, actions: Floats, scale: Floats
) -> tuple[PlansT, Bools]:
    """Feasible plans for actions, and which actions' residuals were shortened for that (N,).

    A residual without a feasible plan is shortened by bisection to its longest part with a feasible plan. The nominal
    plan is feasible by construction, so the bisection always ends at a feasible plan.

    Args:
        mode: how the actions are read.
        planner: the robot's planner.
        context: the coming throws.
        actions: (N, A) within [-1, 1].
        scale: residual of an action of 1, in the numbers' units (A,).
    """
    plans = mode.plan(planner, context, actions * scale)
    clipped = ~plans.feasible
    rows = clipped.nonzero()[0]
    if rows.size == 0:
        return plans, clipped
    context_rows, action_rows = take(context, rows), actions[rows]

    def part(share: Floats) -> PlansT:
        return mode.plan(planner, context_rows, action_rows * share[:, None] * scale)

    longest, _ = bisect(lambda share: part(share).feasible, np.zeros(rows.size), np.ones(rows.size), _HALVINGS)
    return replace_rows(plans, rows, part(longest)), clipped


@final
@dataclass(frozen=True)
class Correction:
    """How the E numbers of an action move the E errors of a throw.

    Where each number of an action moves one measured error one to one, one throw suffices to learn: the right offset
    was the throw's offset minus the measured error.
    """

    errors: tuple[str, ...]
    """Names of the errors, one per number: attributes of a preview, each (N,)."""
    scale: Floats
    """How far an action of 1 moves each error (E,), in the error's unit."""
    exploration: Floats
    """Standard deviation of the offsets that a learner adds in practice (E,), in the errors' units."""
    tolerance: Floats
    """Equally bad errors (E,), in the errors' units: the size of an error is its length relative to these."""
    buckets: Buckets
    """Function that names the row of a table to which each throw belongs."""
    info_errors: tuple[str, ...] = ()
    """Info keys with the measured errors, NaN where nothing was measured; if empty, `errors` are the keys."""

    @property
    def error_keys(self) -> tuple[str, ...]:
        """Keys of a step's info with the errors from which a learner learns, (N,) each."""
        return self.info_errors or self.errors

    @property
    def count(self) -> int:
        """Number of errors E."""
        return len(self.errors)


def clip_actions(actions: object, count: int, size: int, mode: str) -> Floats:
    """Actions as a float64 array (count, size), clipped to [-1, 1].

    Args:
        actions: the caller's actions.
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
    # numpy would convert booleans, texts, dates and masked or complex numbers to numbers that the caller did not mean.
    if array.dtype.kind not in "iuf" or np.ma.isMA(actions):
        raise ActionError(f"action is {one_sentence(repr(actions), 80)}; it must be an array of real numbers")
    expected = (count, size)
    if array.shape != expected:
        raise ActionError(f"action has shape {array.shape}; {mode!r} with {count} cells needs {expected}")
    array = array.astype(np.float64, copy=False)
    bad = ~np.isfinite(array)
    if bad.any():
        row = int(np.argwhere(bad)[0][0])
        raise ActionError(
            f"action of cell {row} is {array[row].tolist()}; it must have finite numbers; numbers beyond [-1, 1] are "
            "clipped"
        )
    return np.minimum(np.maximum(array, -1.0), 1.0)


def pad_residual(residual: Floats, size: int) -> Floats:
    """Residuals (N, size) from residuals (N, A), with zeros for the numbers that an action mode leaves out."""
    return np.concatenate([residual, np.zeros((len(residual), size - residual.shape[1]))], axis=1)


def quarter_names(x: Floats, y: Floats, middle: Sequence[float], names: tuple[str, str]) -> list[str]:
    """Names of the quarters of an area in which points (N,) lie.

    Args:
        x: x of the points (N,).
        y: y of the points (N,).
        middle: x, y of the area's middle.
        names: names of the area's far and near half along y.
    """
    right, far = x > middle[0], y > middle[1]
    return [f"{'right' if r else 'left'}-{names[0] if f else names[1]}" for r, f in zip(right, far, strict=True)]


def require_feasible(plans: Plans) -> None:
    """Make sure that the plans of all cells are feasible.

    Raises:
        PlanningError: the plan of a cell is not feasible.
    """
    if not plans.feasible.all():
        row = int((~plans.feasible).nonzero()[0][0])
        raise PlanningError(f"the plan of cell {row} is not feasible; throw only plans whose `feasible` is True")
