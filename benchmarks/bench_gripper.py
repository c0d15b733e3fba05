"""Throws per second of the gripper robot's cell, how exactly throws come true, and how reliable grips and tosses are.

A round is what an environment's step is made of: a plan for every cell, the simulated pick and toss, the outcome, and
the next objects. With --cycles a long run looks for warnings of the physics engine, which the plant turns into errors.

Run: python benchmarks/bench_gripper.py --json bench.json
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np

from agents.ground.files import write_json
from pnt_gym.cells.base.action import corrected
from pnt_gym.cells.gripper.action import MODES
from pnt_gym.cells.gripper.cell import GripperCell
from pnt_gym.cells.gripper.config import GripperConfig
from pnt_gym.cells.gripper.motion import TossPlans

LEVELS = ("nominal", "ideal", "patient", "late", "drop", "belt")
STEPS = (0.00025, 0.0005, 0.001)
MILLI = 1e3


def made(config: GripperConfig, cells: int, threads: int) -> GripperCell:
    """Cells with their first throws drawn."""
    cell = GripperCell(config, cells, threads)
    cell.reset(np.arange(cells), [np.random.default_rng(row) for row in range(cells)])
    return cell


def plans(cell: GripperCell, correction: np.ndarray) -> TossPlans:
    """Feasible plans nearest to corrections (N, 3) in metres and seconds."""
    return corrected(MODES["release"], cell.planner, cell.context, correction, np.ones(3))[0]


def speed(level: str, cells: int, threads: int, rounds: int) -> dict[str, float | str]:
    """Least wall and least processor time of a round."""
    cell = made(GripperConfig.load(level), cells, threads)
    wall, cpu = np.inf, np.inf
    for _ in range(rounds):
        start, used = time.perf_counter(), time.process_time()
        cell.throw(plans(cell, np.zeros((cells, 3))))
        wall, cpu = min(wall, time.perf_counter() - start), min(cpu, time.process_time() - used)
    return {
        "level": level,
        "cells": cells,
        "threads": threads,
        "throws_per_s": cells / wall,
        "throws_per_cpu_s": cells / cpu,
    }


def quality(level: str, cells: int) -> dict[str, float | str]:
    """Landing errors and success of the planner, and of an oracle that previews throws, within an action's range."""
    cell = made(GripperConfig.load(level), cells, 2)
    correction, most = np.zeros((cells, 3)), cell.config.action.scale()
    planned = cell.preview(cell.context.plans, jitter=True)
    correction[:, 2] = -cell.context.hidden.delay
    for _ in range(2):
        correction = np.clip(correction, -most, most)
        outcome = cell.preview(plans(cell, correction), jitter=True)
        correction[:, 0] -= outcome.landing_along
        correction[:, 1] -= outcome.landing_across
    best = cell.preview(plans(cell, np.clip(correction, -most, most)), jitter=True)
    return {
        "level": level,
        "planner_success": float(planned.is_success.mean()),
        "planner_error_mm": MILLI * float(planned.landing_error.mean()),
        "oracle_success": float(best.is_success.mean()),
        "oracle_error_mm": MILLI * float(best.landing_error.mean()),
        "picked": float(planned.picked.mean()),
        "slip_max_mm": MILLI * float(planned.slip.max()),
        "recontact": float(planned.recontact.mean()),
        "cycle_time_s": float(planned.cycle_time.mean()),
        "peak_torque_nm": float(planned.peak_torque.max()),
    }


def exactness(step: float, cells: int) -> dict[str, float]:
    """Landing error of throws without any mismatch."""
    cell = made(GripperConfig.load("ideal", timestep=step), cells, 2)
    outcome = cell.preview(cell.context.plans)
    return {
        "timestep_ms": MILLI * step,
        "along_mm": MILLI * float(outcome.landing_along.mean()),
        "largest_mm": MILLI * float(outcome.landing_error.max()),
    }


def endurance(level: str, cycles: int, cells: int, threads: int) -> dict[str, float | str]:
    """Share of successes in many cycles; an engine's warning stops the run."""
    cell, done, good, picked = made(GripperConfig.load(level), cells, threads), 0, 0, 0
    rng = np.random.default_rng(0)
    while done < cycles:
        # Random corrections, so that throws which go wrong are among them.
        correction = rng.uniform(-1.0, 1.0, (cells, 3)) * cell.config.action.scale()
        outcome = cell.throw(plans(cell, correction))
        done, good = done + cells, good + int(outcome.is_success.sum())
        picked += int(outcome.picked.sum())
    return {"level": level, "cycles": done, "success": good / done, "picked": picked / done}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cells", type=int, default=64)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--cycles", type=int, default=0, help="length of the long run; 0 leaves it out")
    parser.add_argument("--json", type=Path, help="write the figures to this file")
    options = parser.parse_args()
    result = {
        "rates": [
            speed(level, options.cells, threads, options.rounds) for level in ("nominal", "belt") for threads in (1, 2)
        ],
        "quality": [quality(level, options.cells) for level in LEVELS],
        "exactness": [exactness(step, options.cells) for step in STEPS],
    }
    if options.cycles > 0:
        result["endurance"] = [endurance(level, options.cycles, options.cells, 2) for level in ("nominal", "belt")]
    for name, rows in result.items():
        for row in rows:
            values = (
                f"{key} {value:.4g}" if isinstance(value, float) else f"{key} {value}" for key, value in row.items()
            )
            print(f"{name}: {', '.join(values)}")
    if options.json is not None:
        write_json(options.json, result)


if __name__ == "__main__":
    main()
