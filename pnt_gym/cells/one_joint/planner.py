"""Plans of many throws at once, each with its own part on the arm."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, recompute_rows
from pnt_gym.cells.one_joint.config import OneJointConfig
from pnt_gym.cells.one_joint.parts import block
from pnt_gym.cells.one_joint.tasks import Job
from pnt_gym.planning.one_joint import ThrowPlans, ThrowReason, plan_releases, plan_throws, release_states_batch
from pnt_gym.planning.one_joint.feasibility import first_reason
from pnt_gym.planning.one_joint.grasp import braking_acceleration
from pnt_gym.planning.one_joint.parameters import Arm, Block


@final
class ThrowPlanner:
    """The analytic planner of a cell: it models arm and parts, and none of the mismatch.

    Args:
        config: level of the cell.
        job: parts of the task.
    """

    def __init__(self, config: OneJointConfig, job: Job) -> None:
        self.arm: Arm = config.arm.arm()
        self.blocks: tuple[Block, ...] = tuple(block(part) for part in job.parts)

    def plan(self, goal: Floats, part: Ints) -> ThrowPlans:
        """Plans of throws of parts (N,) to goals (N, 4); rows out of reach are marked infeasible."""
        return self._per_part(partial(plan_throws, arm=self.arm), goal, part)

    def plan_releases(self, u: Floats, part: Ints) -> ThrowPlans:
        """Plans of throws of parts (N,) with release states (N, 4) theta_t, omega_t, l_t, t_f."""
        return self._per_part(partial(plan_releases, arm=self.arm), u, part)

    def has_reserve(self, goal: Floats, delay: float) -> Bools:
        """Whether releases of the first part to goals (N, 4) are feasible, also with a compensated delay [s].

        A part that clings to the braking arm for the delay leaves as planned if the arm was faster by the lost speed,
        and back by the lost angle, when braking began. The motion to the release is not planned for this.
        """
        arm, part = self.arm, self.blocks[0]
        releases = release_states_batch(goal, arm=arm, block=part)
        rows = np.flatnonzero(releases.feasible)
        u = releases.u[rows].copy()
        brake = braking_acceleration(u[:, 1], arm)
        u[:, 0] -= delay * (u[:, 1] - 0.5 * delay * brake)
        u[:, 1] -= delay * brake
        reserve = np.zeros(len(goal), dtype=np.bool_)
        reserve[rows] = first_reason(u, arm, part)[0] == int(ThrowReason.FEASIBLE)
        return reserve

    def return_time(self, plans: ThrowPlans) -> Floats:
        """Shortest time from the arm's standstill back to its start, rest to rest (N,) [s].

        Computed with the torque at full speed, so that Eq. 10 holds all the way.
        """
        motion, rate = plans.motion, self.arm.torque_at_speed / self.arm.inertia
        way = np.abs(motion.stop_angle - motion.start_angle)
        ramp = self.arm.speed**2 / rate
        # Bang-bang motion at the constant acceleration `rate`: triangular speed 2 sqrt(s / a), or with a plateau s / v
        # + v / a.
        return np.where(way < ramp, 2.0 * np.sqrt(way / rate), way / self.arm.speed + self.arm.speed / rate)

    def _per_part(self, plan: Callable[..., ThrowPlans], goal: Floats, part: Ints) -> ThrowPlans:
        """Plans of all rows, computed part by part; their common `half_height` is the first part's."""
        plans = plan(goal, block=self.blocks[0])
        for k, b in enumerate(self.blocks[1:], start=1):
            plans = recompute_rows(plans, part == k, partial(plan, block=b), goal)
        return plans
