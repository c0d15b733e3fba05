"""The cell of the one-joint thrower: N arms that throw in step."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, ClassVar, Final, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, Ints, recompute_rows, replace_rows
from pnt_gym.cells.base.action import Correction, require_feasible
from pnt_gym.cells.base.cell import Cell
from pnt_gym.cells.base.view import ThrowView
from pnt_gym.cells.one_joint.action import MODES, correction
from pnt_gym.cells.one_joint.config import GoalRegion, OneJointConfig
from pnt_gym.cells.one_joint.context import Context
from pnt_gym.cells.one_joint.hidden import draw_hidden, expected_hidden
from pnt_gym.cells.one_joint.observation import HIDDEN, TABLE
from pnt_gym.cells.one_joint.outcome import Outcome, judge
from pnt_gym.cells.one_joint.pallets import SWEEP, stack_pose
from pnt_gym.cells.one_joint.planner import ThrowPlanner
from pnt_gym.cells.one_joint.plant import OneJointPlant
from pnt_gym.cells.one_joint.tasks import Job
from pnt_gym.cells.one_joint.view import DOTS, camera
from pnt_gym.engine import MjData, MjModel
from pnt_gym.errors import ConfigError
from pnt_gym.planning.one_joint import ThrowPlans

CANDIDATES: Final = 24
"""Goals drawn at once from a region; the first suitable one is used. About every seventeenth goal is suitable."""
MOST_DRAWS: Final = 50
"""Draws in a row before the cell is declared impossible."""


@final
class OneJointCell(Cell[OneJointConfig, Context, ThrowPlans, Outcome]):
    """N cells in step: `context` holds the coming throws, `throw` carries them out and draws the next ones.

    In an assembly a second part follows only after a success of the first; after a failure the pallet is cleared.

    Args:
        config: level of the cell.
        count: number of cells N.
        threads: worker threads of the physics; results do not depend on their number.

    Raises:
        ConfigError: no goal of the level is in the arm's reach.
    """

    modes = MODES
    reward_terms: ClassVar[tuple[str, ...]] = ("position", "angle", "speed", "success")
    table = TABLE
    hidden = HIDDEN

    def __init__(self, config: OneJointConfig, count: int, threads: int = 1) -> None:
        super().__init__(config, count, threads)
        self.job = Job.of(config)
        self.item_names = self.target_names = self.job.names
        self.episode = len(self.job.targets) if self.job.in_order else 1
        self.planner = ThrowPlanner(config, self.job)
        self.plant = OneJointPlant(config, count, threads)
        self._goals = np.stack([target.state for target in self.job.targets])
        self._parts = np.array([target.part for target in self.job.targets])
        reached = None if self.job.region is not None else self.planner.plan(self._goals, self._parts).feasible
        if reached is not None and not reached.all():
            target = self.job.targets[int(reached.argmin())]
            x, y, phi, dy = target.state
            raise ConfigError(
                f"cell {config.name!r}: goal {target.name!r} (x {x:g} m, y {y:g} m, phi {np.rad2deg(phi):g} deg, "
                f"dy {dy:g} m/s) is out of the arm's reach"
            )
        self.context = self.first(np.arange(count))

    def preview(self, plans: ThrowPlans, jitter: bool = False) -> Outcome:
        """Outcome of the coming throws; `jitter` adds the throw's scatter and the camera's noise.

        Raises:
            PlanningError: a plan is not feasible.
        """
        require_feasible(plans)
        context = self.context
        if not jitter:
            context = replace(context, hidden=expected_hidden(self.count, self.config))
        flight = self.plant.fly(context, plans)
        return judge(flight, context, plans, self.job, self.config, self.planner.return_time(plans))

    def reward(self, outcome: Outcome) -> dict[str, Floats]:
        """Weighted reward terms by name, each (N,); before weighting every term lies in [0, 1]."""
        weights = self.config.reward
        angle, speed = np.abs(outcome.true_error[:, 2]), np.abs(outcome.true_error[:, 3])
        return {
            "position": weights.position * np.maximum(1.0 - outcome.landing_error / weights.position_scale, 0.0),
            "angle": weights.angle * np.maximum(1.0 - np.rad2deg(angle) / weights.angle_scale_deg, 0.0),
            "speed": weights.speed * np.maximum(1.0 - speed / weights.speed_scale, 0.0),
            "success": weights.success * outcome.is_success.astype(np.float64),
        }

    def info(self, outcome: Outcome, throws: Context) -> dict[str, NDArray[Any]]:
        """Infos of throws that only the one-joint cell has, (N,) each."""
        info = {
            "error_x": outcome.error_x,
            "error_y": outcome.error_y,
            "error_phi": outcome.error_phi,
            "error_dy": outcome.error_dy,
            "angle_error": outcome.true_error[:, 2],
            "speed_error": outcome.true_error[:, 3],
            "peak_torque": outcome.peak_torque,
            "target_x": outcome.goal[:, 0].copy(),
            "target_y": outcome.goal[:, 1].copy(),
        }
        if self.job.pallets:
            info |= {"in_pallet": outcome.in_pallet, "touched_other": outcome.touched_other}
        if self.job.in_order:
            info |= {"is_complete": outcome.is_success & (throws.kind == len(self.job.targets) - 1)}
        return info

    def ends_early(self, outcome: Outcome, throws: Context) -> Bools:
        """Whether the sequence is over (N,): without a first part in place no second part can be thrown onto it."""
        return ~outcome.is_success

    def correction(self, mode: str) -> Correction | None:
        """Meaning of an action as an offset of the errors; None where it has no such meaning."""
        return correction(self.config, self.job, mode)

    def view(self) -> ThrowView:
        """Pictures of the cells; row 0 is recorded from now on."""
        return ThrowView(self, camera(), DOTS)

    def pose(self, row: int) -> tuple[MjModel, MjData]:
        """Model and data of one simulation as it stands before the coming throw."""
        context = self.context
        u, height = context.plans.u, np.array([part.half_height for part in self.job.parts])[context.part]
        radius = np.sqrt(u[:, 2] ** 2 - height**2) + context.hidden.radius
        self.plant.write(context.plans.motion.start_angle, context.part, radius, context.lying)
        return self.plant.current_state(row)

    def target(self, row: int) -> Floats:
        """Goal of the coming throw (3,) [m]."""
        x, y = self.context.goal[row, :2]
        return np.array([x, 0.0, y])

    def first(self, rows: Ints) -> Context:
        """First throws of some rows, with empty pallets."""
        lying = np.full((len(rows), len(self.job.parts), 3), np.nan)
        return self._draw(rows, np.zeros(len(rows), dtype=np.int64), lying)

    def following(self, outcome: Outcome) -> Context:
        """New throws; in an assembly, the second part where the first one lies in place."""
        rows, lying = np.arange(self.count), np.full_like(self.context.lying, np.nan)
        kind = np.zeros(self.count, dtype=np.int64)
        if self.job.in_order:
            goes_on = outcome.is_success & (self.context.kind + 1 < len(self.job.targets))
            kind = np.where(goes_on, self.context.kind + 1, 0)
            lying[goes_on, 0] = outcome.final[goes_on, 0]
        return self._draw(rows, kind, lying)

    def _draw(self, rows: Ints, kind: Ints, lying: Floats) -> Context:
        """Coming throws of some rows; kinds (N,) count only in an assembly."""
        if self.job.region is not None:
            goal, plans, suitable = self._attempt(rows, self.job.region)
            for _ in range(MOST_DRAWS):
                pending = np.flatnonzero(~suitable)
                if pending.size == 0:
                    break
                goal[pending], new_plans, suitable[pending] = self._attempt(rows[pending], self.job.region)
                plans = replace_rows(plans, pending, new_plans)
            else:
                raise ConfigError(f"cell {self.config.name!r}: no goal of goals.region is in the arm's reach")
        else:
            if not self.job.in_order:
                target_count = len(self.job.targets)
                kind = np.array([self.generators[int(r)].integers(target_count) for r in rows], dtype=np.int64)
            goal, plans = self._aim(kind, lying)
        hidden = draw_hidden([self.generators[int(r)] for r in rows], self.config)
        return Context(kind, self._parts[kind], goal, self._goals[kind], plans, lying, hidden)

    def _aim(self, kind: Ints, lying: Floats) -> tuple[Floats, ThrowPlans]:
        """Goals of the kinds and their plans; a second part is aimed at the first part as that part lies."""
        part, goal = self._parts[kind], self._goals[kind]
        follows = ~np.isnan(lying[:, 0, 0])
        goals = goal.copy()
        pose, planned = lying[follows, 0], self.job.targets[0].state
        # Whole turns bring the first part's angle nearest to the planned one.
        pose[:, 2] += 2.0 * np.pi * np.round((planned[2] - pose[:, 2]) / (2.0 * np.pi))
        goals[follows, :3] = stack_pose(pose)
        plans = self.planner.plan(goals, part)
        # Where the first part has tilted its seat out of reach, the throw is planned for an exact seat.
        goals[~plans.feasible] = goal[~plans.feasible]
        return goals, recompute_rows(plans, ~plans.feasible, self.planner.plan, goal, part)

    def _attempt(self, rows: Ints, region: GoalRegion) -> tuple[Floats, ThrowPlans, Bools]:
        """First suitable goal of several draws per row, its plan, and whether the goal is suitable."""
        low, high = region.bounds()
        share = np.stack([self.generators[int(row)].random((CANDIDATES, 4)) for row in rows])
        goals: Floats = low + (high - low) * share
        # Nearer to the pivot the arm would be in the way of the arriving part.
        suitable = np.hypot(goals[..., 0], goals[..., 1]) >= SWEEP + self.job.parts[0].reach
        suitable[suitable] = self.planner.has_reserve(goals[suitable], region.reserve)
        every, first = np.arange(len(rows)), suitable.argmax(axis=1)
        goal = goals[every, first]
        plans = self.planner.plan(goal, np.zeros(len(rows), dtype=np.int64))
        return goal, plans, plans.feasible & suitable[every, first]
