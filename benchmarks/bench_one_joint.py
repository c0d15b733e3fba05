"""Throws per second of the one-joint thrower's cell, and how exactly a throw comes true at several physics steps.

A round is what an environment's step is made of: a plan for every cell, the simulated throw, the camera's estimate,
and the next goals. Beside it stand its parts: planning alone and the plant alone.

Run: python benchmarks/bench_one_joint.py --json bench.json
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from agents.ground.files import write_json
from pnt_gym.cells.one_joint.cell import OneJointCell
from pnt_gym.cells.one_joint.config import OneJointConfig

TASKS = ("throw", "sort", "assembly")
STEPS = (0.0005, 0.001, 0.002)
DEGREE = 180.0 / np.pi


def made(config: OneJointConfig, cells: int, threads: int) -> OneJointCell:
    """Cells with their first throws drawn."""
    cell = OneJointCell(config, cells, threads)
    cell.reset(np.arange(cells), [np.random.default_rng(row) for row in range(cells)])
    return cell


def best(action: Callable[[], object], rounds: int) -> tuple[float, float]:
    """Least wall and least processor time of an action [s]: what other processes disturbed least."""
    times: list[tuple[float, float]] = []
    for _ in range(rounds):
        wall, cpu = time.perf_counter(), time.process_time()
        action()
        times.append((time.perf_counter() - wall, time.process_time() - cpu))
    return min(t[0] for t in times), min(t[1] for t in times)


def speed(task: str, cells: int, threads: int, rounds: int) -> dict[str, float | str]:
    """Rates of one task."""
    cell = made(OneJointConfig.load("nominal", task=task), cells, threads)
    context, goal = cell.context, cell.context.goal
    planning, _ = best(lambda: cell.planner.plan(goal, context.part), rounds)
    simulated = []

    def fly() -> None:
        simulated.append(cell.plant.fly(context, context.plans))

    plant, plant_cpu = best(fly, rounds)

    def step() -> None:
        cell.throw(cell.planner.plan(cell.context.goal, cell.context.part))

    whole, whole_cpu = best(step, rounds)
    steps = float(simulated[-1].last_step.mean()) + 1.0
    return {
        "task": task,
        "cells": cells,
        "threads": threads,
        "throws_per_s": cells / whole,
        "throws_per_cpu_s": cells / whole_cpu,
        "plant_throws_per_s": cells / plant,
        "plant_throws_per_cpu_s": cells / plant_cpu,
        "plan_us_per_throw": 1e6 * planning / cells,
        "physics_steps_per_throw": steps,
        "cpu_us_per_step": 1e6 * plant_cpu / (cells * steps),
    }


def exactness(step: float, cells: int) -> dict[str, float]:
    """Largest miss of throws to drawn goals without any mismatch."""
    cell = made(OneJointConfig.load("ideal", timestep=step), cells, 1)
    outcome = cell.preview(cell.context.plans)
    x, y, phi, dy = np.abs(outcome.true_error).max(axis=0)
    return {
        "timestep_ms": 1e3 * step,
        "position_mm": 1e3 * float(np.hypot(x, y)),
        "angle_deg": DEGREE * float(phi),
        "speed_mm_per_s": 1e3 * float(dy),
        "release_speed_mrad_per_s": 1e3 * float(np.abs(outcome.release_speed_error).max()),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cells", type=int, default=64)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--json", type=Path, help="write the figures to this file")
    options = parser.parse_args()
    rates = [speed(task, options.cells, threads, options.rounds) for task in TASKS for threads in (1, 2)]
    errors = [exactness(step, options.cells) for step in STEPS]
    for row in rates:
        print(
            f"{row['task']:9} {row['threads']} thread(s): {row['throws_per_s']:5.0f} throws/s "
            f"({row['throws_per_cpu_s']:5.0f} per processor second), plant alone {row['plant_throws_per_s']:5.0f}, "
            f"plan {row['plan_us_per_throw']:4.0f} us, {row['physics_steps_per_throw']:5.0f} steps of "
            f"{row['cpu_us_per_step']:.2f} us"
        )
    for row in errors:
        print(
            f"step {row['timestep_ms']:.1f} ms: within {row['position_mm']:.3f} mm, {row['angle_deg']:.3f} deg, "
            f"{row['speed_mm_per_s']:.2f} mm/s of the goal; release speed within "
            f"{row['release_speed_mrad_per_s']:.3f} mrad/s"
        )
    if options.json is not None:
        write_json(options.json, {"rates": rates, "exactness": errors})


if __name__ == "__main__":
    main()
