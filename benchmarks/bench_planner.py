"""Time the exact planner against the paper's own methods: python benchmarks/bench_planner.py [--json FILE]."""

from __future__ import annotations

import argparse
import contextlib
import statistics
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from agents.files import write_json
from agents.reproduce.hassan.nlp import method_1, method_2
from pnt_gym.arrays import take
from pnt_gym.planning import InfeasibleThrow, JerkTrajectory, MotionLimits, plan_release, plan_release_batch
from pnt_gym.planning.motion.scurve import rest_to_rest

SINGLE, BATCH, NLP, REPEATS = 2000, 100_000, 60, 5
CEILING = -0.75


def scene(count: int) -> tuple[np.ndarray, np.ndarray, MotionLimits]:
    """Throws off the belt at 15 to 100 % of the T3KR's performance, near and far, fixed seed."""
    rng = np.random.default_rng(7)
    picks = np.stack([rng.uniform(-0.4, 0.4, count), rng.uniform(-0.6, 0.6, count), np.full(count, -0.85)], axis=1)
    targets = rng.uniform((-0.9, -0.9, -1.1), (0.9, 0.9, -0.7), (count, 3))
    return picks, targets, MotionLimits.t3kr(rng.uniform(15.0, 100.0, count))


def seconds_each(solve: Callable[[int], object], count: int) -> float:
    """Median time of one call; infeasible throws count like any other."""
    spent = []
    for k in range(count):
        begin = time.perf_counter()
        with contextlib.suppress(InfeasibleThrow):
            solve(k)
        spent.append(time.perf_counter() - begin)
    return statistics.median(spent)


def batch_rate(ceiling: float | None) -> float:
    """Plans per second of one large batch, best of a few runs."""
    picks, targets, limits = scene(BATCH)
    spent = []
    for _ in range(REPEATS):
        begin = time.perf_counter()
        plan_release_batch(picks, targets, limits, ceiling=ceiling)
        spent.append(time.perf_counter() - begin)
    return BATCH / min(spent)


def sampling_time() -> float:
    """Median time to read 64 paths of 25 segments at 256 times."""
    rng = np.random.default_rng(8)
    moves = [rest_to_rest(rng.normal(size=(64, 3)), MotionLimits.t3kr(40)) for _ in range(4)]
    joined = JerkTrajectory.concatenate(np.zeros((64, 3)), moves)
    path = JerkTrajectory(joined.start, joined.durations[:, :25], joined.jerks[:, :25])
    times = np.linspace(0.0, float(path.duration.max()), 256)
    return seconds_each(lambda _: path.sample(times), 50)


def measure() -> dict[str, float]:
    """Run everything in one process and return the numbers."""
    picks, targets, limits = scene(SINGLE)
    rows = [take(limits, k) for k in range(SINGLE)]
    free = seconds_each(lambda k: plan_release(picks[k], targets[k], rows[k]), SINGLE)
    roofed = seconds_each(lambda k: plan_release(picks[k], targets[k], rows[k], ceiling=CEILING), SINGLE)
    method_1(picks[0], targets[0], rows[0])
    slsqp = seconds_each(lambda k: method_1(picks[k], targets[k], rows[k]), NLP)
    simplified = seconds_each(lambda k: method_2(picks[k], targets[k], rows[k]), NLP)
    return {
        "plan_release_median_us": 1e6 * free,
        "plan_release_ceiling_median_us": 1e6 * roofed,
        "batch_plans_per_s": batch_rate(None),
        "batch_ceiling_plans_per_s": batch_rate(CEILING),
        "method_1_slsqp_median_us": 1e6 * slsqp,
        "method_2_median_us": 1e6 * simplified,
        "slsqp_over_exact": slsqp / free,
        "sample_64x25_at_256_ms": 1e3 * sampling_time(),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description="Time the throw planner.")
    parser.add_argument("--json", type=Path, help="write the numbers to this file too")
    arguments = parser.parse_args()
    numbers = measure()
    for name, value in numbers.items():
        print(f"{name:32s} {value:14,.1f}")
    if arguments.json:
        write_json(arguments.json, numbers)


if __name__ == "__main__":
    main()
