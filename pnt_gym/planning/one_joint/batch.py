"""Plans of many throws at once, from a family of simple motions.

A release fixes angle and speed at the end of a motion from rest. The duration and the shape of the acceleration remain
to be chosen. The acceleration is linear between the borders of the spline's n intervals, so a motion of the family is
exactly a spline of Miyashita et al., Eq. 13. The first shapes rise from the static start to an acceleration that
is constant, grows or falls; where no such shape keeps all limits, shapes that swing back first are tried. The plan is
the motion with the best margins, with a refined duration.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final, get_args

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Bools, Floats, Ints, take
from pnt_gym.errors import PlanningError
from pnt_gym.names import unknown_name
from pnt_gym.planning.one_joint.family import Objective, Task, best_motions, keeps_limits
from pnt_gym.planning.one_joint.feasibility import ThrowReason, arm_radius, first_reason
from pnt_gym.planning.one_joint.flight import land
from pnt_gym.planning.one_joint.landing import release_states_batch, rows_of_four
from pnt_gym.planning.one_joint.motion import ArmMotion
from pnt_gym.planning.one_joint.parameters import Arm, Block, arm_and_block
from pnt_gym.planning.one_joint.weights import WeightName, weights_of


@final
@dataclass(frozen=True, eq=False)
class ThrowPlans:
    """Plans of N throws; rows without a plan hold NaN.

    Attributes:
        goal: landing states (N, 4) = x, y [m], phi [rad], dy [m/s].
        u: releases (N, 4) = theta_t [rad], omega_t [rad/s], l_t [m], t_f [s].
        motion: motions of the arm, N rows.
        feasible: whether there is a plan (N,).
        reason: `ThrowReason` (N,).
        margins: smallest margins of each motion at 1 kHz (N, 6), as shares (see `margins`).
        radius: r, distance of the block from the pivot along the arm (N,) [m].
    """

    goal: Floats
    u: Floats
    motion: ArmMotion
    feasible: Bools
    reason: Ints
    margins: Floats
    radius: Floats


def plan_throws(
    goals: ArrayLike,
    *,
    arm: Arm | None = None,
    block: Block | None = None,
) -> ThrowPlans:
    """Return a plan for each goal (N, 4), all at once; a row's result does not depend on the other rows.

    Args:
        goals: x, y [m], phi [rad], dy [m/s].
        arm: the arm; the paper's when not given.
        block: the block; the paper's when not given.

    Raises:
        ValueError: the shape is not (N, 4) or a number is not finite.
    """
    arm, block = arm_and_block(arm, block)
    releases = release_states_batch(rows_of_four(goals, "goals"), arm=arm, block=block)
    task = Task(releases.u, arm_radius(releases.u, block.half_height), arm, block)
    return _plan(releases.goal, releases.reason, task)


def plan_releases(
    u: ArrayLike,
    *,
    arm: Arm | None = None,
    block: Block | None = None,
    objective: Objective = "max_min",
    weights: WeightName | ArrayLike = "balanced",
    static_start: bool = True,
) -> ThrowPlans:
    """Return a plan for each release (N, 4) = theta_t, omega_t, l_t, t_f, as `plan_throws` does for goals.

    Args:
        u: releases (N, 4).
        arm: the arm; the paper's when not given.
        block: the block; the paper's when not given.
        objective: criterion by which each plan's motion is chosen.
        weights: a name or six numbers, for the objective "squares".
        static_start: whether the block must rest on the arm without tipping before the throw.

    Raises:
        ValueError: the shape is not (N, 4), a number is not finite, or the weights are not known.
    """
    arm, block = arm_and_block(arm, block)
    releases = rows_of_four(u, "u")
    if objective not in get_args(Objective):
        raise PlanningError(unknown_name("objective", objective, get_args(Objective)))
    reason, _ = first_reason(releases, arm, block)
    whole = releases[:, 2] > block.half_height
    goal = np.full_like(releases, np.nan)
    goal[whole] = land(releases[whole], block.half_height)
    task = Task(
        releases,
        arm_radius(releases, block.half_height),
        arm,
        block,
        objective,
        tuple(weights_of(weights).tolist()),
        static_start,
    )
    return _plan(goal, reason, task)


def _plan(goal: Floats, reason: Ints, task: Task) -> ThrowPlans:
    rows = np.nonzero(reason == ThrowReason.FEASIBLE)[0]
    motion, margins = best_motions(take(task, rows))
    good = keeps_limits(margins)
    reason = reason.copy()
    reason[rows[~good]] = int(ThrowReason.NO_MOTION)
    columns = list[Floats]()
    for values in (motion.knots, motion.time_step, motion.braking, margins, task.radius[rows]):
        column = np.full((len(goal), *values.shape[1:]), np.nan)
        column[rows[good]] = values[good]
        columns.append(column)
    feasible = reason == ThrowReason.FEASIBLE
    u = np.where(feasible[:, None], task.u, np.nan)
    return ThrowPlans(goal, u, ArmMotion(*columns[:3]), feasible, reason, *columns[3:])
