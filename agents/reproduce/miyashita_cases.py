"""The goal and the throws of Miyashita et al. 2010 that several parts of its reproduction use."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, NamedTuple, final

import numpy as np

from pnt_gym.cells.pallet.cell import PalletCell
from pnt_gym.cells.pallet.config import PalletConfig, load
from pnt_gym.cells.pallet.hidden import Hidden, draw_hidden
from pnt_gym.cells.pallet.measure import watch
from pnt_gym.cells.pallet.plant import PalletPlant, Plans
from pnt_gym.cells.pallet.tasks import job_of
from pnt_gym.planning.arrays import Bools, Floats
from pnt_gym.planning.one_joint import (
    Arm,
    Block,
    Flight,
    ThrowPlans,
    arrival,
    fit_flight,
    plan_throws,
    random_goals,
)
from pnt_gym.planning.one_joint.virtual_goal import next_virtual_goal, pull_back

GOAL: Final = np.array([0.0, 0.4, np.deg2rad(150.0), 0.0])
"""z_d of the paper's simulation and experiment (sections 4.5 and 6.2)."""
ARM: Final = Arm()
BLOCK: Final = Block()
TRIALS: Final = 10
"""Throws after which the paper states its errors."""
POSITION, ANGLE, SPEED = 0.0025, 0.1, 0.01
"""Bounds of the errors of the 10th throw [m, deg, m/s] (section 6.2)."""


class Misses(NamedTuple):
    """Norms of errors, each in the shape that the errors had without their last axis."""

    position: Floats
    """[m]"""
    angle: Floats
    """[deg]"""
    speed: Floats
    """Vertical [m/s]."""


def misses(error: Floats) -> Misses:
    """Norms of errors (..., 4) in x, y [m], phi [rad] and dy [m/s]."""
    angle = np.rad2deg(np.abs(error[..., 2]))
    return Misses(np.hypot(error[..., 0], error[..., 1]), angle, np.abs(error[..., 3]))


@final
@dataclass(frozen=True)
class Thrown:
    """N throws.

    Attributes:
        measured: states in which they passed their goals, as the camera tells (N, 4).
        true: the same of the simulated flights (N, 4).
        time: of the measured states, from the release on (N,) [s].
        fitted: parabolas through the camera's pictures, from the release on.
    """

    measured: Floats
    true: Floats
    time: Floats
    fitted: Flight


@final
class Thrower:
    """A thrower of many rows, each with the paper's block and errors that the planner does not know.

    Row i of trial j draws its scatter from a generator of its own, so that no other row matters; rows of one ``case``
    draw the same.

    Args:
        config: the cell.
        case: number of each row's draws (N,).
        seed: of all draws.
    """

    def __init__(self, config: PalletConfig, case: Sequence[int], seed: int = 0) -> None:
        self.config, self._case, self._seed = config, np.asarray(case, dtype=np.int64), seed
        # Parts of a reproduction run side by side, so one thread each.
        self.plant = PalletPlant(config, job_of(config), len(case), threads=1)
        self._trial = 0

    def throw(self, plans: Plans, goal: Floats) -> Thrown:
        """Throw once in every row, with scatter of its own.

        Args:
            plans: feasible plans of the N throws.
            goal: states that are to be passed (N, 4).
        """
        hidden, count = self._hidden(), len(goal)
        self._trial += 1
        flight = self.plant.throw(plans, np.zeros(count, dtype=np.int64), np.full((count, 1, 3), np.nan), hidden)
        weights = self.config.scale.weights()
        frames = watch(flight, plans.u[:, 3], hidden.noise, self.config)
        columns = [np.ascontiguousarray(frames.pose[..., k]) for k in range(3)]
        fitted = fit_flight(frames.time, *columns, frames.seen)
        found = arrival(fitted, goal, weights, np.zeros(count))
        return Thrown(found.z, flight.nearest(goal, weights), found.time, fitted)

    def _hidden(self) -> Hidden:
        cases, rows = np.unique(self._case, return_inverse=True)
        generators = [np.random.default_rng([self._seed, self._trial, int(case)]) for case in cases]
        drawn = draw_hidden(generators, self.config)
        return Hidden(drawn.radius[rows], drawn.delay[rows], drawn.noise[rows])


@final
@dataclass(frozen=True)
class Learned:
    """How N rows learned over J trials.

    Attributes:
        measured: errors as the camera saw them (J, N, 4).
        true: errors of the simulated flights (J, N, 4).
        virtual: virtual goals (J, N, 4).
        guarded: rows whose virtual goal had to be pulled back at least once (N,).
    """

    measured: Floats
    true: Floats
    virtual: Floats
    guarded: Bools


def learn(thrower: Thrower, goal: Floats, gain: Floats, trials: int = TRIALS) -> Learned:
    """Throw and move the virtual goals (Eqs. 33 and 34), as the paper's algorithm does.

    Args:
        thrower: N rows.
        goal: feasible goals (N, 4).
        gain: K of each row, times the identity: (N,), or (J - 1, N) after each throw but the last.
        trials: throws of each row.
    """
    virtual, guarded = goal.copy(), np.zeros(len(goal), dtype=np.bool_)
    gains = np.broadcast_to(gain, (max(trials - 1, 0), len(goal)))
    measured: list[Floats] = []
    true: list[Floats] = []
    planned: list[Floats] = []
    for trial in range(trials):
        if trial > 0:
            seen = goal + gains[trial - 1, :, None] * measured[-1]
            virtual, outside = pull_back(virtual, next_virtual_goal(virtual, goal, seen, 1.0), has_plan)
            guarded |= outside
        thrown = thrower.throw(plan_throws(virtual), goal)
        planned.append(virtual.copy())
        measured.append(thrown.measured - goal)
        true.append(thrown.true - goal)
    return Learned(np.stack(measured), np.stack(true), np.stack(planned), guarded)


def has_plan(goals: Floats) -> Bools:
    """Which goals (N, 4) have a throw: release and motion."""
    return plan_throws(goals).feasible


def feasible_goals(count: int, seed: int = 0) -> tuple[Floats, ThrowPlans]:
    """Random goals (count, 4) that have a throw, and the throws."""
    goals = random_goals(np.random.default_rng(seed), count + count // 4 + 8).goal
    plans = plan_throws(goals)
    rows = np.flatnonzero(plans.feasible)[:count]
    return goals[rows], plans.take(rows)


def drawn_goals(count: int) -> Floats:
    """Random goals (count, 4) as OneJointThrow-v0 draws them, row i with a generator of seed i."""
    cell = PalletCell(load("nominal"), count)
    cell.reset(np.arange(count), [np.random.default_rng(row) for row in range(count)])
    return cell.context.goal.copy()


def late(delay: float) -> PalletConfig:
    """The cell with every unmodelled effect, whose block comes free late by ``delay`` [s]."""
    return load("nominal", errors={"delay": delay})


def share(good: Bools) -> float:
    """Percentage of rows."""
    return 100.0 * float(good.mean())


def listed(values: Floats, digits: int = 6) -> list[Any]:
    """Numbers for JSON, rounded to significant digits."""
    return [float(f"{v:.{digits}g}") for v in values.ravel()] if values.ndim == 1 else [listed(v) for v in values]
