"""Time the exact planner against the paper's own methods: python benchmarks/bench_planner.py [--json FILE].

Three kinds of throws off the belt are timed apart, because a median over all of them is that of the easiest: without a
ceiling, under one that moves the release, and under one that leaves no throw. What is compared is timed in turn.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from agents.ground.files import write_json
from agents.reproduce.hassan.nlp import method_1, method_2
from pnt_gym.arrays import Floats, Ints, take
from pnt_gym.planning import InfeasibleThrow, JerkTrajectory, MotionLimits, plan_release, plan_release_batch
from pnt_gym.planning.motion.scurve import rest_to_rest

SCENE, SINGLE, BATCH, CELLS, NLP, REPEATS, STARTS = 150_000, 2000, 100_000, 64, 60, 7, 3
CEILING = -0.75
FIRST_PLAN = """
import time, numpy, pnt_gym.planning as planning
begin = time.perf_counter()
planning.plan_release((-0.2, -0.25, -0.85), (0.3, 0.4, -0.85), planning.MotionLimits.t3kr(40), ceiling=-0.75)
print(time.perf_counter() - begin)
"""
Scene = tuple[Floats, Floats, MotionLimits]


def scene(count: int) -> Scene:
    """Throws off the belt at 15 to 100 % of the T3KR's performance, near and far, fixed seed."""
    rng = np.random.default_rng(7)
    picks = np.stack([rng.uniform(-0.4, 0.4, count), rng.uniform(-0.6, 0.6, count), np.full(count, -0.85)], axis=1)
    targets = rng.uniform((-0.9, -0.9, -1.1), (0.9, 0.9, -0.7), (count, 3))
    return picks, targets, MotionLimits.t3kr(rng.uniform(15.0, 100.0, count))


def kinds(throws: Scene) -> dict[str, tuple[Ints, float | None]]:
    """Rows of each kind of throw, and the ceiling that they are planned under."""
    plans = plan_release_batch(*throws, ceiling=CEILING)
    return {
        "free": (np.arange(len(plans), dtype=np.int64), None),
        "ceiling_active": (np.flatnonzero(plans.ceiling_active), CEILING),
        "infeasible": (np.flatnonzero(~plans.feasible), CEILING),
    }


def in_turn(solvers: dict[str, Callable[[int], object]], count: int) -> dict[str, float]:
    """Median time of one call of each [s]; throws that cannot be planned count like any other."""
    spent: dict[str, list[float]] = {name: [] for name in solvers}
    for k in range(count):
        for name, solve in solvers.items():
            begin = time.perf_counter()
            with contextlib.suppress(InfeasibleThrow):
                solve(k)
            spent[name].append(time.perf_counter() - begin)
    return {name: statistics.median(times) for name, times in spent.items()}


def single(throws: Scene, rows: Ints, ceiling: float | None) -> Callable[[int], object]:
    """What plans one throw of a kind after the other."""
    tasks = [(throws[0][row], throws[1][row], take(throws[2], row)) for row in rows[:SINGLE]]
    return lambda k: plan_release(*tasks[k], ceiling=ceiling)


def batch(throws: Scene, rows: Ints, ceiling: float | None, size: int) -> Callable[[int], object]:
    """What plans a batch of one kind."""
    part = np.resize(rows, size)
    picks, targets, limits = throws[0][part], throws[1][part], take(throws[2], part)
    return lambda _: plan_release_batch(picks, targets, limits, ceiling=ceiling)


def first_plan(kept: Path) -> float:
    """Seconds to the first plan of a process, which loads the compiler and finds the machine code or makes it."""
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(kept)}
    done = subprocess.run(
        [sys.executable, "-c", FIRST_PLAN], env=environment, capture_output=True, text=True, check=True
    )
    return float(done.stdout)


def first_plans() -> dict[str, float]:
    """The first plan after an installation, and of every process later, each the least of a few [s]."""
    new, later = [], []
    for _ in range(STARTS):
        with tempfile.TemporaryDirectory() as folder:
            new.append(first_plan(Path(folder)))
            later.append(first_plan(Path(folder)))
    return {"after_installation": min(new), "of_a_process": min(later)}


def sampling_time() -> float:
    """Median time to read 64 paths of 25 segments at 256 times [s]."""
    rng = np.random.default_rng(8)
    moves = [rest_to_rest(rng.normal(size=(64, 3)), MotionLimits.t3kr(40)) for _ in range(4)]
    joined = JerkTrajectory.concatenate(np.zeros((64, 3)), moves)
    path = JerkTrajectory(joined.start, joined.durations[:, :25], joined.jerks[:, :25])
    times = np.linspace(0.0, float(path.duration.max()), 256)
    return in_turn({"sample": lambda _: path.sample(times)}, 50)["sample"]


def measure() -> dict[str, Any]:
    """Run everything in one process and return the numbers."""
    throws = scene(SCENE)
    found = kinds(throws)
    singles = {name: single(throws, *kind) for name, kind in found.items()}
    tasks = [(throws[0][k], throws[1][k], take(throws[2], k)) for k in range(NLP)]
    methods = {"method_1": lambda k: method_1(*tasks[k]), "method_2": lambda k: method_2(*tasks[k])}
    methods["method_1"](0)
    peers, exact = in_turn(methods, NLP), in_turn(singles, SINGLE)
    large = in_turn({name: batch(throws, *kind, BATCH) for name, kind in found.items()}, REPEATS)
    small = in_turn({name: batch(throws, *kind, CELLS) for name, kind in found.items()}, 20 * REPEATS)
    return {
        "plan_release_us": {name: 1e6 * time for name, time in exact.items()},
        "batch_plans_per_s": {name: BATCH / time for name, time in large.items()},
        "batch_of_64_us": {name: 1e6 * time for name, time in small.items()},
        "first_plan_s": first_plans(),
        "method_1_slsqp_median_us": 1e6 * peers["method_1"],
        "method_2_median_us": 1e6 * peers["method_2"],
        "slsqp_over_exact": peers["method_1"] / exact["free"],
        "sample_64x25_at_256_ms": 1e3 * sampling_time(),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description="Time the throw planner.")
    parser.add_argument("--json", type=Path, help="write the numbers to this file too")
    arguments = parser.parse_args()
    numbers = measure()
    for name, value in numbers.items():
        parts = value.items() if isinstance(value, dict) else [("", value)]
        print(f"{name:28s} " + "  ".join(f"{part} {number:,.4g}" for part, number in parts))
    if arguments.json:
        write_json(arguments.json, numbers)


if __name__ == "__main__":
    main()
