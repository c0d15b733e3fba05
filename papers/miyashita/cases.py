"""The goal and the throws of Miyashita et al. that several parts of its reproduction use."""

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
"""Assumed delays of the release, in which the arm already brakes [s]."""


class Misses(NamedTuple):
    """Norms of errors, each of the errors' shape without its last axis."""

    position: Floats
    """Norm of the position error [m]."""
    angle: Floats
    """Absolute error of the angle [deg]."""
    speed: Floats
    """Absolute error of the vertical speed [m/s]."""


def misses(error: Floats) -> Misses:
    """Norms of errors (..., 4) in x, y [m], phi [rad] and dy [m/s]."""
    angle = np.rad2deg(np.abs(error[..., 2]))
    return Misses(np.hypot(error[..., 0], error[..., 1]), angle, np.abs(error[..., 3]))


@final
@dataclass(frozen=True)
class ThrowResults:
    """Simulated results of N throws.

    Attributes:
        measured: states nearest to the goals, as measured by the camera (N, 4).
        true: states of the simulated flights nearest to the goals (N, 4).
        spin: spin of the block at the end of the flight (N,) [rad/s].
    """

    measured: Floats
    true: Floats
    spin: Floats


@final
class SimulatedThrower:
    """A simulated one-joint thrower of N rows, each with the paper's block and errors that the planner does not model.

    Each trial draws the scatter of a row from its own generator, so that rows do not depend on each other. Rows with
    the same ``case`` draw the same scatter.

    Args:
        config: configuration of the cell.
        case: number of each row's random draws (N,).
        seed: seed of all draws.
    """

    def __init__(self, config: OneJointConfig, case: Sequence[int], seed: int = 0) -> None:
        self.config, self._case, self._seed = config, np.asarray(case, dtype=np.int64), seed
        self.plant = make_plant(config, len(case))
        self._trial = 0

    def throw(self, plans: ThrowPlans, goal: Floats) -> ThrowResults:
        """Simulate a throw in every row, with new scatter.

        Args:
            plans: feasible plans of the N throws.
            goal: states that the throws should pass (N, 4).
        """
        hidden = self._draw_hidden()
        self._trial += 1
        flight = simulate_flights(self.plant, plans, hidden)
        measured = estimated_state(flight, plans.u[:, 3], goal, hidden.noise, self.config)
        spin = flight.velocity[np.arange(len(goal)), flight.last_step, 2]
        return ThrowResults(measured, flight.nearest(goal, self.config.scale.weights()), spin)

    def _draw_hidden(self) -> Hidden:
        cases, rows = np.unique(self._case, return_inverse=True)
        generators = [np.random.default_rng([self._seed, self._trial, int(case)]) for case in cases]
        return take(draw_hidden(generators, self.config), rows)


def make_plant(config: OneJointConfig, count: int) -> OneJointPlant:
    """Physics of the cell with a single thread, as parts of a reproduction run at the same time."""
    return OneJointPlant(config, count, threads=1)


def simulate_flights(plant: OneJointPlant, plans: ThrowPlans, hidden: Hidden) -> Flight:
    """Simulate the block's flight for each plan, without pallets."""
    first, no_pallets = np.zeros(len(plans.u), dtype=np.int64), np.full((len(plans.u), 1, 3), np.nan)
    return plant.fly(Context(first, first, plans.goal, plans.goal, plans, no_pallets, hidden), plans)


@final
@dataclass(frozen=True)
class LearningRecord:
    """Errors and virtual goals of N rows over J trials of learning.

    Attributes:
        measured: errors as measured by the camera (J, N, 4).
        true: errors of the simulated flights (J, N, 4).
        virtual: virtual goals (J, N, 4).
        guarded: rows whose virtual goal had to be pulled back at least once (N,).
    """

    measured: Floats
    true: Floats
    virtual: Floats
    guarded: Bools


def learn(thrower: SimulatedThrower, goal: Floats, gain: Floats, trials: int = TRIALS) -> LearningRecord:
    """Learn by the paper's algorithm: throw, and move the virtual goals by the measured errors (Eqs. 33 and 34).

    Args:
        thrower: simulated thrower of N rows.
        goal: feasible goals (N, 4).
        gain: K of each row as a multiple of the identity: (N,), or (J - 1, N) after each throw but the last.
        trials: number of throws of each row, at least 1.
    """
    guarded = np.zeros(len(goal), dtype=np.bool_)
    virtual, throws = [goal], [thrower.throw(plan_throws(goal), goal)]
    for gains in np.broadcast_to(gain, (trials - 1, len(goal))):
        scaled_states = goal + gains[:, None] * (throws[-1].measured - goal)
        next_goals, outside = pull_back(virtual[-1], next_virtual_goal(virtual[-1], goal, scaled_states, 1.0), has_plan)
        guarded |= outside
        virtual.append(next_goals)
        throws.append(thrower.throw(plan_throws(next_goals), goal))
    measured, true = (np.stack([getattr(result, name) for result in throws]) for name in ("measured", "true"))
    return LearningRecord(measured - goal, true - goal, np.stack(virtual), guarded)


def has_plan(goals: Floats) -> Bools:
    """Whether each of the goals (N, 4) has a feasible throw, release and motion (N,)."""
    return plan_throws(goals).feasible


def feasible_goals(count: int) -> tuple[Floats, ThrowPlans]:
    """Random goals (count, 4) that have a feasible throw, and the plans of the throws."""
    goals = random_goals(np.random.default_rng(0), count + count // 4 + 8).goal
    plans = plan_throws(goals)
    rows = np.flatnonzero(plans.feasible)[:count]
    return goals[rows], take(plans, rows)


def draw_cell_goals(count: int) -> Floats:
    """Random goals (count, 4) of OneJointThrow-v0, where row i has a generator with the seed i."""
    cell = OneJointCell(OneJointConfig.load("nominal"), count)
    cell.reset(np.arange(count), [np.random.default_rng(row) for row in range(count)])
    return cell.context.goal.copy()


def config_with_delay(delay: float, scale: tuple[float, float, float] | None = None) -> OneJointConfig:
    """Configuration of the cell with every unmodelled effect.

    Args:
        delay: time by which the release is late [s].
        scale: weights of position, angle and speed in T of Eq. 35; those of the level when not given.
    """
    changes = {} if scale is None else {"scale": dict(zip(("position", "angle", "speed"), scale, strict=True))}
    return OneJointConfig.load("nominal", errors={"delay": delay}, **changes)


def delay_name(delay: float) -> str:
    """A delay [s] as part of a quantity's name."""
    return f"delay-{1000.0 * delay:.0f}ms"


def percent(good: Bools) -> float:
    """Share of the rows [%]."""
    return 100.0 * float(good.mean())


def round_values(values: Floats, digits: int = 6) -> list[Any]:
    """Numbers for JSON, rounded to significant digits."""
    return [float(f"{v:.{digits}g}") for v in values.ravel()] if values.ndim == 1 else [round_values(v) for v in values]
