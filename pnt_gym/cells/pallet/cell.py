"""The one-joint thrower's cell: N arms, throwing in step."""

from __future__ import annotations

from dataclasses import replace
from typing import Final, final

import numpy as np

from pnt_gym.cells.pallet.config import GoalRegion, PalletConfig
from pnt_gym.cells.pallet.context import Context
from pnt_gym.cells.pallet.flight import Flight
from pnt_gym.cells.pallet.hidden import draw_hidden, expected_hidden
from pnt_gym.cells.pallet.measure import estimated_state
from pnt_gym.cells.pallet.outcome import Outcome, judge
from pnt_gym.cells.pallet.pallets import SWEEP, stacked
from pnt_gym.cells.pallet.planner import ThrowPlanner
from pnt_gym.cells.pallet.plant import PalletPlant
from pnt_gym.cells.pallet.tasks import job_of
from pnt_gym.engine import MjData, MjModel
from pnt_gym.errors import ConfigError
from pnt_gym.planning.arrays import Bools, Floats, Ints
from pnt_gym.planning.one_joint import ThrowPlans
from pnt_gym.rows import put

CANDIDATES: Final = 24
"""Goals drawn at once from a region, the first of which that will do is taken; about every seventeenth will."""
MOST_DRAWS: Final = 50
"""Draws in a row before the cell is declared impossible."""

Generators = list[np.random.Generator]


@final
class PalletCell:
    """N cells in step: `context` holds the coming throws, `throw` carries them out and brings the next.

    In an assembly a second part follows only on a first that lies well; after a failure the pallet is cleared.

    Args:
        config: the cell.
        count: number of cells N.
        threads: worker threads of the physics; results do not depend on it.

    Raises:
        ConfigError: no goal of the config is in the arm's reach.
    """

    def __init__(self, config: PalletConfig, count: int, threads: int = 1) -> None:
        self.config, self.count = config, count
        self.job = job_of(config)
        self.planner = ThrowPlanner(config, self.job)
        self.plant = PalletPlant(config, self.job, count, threads)
        self._check_targets()
        self._generators: Generators = [np.random.default_rng(0) for _ in range(count)]
        self.context: Context = self._first(np.arange(count))

    def reset(self, rows: Ints, generators: Generators) -> None:
        """Begin anew in some rows, each with its own generator, with nothing in the pallets."""
        for row, generator in zip(rows, generators, strict=True):
            self._generators[int(row)] = generator
        put(self.context, rows, self._first(rows))

    def plan(self, goal: Floats) -> ThrowPlans:
        """Plans of the coming throws to other goals (N, 4), feasible or not: a virtual goal."""
        return self.planner.plan(goal, self.context.part)

    def plan_releases(self, u: Floats) -> ThrowPlans:
        """Plans of the coming throws with given release states (N, 4), feasible or not."""
        return self.planner.plan_releases(u, self.context.part)

    def throw(self, plans: ThrowPlans, clipped: Bools) -> Outcome:
        """Throw in every cell and move on to the next throws.

        Args:
            plans: feasible plans, one per cell.
            clipped: which of them are shortened corrections (N,), passed on to the outcome.

        Raises:
            ValueError: a plan is not feasible.
        """
        flight = self._fly(plans, jitter=True)
        outcome = replace(self._judged(plans, flight, jitter=True), clipped=clipped)
        self.context = self._next(outcome)
        return outcome

    def preview(self, plans: ThrowPlans, jitter: bool = False) -> Outcome:
        """What the coming throws would do, without moving on.

        Args:
            plans: feasible plans, one per cell.
            jitter: whether the throw's own scatter and the camera's noise are included, as `throw` will have them.

        Raises:
            ValueError: a plan is not feasible.
        """
        return self._judged(plans, self._fly(plans, jitter), jitter)

    def pose(self, row: int) -> tuple[MjModel, MjData]:
        """Model and data of one simulation as it stands before the coming throw, for a picture."""
        context = self.context
        u, height = context.plans.u, np.array([part.half_height for part in self.job.parts])[context.part]
        radius = np.sqrt(u[:, 2] ** 2 - height**2) + context.hidden.radius
        self.plant.write(context.plans.motion.start_angle, context.part, radius, context.lying)
        return self.plant.pose(row)

    def _check_targets(self) -> None:
        if self.job.region is not None:
            return
        goals = np.stack([target.state for target in self.job.targets])
        plans = self.planner.plan(goals, np.array([target.part for target in self.job.targets]))
        for target, fits in zip(self.job.targets, plans.feasible, strict=True):
            if not fits:
                x, y, phi, dy = target.state
                raise ConfigError(
                    f"cell {self.config.name!r}: goal {target.name!r} (x {x:g} m, y {y:g} m, phi {np.rad2deg(phi):g} "
                    f"deg, dy {dy:g} m/s) is out of the arm's reach"
                )

    def _fly(self, plans: ThrowPlans, jitter: bool) -> Flight:
        if not plans.feasible.all():
            row = int(np.flatnonzero(~plans.feasible)[0])
            raise ValueError(f"the plan of cell {row} is not feasible; throw only plans whose `feasible` is True")
        context = self.context
        hidden = context.hidden if jitter else expected_hidden(self.count, self.config)
        return self.plant.throw(plans, context.part, context.lying, hidden, context.goal)

    def _judged(self, plans: ThrowPlans, flight: Flight, jitter: bool) -> Outcome:
        context, config = self.context, self.config
        weights = config.scale.weights()
        true = flight.nearest(context.goal, weights)
        noise = context.hidden.noise if jitter else np.zeros_like(context.hidden.noise)
        verdict = judge(self.job, context.kind, flight, true - context.goal, config.tolerance)
        arrival = flight.release_time + plans.u[:, 3]
        return Outcome(
            goal=context.goal.copy(),
            measured=estimated_state(flight, plans.u[:, 3], context.goal, noise, config),
            true=true,
            is_success=verdict.is_success,
            in_pallet=verdict.in_pallet,
            touched_other=verdict.touched_other,
            cycle_time=np.maximum(arrival, plans.motion.stop_time + self.planner.return_time(plans)),
            peak_torque=flight.peak_torque,
            release_speed_error=flight.release_speed - plans.u[:, 1],
            clipped=np.zeros(self.count, dtype=np.bool_),
            final=flight.final_pose,
        )

    def _first(self, rows: Ints) -> Context:
        """First throws of some rows."""
        lying = np.full((len(rows), len(self.job.parts), 3), np.nan)
        return self._drawn(rows, np.zeros(len(rows), dtype=np.int64), lying)

    def _next(self, outcome: Outcome) -> Context:
        rows, lying = np.arange(self.count), np.full_like(self.context.lying, np.nan)
        kind = np.zeros(self.count, dtype=np.int64)
        if self.job.in_order:
            goes_on = outcome.is_success & (self.context.kind + 1 < len(self.job.targets))
            kind = np.where(goes_on, self.context.kind + 1, 0)
            lying[goes_on, 0] = outcome.final[goes_on, 0]
        return self._drawn(rows, kind, lying)

    def _drawn(self, rows: Ints, kind: Ints, lying: Floats) -> Context:
        """The coming throws of some rows; kinds (N,) count only where they follow each other."""
        if self.job.region is not None:
            goal, plans = self._in_region(rows, self.job.region)
        else:
            if not self.job.in_order:
                most = len(self.job.targets)
                kind = np.array([self._generators[int(r)].integers(most) for r in rows], dtype=np.int64)
            goal, plans = self._aimed(kind, lying)
        part = np.array([target.part for target in self.job.targets])[kind]
        hidden = draw_hidden([self._generators[int(r)] for r in rows], self.config)
        return Context(kind, part, goal, plans, lying, hidden)

    def _aimed(self, kind: Ints, lying: Floats) -> tuple[Floats, ThrowPlans]:
        """Goals of the kinds; a second part is aimed at the first one as it lies."""
        part = np.array([target.part for target in self.job.targets])[kind]
        goal = np.stack([target.state for target in self.job.targets])[kind]
        follows = ~np.isnan(lying[:, 0, 0])
        aimed = goal.copy()
        aimed[follows, :3] = stacked(_unwrapped(lying[follows, 0], self.job.targets[0].state[2]))
        plans = self.planner.plan(aimed, part)
        missed = np.flatnonzero(~plans.feasible)
        if missed.size > 0:
            # The seat has tilted out of reach; the goal of an exact seat is planned for.
            aimed[missed] = goal[missed]
            put(plans, missed, self.planner.plan(goal[missed], part[missed]))
        return aimed, plans

    def _in_region(self, rows: Ints, region: GoalRegion) -> tuple[Floats, ThrowPlans]:
        """A goal per row, drawn from its own generator until it is well in reach."""
        goal, plans, good = self._attempt(rows, region)
        for _ in range(MOST_DRAWS):
            pending = np.flatnonzero(~good)
            if pending.size == 0:
                return goal, plans
            goal[pending], found, good[pending] = self._attempt(rows[pending], region)
            put(plans, pending, found)
        raise ConfigError(f"cell {self.config.name!r}: no goal of goals.region is in the arm's reach")

    def _attempt(self, rows: Ints, region: GoalRegion) -> tuple[Floats, ThrowPlans, Bools]:
        """One of several goals per row, its plan, and whether it will do."""
        low, high = region.bounds()
        share = np.stack([self._generators[int(row)].random((CANDIDATES, 4)) for row in rows])
        goals: Floats = low + (high - low) * share
        # Nearer to the pivot the arm would be in the way of what arrives.
        good = np.hypot(goals[..., 0], goals[..., 1]) >= SWEEP + self.job.parts[0].reach
        good[good] = self.planner.has_reserve(goals[good], region.reserve)
        every, first = np.arange(len(rows)), good.argmax(axis=1)
        goal = goals[every, first]
        plans = self.planner.plan(goal, np.zeros(len(rows), dtype=np.int64))
        return goal, plans, plans.feasible & good[every, first]


def _unwrapped(pose: Floats, phi: float) -> Floats:
    """Poses (N, 3) with the whole turns that bring their angle nearest to phi [rad]."""
    turned = pose.copy()
    turned[:, 2] += 2.0 * np.pi * np.round((phi - pose[:, 2]) / (2.0 * np.pi))
    return turned
