"""Time the one-joint planner and count its successes: python benchmarks/bench_one_joint.py [--json FILE]."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from agents.ground.files import write_json
from agents.reproduce.miyashita.accessible import accessible_space
from pnt_gym.planning.one_joint import (
    Arm,
    Block,
    ReleaseBox,
    UnreachableGoal,
    plan_releases,
    plan_throw,
    plan_throws,
    random_goals,
    release_states,
    release_states_batch,
)
from pnt_gym.planning.one_joint.margins import motion_margins

COUNT, REPEATS, SOME = 500, 7, 60
WIDE = ReleaseBox(angle=(-1.4, 1.4), speed=(2.0, 12.4), radius=(0.06, 0.28), flight=(0.05, 0.6))


def goals(count: int, box: ReleaseBox | None = None) -> np.ndarray:
    """Random goals whose release has an open acceleration window, fixed seed."""
    return random_goals(np.random.default_rng(7), count, box=box).goal


def fastest(call: Callable[[], object]) -> float:
    """Least time of a few calls [s]."""
    spent = []
    for _ in range(REPEATS):
        begin = time.perf_counter()
        call()
        spent.append(time.perf_counter() - begin)
    return min(spent)


def solve(rows: np.ndarray, **options: str | int) -> dict[str, float]:
    """Share of goals with a plan that keeps every limit at 1 kHz, and the times of a plan."""
    arm, block = Arm(), Block()
    spent, good, solved, tried = [], 0, 0, 0
    for row in rows:
        begin = time.perf_counter()
        try:
            plan = plan_throw(row, **options)  # type: ignore[arg-type]
        except UnreachableGoal:
            spent.append(time.perf_counter() - begin)
            continue
        spent.append(time.perf_counter() - begin)
        solved, tried = solved + plan.solved, tried + plan.starts
        good += bool((motion_margins(plan.motion, np.array([plan.radius]), arm, block) > 0.0).all())
    times = 1e3 * np.array(spent)
    return {
        "success": good / len(rows),
        "success_per_start": solved / max(tried, 1),
        "median_ms": float(np.median(times)),
        "p95_ms": float(np.quantile(times, 0.95)),
    }


def batch() -> dict[str, float]:
    """Time per goal of the batched searches and plans, best of a few runs."""
    every, found = goals(256), {}
    for count in (1, 64, 256):
        rows = every[:count]
        releases = release_states_batch(rows).u
        found[f"releases_us_at_{count}"] = 1e6 / count * fastest(lambda r=rows: release_states_batch(r))
        found[f"plans_us_at_{count}"] = 1e6 / count * fastest(lambda r=rows: plan_throws(r))
        found[f"plans_from_release_us_at_{count}"] = 1e6 / count * fastest(lambda u=releases: plan_releases(u))
    found["all_releases_of_one_goal_us"] = 1e6 * fastest(lambda: release_states(every[0]))
    found["success"] = float(plan_throws(goals(COUNT)).feasible.mean())
    found["success_wide"] = float(plan_throws(goals(COUNT, WIDE)).feasible.mean())
    return found


def measure() -> dict[str, dict[str, float]]:
    """Run everything in one process and return the numbers."""
    solve(goals(1), solver="ipopt")
    space = accessible_space()
    return {
        "batch": batch(),
        "slsqp": solve(goals(COUNT)),
        "slsqp_one_start": solve(goals(COUNT), starts=1),
        "slsqp_max_min": solve(goals(COUNT), objective="max_min", starts=1),
        "slsqp_wide": solve(goals(COUNT, WIDE)),
        "slsqp_random_guesses": solve(goals(SOME), guesses="random"),
        "ipopt": solve(goals(SOME), solver="ipopt", starts=1),
        "accessible_cells": {
            "kinematic": float(len(space.kinematic)),
            "grasp": float(len(space.grasp)),
            "planned": float(len(space.cells)),
        },
    }


def main() -> None:
    parser = argparse.ArgumentParser(description="Time the one-joint planner.")
    parser.add_argument("--json", type=Path, help="write the numbers to this file too")
    arguments = parser.parse_args()
    numbers = measure()
    for group, values in numbers.items():
        for name, value in values.items():
            print(f"{group:22s} {name:32s} {value:12,.4g}")
    if arguments.json:
        write_json(arguments.json, numbers)


if __name__ == "__main__":
    main()
