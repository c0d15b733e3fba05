"""The case of planners: the straight throw beside the paper's two methods."""

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
from papers.hassan.nlp import method_1, method_2
from pnt_gym.arrays import Floats, Ints, take
from pnt_gym.planning import InfeasibleThrow, JerkTrajectory, MotionLimits, plan_release, plan_release_batch
from pnt_gym.planning.motion.scurve import rest_to_rest

CEILING, SCENE, SINGLE, BATCH, CELLS, NLP, STARTS = -0.75, 150_000, 2000, 100_000, 64, 60, 3
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
