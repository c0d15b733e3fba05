"""The goal and the throws of Miyashita et al. 2010 that several parts of its reproduction use."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, NamedTuple, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, take
from pnt_gym.cells.one_joint.cell import OneJointCell
from pnt_gym.cells.one_joint.config import OneJointConfig
from pnt_gym.cells.one_joint.context import Context
from pnt_gym.cells.one_joint.flight import Flight
from pnt_gym.cells.one_joint.hidden import Hidden, draw_hidden
from pnt_gym.cells.one_joint.measure import estimated_state
from pnt_gym.cells.one_joint.plant import OneJointPlant
from pnt_gym.planning.one_joint import Arm, Block, ThrowPlans, plan_throws

from .planning.goals import next_virtual_goal, pull_back, random_goals

GOAL: Final = np.array([0.0, 0.4, np.deg2rad(150.0), 0.0])
"""z_d of the paper's simulation and experiment (sections 4.5 and 6.2)."""
ARM: Final = Arm()
BLOCK: Final = Block()
TRIALS: Final = 10
"""Throws after which the paper states its errors."""
POSITION, ANGLE, SPEED = 0.0025, 0.1, 0.01
"""Bounds of the errors of the 10th throw [m, deg, m/s] (section 6.2)."""
DELAYS: Final = (0.0, 0.005, 0.010)
"""How late the block comes free while the arm brakes already [s]; assumed."""


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
        spin: with which they flew in the end (N,) [rad/s].
    """

    measured: Floats
    true: Floats
    spin: Floats


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

    def __init__(self, config: OneJointConfig, case: Sequence[int], seed: int = 0) -> None:
        self.config, self._case, self._seed = config, np.asarray(case, dtype=np.int64), seed
        self.plant = plant_of(config, len(case))
        self._trial = 0

    def throw(self, plans: ThrowPlans, goal: Floats) -> Thrown:
        """Throw once in every row, with scatter of its own.

        Args:
            plans: feasible plans of the N throws.
            goal: states that are to be passed (N, 4).
        """
        hidden = self._hidden()
        self._trial += 1
        flight = fly(self.plant, plans, hidden)
        measured = estimated_state(flight, plans.u[:, 3], goal, hidden.noise, self.config)
        spin = flight.velocity[np.arange(len(goal)), flight.last_step, 2]
        return Thrown(measured, flight.nearest(goal, self.config.scale.weights()), spin)

    def _hidden(self) -> Hidden:
        cases, rows = np.unique(self._case, return_inverse=True)
        generators = [np.random.default_rng([self._seed, self._trial, int(case)]) for case in cases]
        return take(draw_hidden(generators, self.config), rows)


def plant_of(config: OneJointConfig, count: int) -> OneJointPlant:
    """Physics of the cell, one thread: parts of a reproduction run side by side."""
    return OneJointPlant(config, count, threads=1)


def fly(plant: OneJointPlant, plans: ThrowPlans, hidden: Hidden) -> Flight:
    """Throw the block in every simulation; nothing else is there."""
    first, nothing = np.zeros(len(plans.u), dtype=np.int64), np.full((len(plans.u), 1, 3), np.nan)
    return plant.fly(Context(first, first, plans.goal, plans.goal, plans, nothing, hidden), plans)


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
        trials: throws of each row, at least one.
    """
    guarded = np.zeros(len(goal), dtype=np.bool_)
    virtual, thrown = [goal], [thrower.throw(plan_throws(goal), goal)]
    for gains in np.broadcast_to(gain, (trials - 1, len(goal))):
        seen = goal + gains[:, None] * (thrown[-1].measured - goal)
        moved, outside = pull_back(virtual[-1], next_virtual_goal(virtual[-1], goal, seen, 1.0), has_plan)
        guarded |= outside
        virtual.append(moved)
        thrown.append(thrower.throw(plan_throws(moved), goal))
    measured, true = (np.stack([getattr(one, name) for one in thrown]) for name in ("measured", "true"))
    return Learned(measured - goal, true - goal, np.stack(virtual), guarded)


def has_plan(goals: Floats) -> Bools:
    """Which goals (N, 4) have a throw: release and motion."""
    return plan_throws(goals).feasible


def feasible_goals(count: int, seed: int = 0) -> tuple[Floats, ThrowPlans]:
    """Random goals (count, 4) that have a throw, and the throws."""
    goals = random_goals(np.random.default_rng(seed), count + count // 4 + 8).goal
    plans = plan_throws(goals)
    rows = np.flatnonzero(plans.feasible)[:count]
    return goals[rows], take(plans, rows)


def drawn_goals(count: int) -> Floats:
    """Random goals (count, 4) as OneJointThrow-v0 draws them, row i with a generator of seed i."""
    cell = OneJointCell(OneJointConfig.load("nominal"), count)
    cell.reset(np.arange(count), [np.random.default_rng(row) for row in range(count)])
    return cell.context.goal.copy()


def late(delay: float) -> OneJointConfig:
    """The cell with every unmodelled effect, whose block comes free late by ``delay`` [s]."""
    return OneJointConfig.load("nominal", errors={"delay": delay})


def named(delay: float) -> str:
    """A delay [s] as part of a quantity's name."""
    return f"delay-{1000.0 * delay:.0f}ms"


def percent(good: Bools) -> float:
    """Share of the rows [%]."""
    return 100.0 * float(good.mean())


def rounded(values: Floats, digits: int = 6) -> list[Any]:
    """Numbers for JSON, rounded to significant digits."""
    return [float(f"{v:.{digits}g}") for v in values.ravel()] if values.ndim == 1 else [rounded(v) for v in values]
