"""What the order of picks is worth: `dispatch: first` against `soonest` and `atc`, on equal streams of objects.

Shifts of throws at the belt by the analytic planner in the full physics; gaps are between edges, so that every rule
meets the same objects in the same places. The patience of `atc` is tuned before, on streams of other seeds, by plans
alone: how long a cycle takes needs no physics.

Run: python benchmarks/study_dispatch.py --json results/dispatch.json      (some minutes; --tune-only: seconds)
"""

from __future__ import annotations

import sys
from typing import Any, Final

import numpy as np

import pnt_gym
from agents.ground.files import write_json
from agents.ground.metrics import mean_interval
from benchmarks.study import Floats, infos, seeded_cells, study_options, study_parser
from pnt_gym.cells.conveyor.belt.sources import BeltPicks
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.planner import PickPlanner

SHIFTS: Final = 24
PATIENCES: Final = (1.0, 2.0, 4.0, 8.0, 16.0, 32.0)
TUNING_SEED: Final = 1000
"""What is added to the seed for the streams that the patience is tuned on."""
HONEST: Final[dict[str, Any]] = {
    "belt": {"tracking": True, "neighbours": "solid"},
    "pick": {"fails": True},
    "cup": {"stiffness": 1.0, "peel": True, "fitted": True},
    "grip": {"limit": True},
}
"""What `dense` leaves out."""
LEVELS: Final[dict[str, dict[str, Any]]] = {
    "dense": {"base": "dense"},
    "dense, honest": {"base": "dense", **HONEST},
    "nominal": {"base": "nominal"},
    "waste": {"base": "waste"},
}


def shifts(level: dict[str, Any], rule: str, throws: int, seed: int, threads: int) -> dict[str, Floats]:
    """Picks and sorted objects a minute and the share of objects that were sorted, of each shift (SHIFTS,)."""
    config = ConveyorConfig.load({**level, "dispatch": rule, "picks_per_shift": throws})
    core = seeded_cells(config, "belt", SHIFTS, seed, threads)
    zero = np.zeros((SHIFTS, *core.action_space.shape))
    info = infos(core, lambda _: zero, throws * SHIFTS)
    sums = {name: info[name].reshape(throws, SHIFTS).sum(axis=0) for name in ("cycle_time", "is_success", "passed")}
    return {
        "picks_per_min": 60.0 * throws / sums["cycle_time"],
        "sorted_per_min": 60.0 * sums["is_success"] / sums["cycle_time"],
        "recovery": sums["is_success"] / (throws + sums["passed"]),
        "success": sums["is_success"] / throws,
        "passed_per_pick": sums["passed"] / throws,
    }


def compared(level: dict[str, Any], throws: int, seed: int, threads: int) -> dict[str, dict[str, Any]]:
    """Figures of each rule with their intervals over shifts, and their gains over `first`, shift by shift."""
    found = {rule: shifts(level, rule, throws, seed, threads) for rule in ("first", "soonest", "atc")}
    result: dict[str, dict[str, Any]] = {}
    for rule, figures in found.items():
        result[rule] = {name: vars(mean_interval(values)) for name, values in figures.items()}
        for name in ("picks_per_min", "sorted_per_min", "recovery"):
            result[rule][f"{name}_gain"] = vars(mean_interval(figures[name] / found["first"][name] - 1.0))
    return result


def planned_pace(level: dict[str, Any], throws: int, seed: int) -> Floats:
    """Picks a minute of each shift (SHIFTS,), by plans alone."""
    config = ConveyorConfig.load(level)
    planner = PickPlanner(config)
    source = BeltPicks(planner, [np.random.default_rng([seed, row]) for row in range(SHIFTS)])
    context, total = source.first(np.arange(SHIFTS)), np.zeros(SHIFTS)
    for _ in range(throws):
        motion = planner.mover.throw(context.pick, context.plan, context.throw_limits, context.ceiling)
        following = source.following(motion, context.limits)
        total += motion.stop_time + following.back.durations.sum(axis=1) + config.motion.dwell
        context = following.context
    return 60.0 * throws / total


def tuned(throws: int, seed: int) -> dict[str, dict[str, float]]:
    """Mean gain in picks a minute over `first` on each level, for each patience of `atc`."""
    gains: dict[str, dict[str, float]] = {}
    for name, level in LEVELS.items():
        first = planned_pace({**level, "dispatch": "first"}, throws, seed)
        gains[name] = {}
        for patience in PATIENCES:
            pace = planned_pace({**level, "dispatch": "atc", "patience": patience}, throws, seed)
            gains[name][f"{patience:g}"] = float((pace / first).mean() - 1.0)
        print(f"{name:<9}" + "  ".join(f"k {k} s {100 * gain:+.2f} %" for k, gain in gains[name].items()))
        sys.stdout.flush()
    return gains


def main() -> None:
    parser = study_parser(__doc__, 50, f"shift, of which there are {SHIFTS}")
    parser.add_argument("--tune-only", action="store_true", help="stop after the tuning")
    options = study_options(parser)
    gains = tuned(options.throws, options.seed + TUNING_SEED)
    best = max(PATIENCES, key=lambda patience: sum(found[f"{patience:g}"] for found in gains.values()))
    print(f"best patience {best:g} s")
    if options.tune_only:
        return
    result: dict[str, Any] = {"version": pnt_gym.__version__, "seed": options.seed}
    result |= {"throws": options.throws, "shifts": SHIFTS}
    result |= {"tuning": gains, "best_patience": best, "dispatch": {}}
    for name, level in LEVELS.items():
        result["dispatch"][name] = compared(level, options.throws, options.seed, options.threads)
        for rule, found in result["dispatch"][name].items():
            picks, gain, sorted_, recovery = (
                found[which]["value"] for which in ("picks_per_min", "picks_per_min_gain", "sorted_per_min", "recovery")
            )
            print(
                f"{name:<9}{rule:<9}{picks:.1f} picks/min ({100 * gain:+.1f} %)  {sorted_:.1f} sorted/min  "
                f"recovery {100 * recovery:.1f} %"
            )
            sys.stdout.flush()
    if options.json is not None:
        write_json(options.json, result)


if __name__ == "__main__":
    main()
