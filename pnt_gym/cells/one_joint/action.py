"""The one-joint thrower's residual: an action in [-1, 1] corrects a planned throw; zero is the plan itself.

Two modes, on the same planner:

* `virtual_goal` (4 numbers): the goal x, y, phi, dy is moved and the throw planned from scratch, as in Miyashita et al.
  Each number moves one error of the drag-free throw one to one.
* `release_state` (3 numbers): angle and speed of the arm and radius of the object at the release are moved by raw
  amounts, and the arm's motion is planned for them.
"""

from __future__ import annotations

from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Ints
from pnt_gym.cells.base.action import ActionMode, Correction, by_name, mode_of, pad_residual, quarter_names
from pnt_gym.cells.one_joint.config import OneJointConfig
from pnt_gym.cells.one_joint.context import Context
from pnt_gym.cells.one_joint.observation import decode
from pnt_gym.cells.one_joint.planner import ThrowPlanner
from pnt_gym.cells.one_joint.tasks import Job
from pnt_gym.planning.one_joint import ThrowPlans

ERRORS: Final = ("error_x", "error_y", "error_phi", "error_dy")
EXPLORATION: Final = 0.05
"""Standard deviation of the noise that a learner adds in practice, as a share of an action of 1."""


MODES: Final = by_name(
    ActionMode[ThrowPlanner, Context, ThrowPlans](
        "virtual_goal",
        ("goal along x", "goal up", "angle of the goal", "vertical speed of the goal"),
        lambda config: config.action.goal_scale(),
        lambda planner, context, residual: planner.plan(context.goal + residual, context.part),
        ERRORS,
    ),
    ActionMode[ThrowPlanner, Context, ThrowPlans](
        "release_state",
        ("angle of the arm at the release", "its speed there", "radius of the object on the arm"),
        lambda config: config.action.release_scale(),
        # The planned flight time does not change the arm's motion; it stays in `u` as the expected time of arrival.
        lambda planner, context, residual: planner.plan_releases(
            context.plans.u + pad_residual(residual, 4), context.part
        ),
    ),
)


def correction(config: OneJointConfig, job: Job, mode: str) -> Correction | None:
    """Meaning of an action as an offset of the errors in x, y, phi and dy; None where it has no such meaning."""
    own = mode_of(MODES, mode)
    if not own.errors:
        return None
    near, scale = config.tolerance, own.scale(config)
    return Correction(
        errors=ERRORS,
        scale=scale,
        exploration=EXPLORATION * scale,
        tolerance=np.array([near.position, near.position, np.deg2rad(near.angle_deg), near.speed]),
        buckets=partial(_buckets, job),
    )


def _buckets(job: Job, features: NDArray[np.float32], kind: Ints) -> list[tuple[str, str]]:
    """Kind of each throw and, for goals from a region, the quarter of the region in which the goal lies."""
    names = [job.names[int(k)] for k in kind]
    if job.region is None:
        return [(name, "here") for name in names]
    features_by_name = decode(features)
    middle = float(np.mean(job.region.x)), float(np.mean(job.region.y))
    places = quarter_names(features_by_name["goal_x"], features_by_name["goal_y"], middle, ("high", "low"))
    return list(zip(names, places, strict=True))
