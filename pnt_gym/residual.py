"""Residual: an action in [-1, 1] corrects the release of a plan; zero is the plan itself.

Three modes, all on the same planner:

* `release_point` (2 numbers): the release point moves along the throw line and sideways at the planned elevation,
  by what moves the drag-free landing `action x (along, across)`. Well conditioned: one action unit is the same
  shift of the landing wherever the throw goes.
* `release_xyz` (3 numbers): the release point moves by raw metres along, sideways and up. The same centimetre may move
  the landing by one centimetre or by ten.
* `virtual_goal` (2 numbers): the target is moved and the throw planned from scratch, as in Miyashita et al. 2010.
  The minimum-time plan can jump between its flat and its steep branch when the goal moves a little.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, Literal, TypeAlias

import numpy as np

from pnt_gym.cells.context import Context
from pnt_gym.cells.movers import Mover
from pnt_gym.config import ActionScale
from pnt_gym.errors import ActionError
from pnt_gym.planning.arrays import Bools, Floats
from pnt_gym.planning.plan import ReleaseBatch

ActionMode: TypeAlias = Literal["release_point", "release_xyz", "virtual_goal"]
ACTION_MODES: Final[tuple[ActionMode, ...]] = ("release_point", "release_xyz", "virtual_goal")
ACTION_SIZE: Final = {"release_point": 2, "release_xyz": 3, "virtual_goal": 2}

_HALVINGS: Final = 12
"""Bisection of a residual that must shrink: to 1/4096 of its length."""


def check_actions(actions: object, count: int, mode: ActionMode) -> Floats:
    """Actions as a float64 array (count, size), clipped to [-1, 1].

    Raises:
        ActionError: wrong shape, or NaN or infinite values.
    """
    try:
        array = np.asarray(actions, dtype=np.float64)
    except (TypeError, ValueError):
        raise ActionError(f"action is {actions!r}; it must be an array of numbers") from None
    expected = (count, ACTION_SIZE[mode])
    if array.shape != expected:
        raise ActionError(f"action has shape {array.shape}; {mode!r} with {count} cells needs {expected}")
    bad = ~np.isfinite(array)
    if bad.any():
        row = int(np.argwhere(bad)[0][0])
        raise ActionError(f"action of cell {row} is {array[row].tolist()}; it must be finite and within [-1, 1]")
    return np.clip(array, -1.0, 1.0)


def corrected_release(
    mode: ActionMode, actions: Floats, context: Context, scale: ActionScale, ceiling_slack: float, mover: Mover
) -> ReleaseBatch:
    """The releases that actions ask for, feasible or not (see `nearest_feasible`).

    Args:
        mode: how an action is read.
        actions: (N, size) within [-1, 1].
        context: the N picks with their nominal plans.
        scale: what an action of 1 means.
        ceiling_slack: how far a corrected release may rise above the ceiling [m].
        mover: plans the releases.
    """
    if mode == "release_xyz":
        return mover.moved(context, _moved_point(actions * np.array(scale.xyz), context))
    shift = context.from_throw_frame(actions[:, 0] * scale.along, actions[:, 1] * scale.across)
    goal = context.target + np.concatenate([shift, np.zeros((len(shift), 1))], axis=1)
    if mode == "virtual_goal":
        return mover.plan(context.pick, goal, context.limits, context.ceiling)
    return mover.aimed(context, goal, ceiling_slack)


def nearest_feasible(
    plan: Callable[[Floats], ReleaseBatch], is_feasible: Callable[[ReleaseBatch], Bools], actions: Floats
) -> tuple[ReleaseBatch, Bools]:
    """The releases of the longest feasible part of each residual, and which residuals had to be shortened (N,).

    The nominal plan (zero) is feasible by construction, so shortening towards it ends at a feasible plan.

    Args:
        plan: actions (N, size) to releases.
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


def _moved_point(shift: Floats, context: Context) -> Floats:
    """The nominal release points (N, 3) moved along, sideways and up [m]."""
    sideways = context.from_throw_frame(shift[:, 0], shift[:, 1])
    return context.plan.position + np.concatenate([sideways, shift[:, 2:3]], axis=1)
