"""Cases of planners: the straight throw beside the paper's two methods, the free direction, the one-joint thrower."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from functools import partial
from itertools import cycle
from statistics import median
from typing import NamedTuple

import numpy as np

from benchmarks.timing import Count, Options, Row, Timing
from papers.hassan.cases import CEILING as LOW
from papers.hassan.cases import limits_at
from papers.hassan.nlp import method_1, method_2
from papers.hassan.per_pick import CYCLE, PlannedThrows, cell_mover, pick_context, plan_free_throws
from papers.hassan.planning.optimum import fastest_throw
from papers.miyashita.accessible import accessible_space
from papers.miyashita.planning.goals import ReleaseBox, random_goals
from papers.miyashita.planning.plan import ThrowPlan, plan_throw
from pnt_gym.arrays import Floats, Ints, take
from pnt_gym.planning import InfeasibleThrow, JerkTrajectory, MotionLimits, plan_release, plan_release_batch
from pnt_gym.planning.motion.scurve import rest_to_rest
from pnt_gym.planning.one_joint import (
    Arm,
    Block,
    UnreachableGoal,
    plan_releases,
    plan_throws,
    release_states,
    release_states_batch,
)
from pnt_gym.planning.one_joint.margins import motion_margins

CEILING, SCENE, SINGLE, BATCH, CELLS, NLP, STARTS = -0.75, 150_000, 2000, 100_000, 64, 60, 3
PICKS, OPTIMA = 1024, 10
GOALS, SOME = 500, 60
WIDE = ReleaseBox(angle=(-1.4, 1.4), speed=(2.0, 12.4), radius=(0.06, 0.28), flight=(0.05, 0.6))
FIRST_PLAN = """
import time, numpy, pnt_gym.planning as planning
begin = time.perf_counter()
planning.plan_release((-0.2, -0.25, -0.85), (0.3, 0.4, -0.85), planning.MotionLimits.t3kr(40), ceiling=-0.75)
print(time.perf_counter() - begin)
"""


class Throws(NamedTuple):
    """Throws by their picks and targets (N, 3)."""

    picks: Floats
    targets: Floats
    limits: MotionLimits


def planner(options: Options) -> Iterator[Row]:
    """The exact planner beside the paper's two methods, on throws without a ceiling, under one, and with no solution.

    The three are timed apart, because a median over all of them is that of the easiest.
    """
    throws, size = belt_throws(SCENE), options.size(BATCH)
    for name, (rows, ceiling) in kinds(throws).items():
        plan_single, plan_batch = partial(plan_release, ceiling=ceiling), partial(plan_release_batch, ceiling=ceiling)
        large, small = (take(throws, np.resize(rows, count)) for count in (size, CELLS))
        yield Timing(
            ("plan_release_us", name), solver(plan_single, throws, rows[:SINGLE]), repeats=SINGLE, statistic=median
        )
        yield Timing(("batch_plans_per_s", name), partial(plan_batch, *large), "1/s", size, statistic=median)
        yield Timing(("batch_of_64_us", name), partial(plan_batch, *small), repeats=140, statistic=median)
    yield Count(("first_plan_s",), lambda: first_plans(options.size(STARTS)))
    rows, slow = np.arange(NLP), ("method_1_slsqp_median_us",)
    yield Timing(slow, solver(method_1, throws, rows), repeats=NLP, statistic=median)
    yield Timing(("method_2_median_us",), solver(method_2, throws, rows), repeats=NLP, statistic=median)
    yield Timing(("slsqp_over_exact",), slow, "x", statistic=median, over=("plan_release_us", "free"))
    path = long_path()
    sample = partial(path.sample, np.linspace(0.0, float(path.duration.max()), 256))
    yield Timing(("sample_64x25_at_256_ms",), sample, "ms", repeats=50, statistic=median)


def belt_throws(count: int) -> Throws:
    """Throws off the belt at 15 to 100 % of the T3KR's performance, near and far, fixed seed."""
    rng = np.random.default_rng(7)
    picks = np.stack([rng.uniform(-0.4, 0.4, count), rng.uniform(-0.6, 0.6, count), np.full(count, -0.85)], axis=1)
    targets = rng.uniform((-0.9, -0.9, -1.1), (0.9, 0.9, -0.7), (count, 3))
    return Throws(picks, targets, MotionLimits.t3kr(rng.uniform(15.0, 100.0, count)))


def kinds(throws: Throws) -> dict[str, tuple[Ints, float | None]]:
    """Rows of each kind of throw, and the ceiling that they are planned under."""
    plans = plan_release_batch(*throws, ceiling=CEILING)
    return {
        "free": (np.arange(len(plans), dtype=np.int64), None),
        "ceiling_active": (np.flatnonzero(plans.ceiling_active), CEILING),
        "infeasible": (np.flatnonzero(~plans.feasible), CEILING),
    }


def solver(plan: Callable[..., object], throws: Throws, rows: Ints) -> Callable[[], None]:
    """Plans the next of these throws in each call; throws without a plan count like any other."""
    tasks = cycle([take(throws, int(row)) for row in rows])

    def call() -> None:
        with contextlib.suppress(InfeasibleThrow):
            plan(*next(tasks))

    return call


def first_plans(starts: int) -> dict[str, float]:
    """The first plan after an installation, and of every process later, each the least of a few [s].

    Each loads the compiler, and reads the machine code or makes it.
    """
    seconds, command = [], [sys.executable, "-c", FIRST_PLAN]
    for _ in range(starts):
        with tempfile.TemporaryDirectory() as cache:
            environment = {**os.environ, "NUMBA_CACHE_DIR": cache}
            start = partial(subprocess.run, command, env=environment, capture_output=True, text=True, check=True)
            seconds.append([float(start().stdout) for _ in range(2)])
    return dict(zip(("after_installation", "of_a_process"), np.min(seconds, axis=0).tolist(), strict=True))


def long_path() -> JerkTrajectory:
    """64 paths of 25 segments."""
    rng = np.random.default_rng(8)
    moves = [rest_to_rest(rng.normal(size=(64, 3)), MotionLimits.t3kr(40)) for _ in range(4)]
    joined = JerkTrajectory.concatenate(np.zeros((64, 3)), moves)
    return JerkTrajectory(joined.start, joined.durations[:, :25], joined.jerks[:, :25])


def free_direction(percent: float, options: Options) -> Iterator[Row]:
    """Throws in a free direction as the conveyor cell plans them, beside the optimum, at a share of the performance."""
    rng = np.random.default_rng(7)
    picks, following = (rng.uniform((-0.3, -0.45, -0.85), (0.3, -0.2, -0.85), (PICKS, 3)) for _ in range(2))
    targets = rng.uniform((-0.5, 0.25, -0.85), (0.5, 0.75, -0.85), (PICKS, 3))
    mover, context, losses = cell_mover(percent), pick_context(picks, targets, percent), dict[int, float]()

    def plan(begins: Iterator[int], size: int) -> PlannedThrows:
        rows = slice(begin := next(begins), begin + size)
        return plan_free_throws(mover, take(context, rows), following[rows])

    def optimum() -> None:
        k, row = next(rows)
        throw = fastest_throw(
            picks[row], targets[row], following[row], limits_at(percent), ceiling=LOW, tolerance=CYCLE.tolerance
        )
        losses[k] = float(throws.path.duration[k]) / throw.duration - 1.0

    throws, place = plan(iter([0]), PICKS), ("by_percent", f"{percent:.0f}")
    rows = cycle(enumerate(np.flatnonzero(throws.feasible)[:OPTIMA]))
    yield Count(("picks",), PICKS)
    for size in (1, 16, 256, PICKS):
        call, repeats = partial(plan, cycle(range(0, PICKS, size)), size), max(7, 64 // size)
        yield Timing((*place, "us_per_pick", str(size)), call, "us", size, repeats, median)
    yield Count((*place, "straight_share"), float(np.sum(throws.release.straight)) / PICKS)
    yield Count((*place, "infeasible_share"), float(np.mean(~throws.feasible)))
    yield Count((*place, "loss_mean"), lambda: float(np.mean([*losses.values()])))
    yield Count((*place, "loss_max"), lambda: max(losses.values()))
    yield Count((*place, "loss_picks"), lambda: len(losses))
    yield Timing((*place, "optimum_median_s"), optimum, "s", repeats=OPTIMA, statistic=median)


def one_joint_batch(options: Options) -> Iterator[Row]:
    """Batched searches and plans of the one-joint thrower, and the share of goals that they plan for."""
    goals = random_goals(np.random.default_rng(7), 256).goal
    for count in (1, 64, 256):
        rows = goals[:count]
        calls = {"releases": (release_states_batch, rows), "plans": (plan_throws, rows)}
        calls["plans_from_release"] = plan_releases, release_states_batch(rows).u
        for name, (plan, arguments) in calls.items():
            yield Timing(("batch", f"{name}_us_at_{count}"), partial(plan, arguments), count=count)
    yield Timing(("batch", "all_releases_of_one_goal_us"), partial(release_states, goals[0]))
    for name, box in (("success", None), ("success_wide", WIDE)):
        rows = random_goals(np.random.default_rng(7), options.size(GOALS), box=box).goal
        yield Count(("batch", name), float(plan_throws(rows).feasible.mean()))


def one_joint_solvers(options: Options) -> Iterator[Row]:
    """The same goals by nonlinear programmes: times of a plan, and shares of goals with one that keeps every limit."""
    usual, wide = (random_goals(np.random.default_rng(7), GOALS, box=box).goal for box in (None, WIDE))
    goal_rows = random_goals(np.random.default_rng(7), SOME).goal
    yield from solves("slsqp", usual)
    yield from solves("slsqp_one_start", usual, starts=1)
    yield from solves("slsqp_max_min", usual, objective="max_min", starts=1)
    yield from solves("slsqp_wide", wide)
    yield from solves("slsqp_random_guesses", goal_rows, guesses="random")
    yield from solves("ipopt", goal_rows, solver="ipopt", starts=1)
    space = accessible_space()
    cells = {"kinematic": space.kinematic, "grasp": space.grasp, "planned": space.cells}
    yield Count(("accessible_cells",), {name: float(len(margin)) for name, margin in cells.items()})


def solves(name: str, goals: Floats, **arguments: str | int) -> Iterator[Row]:
    """Rows of one solver; a plan is good where it keeps every limit at 1 kHz."""
    plans, rows = dict[int, ThrowPlan | None](), cycle(enumerate(goals))

    def call() -> None:
        k, goal = next(rows)
        plans[k] = None
        with contextlib.suppress(UnreachableGoal):
            plans[k] = plan_throw(goal, **arguments)  # type: ignore[arg-type]

    def shares() -> dict[str, float]:
        solved = [plan for plan in plans.values() if plan is not None]
        margins = [motion_margins(plan.motion, np.array([plan.radius]), Arm(), Block()) for plan in solved]
        good, starts = (
            sum(bool((margin > 0.0).all()) for margin in margins),
            sum(plan.starts for plan in solved),
        )
        return {"success": good / len(plans), "success_per_start": sum(p.solved for p in solved) / max(starts, 1)}

    yield Count((name,), shares)
    yield Timing((name, "median_ms"), call, "ms", repeats=len(goals), statistic=median)
    yield Timing((name, "p95_ms"), (name, "median_ms"), "ms", statistic=lambda t: float(np.quantile(t, 0.95)))
