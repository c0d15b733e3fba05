"""The one-joint thrower's residual: an action in [-1, 1] corrects a planned throw; zero is the plan itself.

Two modes, on the same planner:

* `virtual_goal` (4 numbers): the goal x, y, phi, dy is moved and the throw planned from scratch, as in Miyashita et al.
  2010. Each number moves one error of the drag-free throw one to one.
* `release_state` (3 numbers): angle and speed of the arm and radius of the object at the release are moved by raw
  amounts, and the arm's motion is planned for them.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Final, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from pnt_gym.cells.pallet.cell import PalletCell
from pnt_gym.cells.pallet.config import Action, PalletConfig
from pnt_gym.cells.pallet.observation import decode
from pnt_gym.cells.pallet.planner import ThrowPlanner
from pnt_gym.cells.pallet.tasks import Job
from pnt_gym.correction import Correction, nearest_feasible
from pnt_gym.planning.arrays import Bools, Floats, Ints
from pnt_gym.planning.one_joint import ThrowPlans
from pnt_gym.rows import put

GoalMode: TypeAlias = Literal["virtual_goal", "release_state"]
GOAL_MODES: Final[tuple[GoalMode, ...]] = ("virtual_goal", "release_state")
ACTION_SIZE: Final = {"virtual_goal": 4, "release_state": 3}
SHIFT_MODES: Final[tuple[GoalMode, ...]] = ("virtual_goal",)
"""Modes in which an action moves the errors of the drag-free throw one to one."""

_EXPLORATION: Final = 0.05
"""Standard deviation of what a learner adds in practice, as a share of an action of 1."""


def corrected_plans(mode: GoalMode, actions: Floats, cell: PalletCell, action: Action) -> tuple[ThrowPlans, Bools]:
    """Feasible plans nearest to what actions ask for, and which actions had to be shortened (N,).

    Args:
        mode: how an action is read.
        actions: (N, size) within [-1, 1].
        cell: the coming throws and their planner.
        action: what an action of 1 means.
    """
    context, planner = cell.context, cell.planner

    def plans(part: Floats, rows: Ints) -> ThrowPlans:
        if mode == "virtual_goal":
            return planner.plan(context.goal[rows] + part * action.goal_scale(), context.part[rows])
        # The planned flight time plays no part in how the arm moves; it stays to say when the object should arrive.
        change = np.concatenate([part * action.release_scale(), np.zeros((len(part), 1))], axis=1)
        return planner.plan_releases(context.plans.u[rows] + change, context.part[rows])

    found = plans(actions, np.arange(len(actions)))
    clipped = ~found.feasible
    rows = np.flatnonzero(clipped)
    if rows.size > 0:  # the search plans a dozen times: only for those that need it
        shortened, _ = nearest_feasible(lambda part: plans(part, rows), lambda made: made.feasible, actions[rows])
        put(found, rows, shortened)
    return found, clipped


def goal_correction(config: PalletConfig, job: Job, mode: GoalMode) -> Correction | None:
    """How an action shifts the errors in x, y, phi and dy; None where it has no such meaning."""
    if mode not in SHIFT_MODES:
        return None
    near = config.tolerance
    scale = config.action.goal_scale()
    return Correction(
        errors=("error_x", "error_y", "error_phi", "error_dy"),
        scale=scale,
        exploration=_EXPLORATION * scale,
        tolerance=np.array([near.position, near.position, np.deg2rad(near.angle_deg), near.speed]),
        cells=partial(_table_cells, job),
        possible=partial(_have_plans, ThrowPlanner(config, job), scale, [target.part for target in job.targets]),
    )


def _have_plans(
    planner: ThrowPlanner, scale: Floats, parts: Sequence[int], features: NDArray[np.float32], kind: int, shift: Floats
) -> Bools:
    """Which shifts (M, 4) of a throw's goal have a plan, by the goal as it is seen."""
    seen = decode(features)
    goal = np.array([seen["goal_x"], seen["goal_y"], seen["goal_phi"], seen["goal_dy"]])
    return planner.plan(goal + shift * scale, np.full(len(shift), parts[kind])).feasible


def _table_cells(job: Job, features: NDArray[np.float32], kind: Ints) -> list[tuple[str, str]]:
    """The kind of each throw, and with goals from a region the quarter of it that the goal lies in."""
    names = [job.names[int(k)] for k in kind]
    if job.region is None:
        return [(name, "here") for name in names]
    seen = decode(features)
    right, high = seen["goal_x"] > np.mean(job.region.x), seen["goal_y"] > np.mean(job.region.y)
    places = [f"{'right' if r else 'left'}-{'high' if h else 'low'}" for r, h in zip(right, high, strict=True)]
    return list(zip(names, places, strict=True))
