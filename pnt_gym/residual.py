"""The conveyor's residual: an action in [-1, 1] corrects the release of a plan; zero is the plan itself.

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

from functools import partial
from typing import Final, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from pnt_gym.cells.context import Context
from pnt_gym.cells.movers import Mover
from pnt_gym.cells.observation import decode
from pnt_gym.config import ActionScale, CellConfig
from pnt_gym.correction import Correction, limited_actions
from pnt_gym.planning.arrays import Floats, Ints
from pnt_gym.planning.plan import ReleaseBatch

ActionMode: TypeAlias = Literal["release_point", "release_xyz", "virtual_goal"]
ACTION_MODES: Final[tuple[ActionMode, ...]] = ("release_point", "release_xyz", "virtual_goal")
ACTION_SIZE: Final = {"release_point": 2, "release_xyz": 3, "virtual_goal": 2}

SHIFT_MODES: Final[tuple[ActionMode, ...]] = ("release_point", "virtual_goal")
"""Modes in which an action moves the drag-free landing one to one."""

_EXPLORATION: Final = (0.015, 0.0075)
"""Standard deviation of the shift that a learner adds in practice, along and across [m]."""


def check_actions(actions: object, count: int, mode: ActionMode) -> Floats:
    """Actions as a float64 array (count, size), clipped to [-1, 1].

    Raises:
        ActionError: wrong shape, or NaN or infinite values.
    """
    return limited_actions(actions, count, ACTION_SIZE[mode], mode)


def corrected_release(
    mode: ActionMode, actions: Floats, context: Context, scale: ActionScale, ceiling_slack: float, mover: Mover
) -> ReleaseBatch:
    """The releases that actions ask for, feasible or not (see `correction.nearest_feasible`).

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


def shift_correction(config: CellConfig, mode: ActionMode) -> Correction | None:
    """How an action shifts the landing along and across the throw; None where it has no such meaning."""
    if mode not in SHIFT_MODES:
        return None
    return Correction(
        errors=("landing_along", "landing_across"),
        scale=np.array([config.action.along, config.action.across]),
        exploration=np.array(_EXPLORATION),
        tolerance=np.ones(2),
        cells=partial(_table_cells, config),
    )


def _table_cells(config: CellConfig, features: NDArray[np.float32], kind: Ints) -> list[tuple[str, str]]:
    """Item and bin of each throw: the bin's name, or the quarter that a random bin is drawn in."""
    seen = decode(features)
    x, y = seen["target_x"], seen["target_y"]
    if config.bins.random is not None:
        area = config.bins.random
        right, far = x > np.mean(area.x), y > np.mean(area.y)
        places = [f"{'right' if r else 'left'}-{'far' if f else 'near'}" for r, f in zip(right, far, strict=True)]
    else:
        bins = config.bins.fixed
        gap = np.hypot(x[:, None] - [b.x for b in bins], y[:, None] - [b.y for b in bins])
        places = [bins[int(i)].name for i in gap.argmin(axis=1)]
    return [(config.items[k], place) for k, place in zip(kind, places, strict=True)]


def _moved_point(shift: Floats, context: Context) -> Floats:
    """The nominal release points (N, 3) moved along, sideways and up [m]."""
    sideways = context.from_throw_frame(shift[:, 0], shift[:, 1])
    return context.plan.position + np.concatenate([sideways, shift[:, 2:3]], axis=1)
