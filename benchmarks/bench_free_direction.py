"""Time throws in a free direction, as the conveyor cell plans them, beside the optimum: bench_free_direction.py."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from pathlib import Path
from typing import TypedDict

import numpy as np

from agents.ground.files import write_json
from agents.reproduce.hassan.cases import CEILING, limits_at
from agents.reproduce.hassan.per_pick import CYCLE, Flown, fly, mover_of, picks_of
from pnt_gym.arrays import take
from pnt_gym.planning.optimal.free import fastest_throw

BATCHES, PERCENTS, REPEATS = (1, 16, 256, 1024), (30.0, 40.0, 45.0), 7
PICKS, BEST = 1024, 10


class Numbers(TypedDict):
    """What is measured at one percentage."""

    us_per_pick: dict[str, float]
    straight_share: float
    infeasible_share: float
    loss_mean: float
    loss_max: float
    loss_picks: int
    optimum_median_s: float


def scene(count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Picks, targets and next picks of the conveyor cell, fixed seed."""
    rng = np.random.default_rng(7)
    picks, following = (rng.uniform((-0.3, -0.45, -0.85), (0.3, -0.2, -0.85), (count, 3)) for _ in range(2))
    targets = rng.uniform((-0.5, 0.25, -0.85), (0.5, 0.75, -0.85), (count, 3))
    return picks, targets, following


def plan(percent: float) -> Callable[[slice], Flown]:
    """What plans a batch of the scene's picks as the conveyor cell does."""
    picks, targets, following = scene(PICKS)
    mover, context = mover_of(percent), picks_of(picks, targets, percent)
    return lambda rows: fly(mover, take(context, rows), following[rows])


def seconds_each(batch: int, plan_rows: Callable[[slice], Flown]) -> float:
    """Median time per pick over calls with a batch of other picks each."""
    spent = []
    for turn in range(max(REPEATS, 64 // batch)):
        begin = batch * turn % PICKS
        start = time.perf_counter()
        plan_rows(slice(begin, begin + batch))
        spent.append(time.perf_counter() - start)
    return float(np.median(spent)) / batch


def losses(throws: Flown, percent: float) -> tuple[list[float], list[float]]:
    """How much longer the first throws take than the optimum, as shares, and the times the optimum took [s]."""
    picks, targets, following = scene(PICKS)
    found, spent = [], []
    for k, row in enumerate(np.flatnonzero(throws.good)[:BEST]):
        start = time.perf_counter()
        best = fastest_throw(
            picks[row], targets[row], following[row], limits_at(percent), ceiling=CEILING, tolerance=CYCLE.tolerance
        )
        spent.append(time.perf_counter() - start)
        found.append(float(throws.path.duration[k]) / best.duration - 1.0)
    return found, spent


def measure(percent: float) -> Numbers:
    plan_rows = plan(percent)
    throws = plan_rows(slice(0, PICKS))
    loss, spent = losses(throws, percent)
    return {
        "us_per_pick": {str(batch): 1e6 * seconds_each(batch, plan_rows) for batch in BATCHES},
        "straight_share": float(np.sum(throws.release.straight)) / PICKS,
        "infeasible_share": float(np.mean(~throws.good)),
        "loss_mean": float(np.mean(loss)),
        "loss_max": float(np.max(loss)),
        "loss_picks": len(loss),
        "optimum_median_s": float(np.median(spent)),
    }


def show(percent: float, numbers: Numbers) -> None:
    times = "  ".join(f"{batch}: {value:,.0f}" for batch, value in numbers["us_per_pick"].items())
    print(f"{percent:.0f} %   us per pick by batch  {times}")
    print(
        f"       straight {numbers['straight_share']:.2%}, infeasible {numbers['infeasible_share']:.2%}, "
        f"slower than the optimum by {numbers['loss_mean']:.2%} on average, {numbers['loss_max']:.2%} at most "
        f"({numbers['loss_picks']} picks, {numbers['optimum_median_s']:.2f} s each)",
        flush=True,
    )


def main() -> None:
    parser = argparse.ArgumentParser(description="Time throws in a free direction.")
    parser.add_argument("--json", type=Path, help="write the numbers to this file too")
    arguments = parser.parse_args()
    numbers = {}
    for percent in PERCENTS:
        numbers[f"{percent:.0f}"] = measure(percent)
        show(percent, numbers[f"{percent:.0f}"])
    if arguments.json:
        write_json(arguments.json, {"picks": PICKS, "by_percent": numbers})


if __name__ == "__main__":
    main()
