"""What the order of picks is worth, on equal streams of objects, and which patience suits `atc`."""

from __future__ import annotations

from typing import Any

import numpy as np

from agents.ground import metrics
from agents.results.study import Amount, Figures, Settings
from benchmarks.studies.cells import generators
from benchmarks.studies.throws import throw
from pnt_gym.arrays import Floats
from pnt_gym.cells.conveyor.belt.belt_picks import BeltPicks
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.planner import PickPlanner


def _by_shift(settings: Settings, rule: str, amount: Amount) -> dict[str, Floats]:
    """Figures of each shift (S,)."""
    thrown = throw({**settings, "picks": "belt", "level": {**settings["level"], "dispatch": rule}}, amount)
    time, successes, passed = (thrown.by_shift(name).sum(axis=0) for name in ("cycle_time", "is_success", "passed"))
    return {
        "picks_per_min": 60.0 * amount.throws / time,
        "sorted_per_min": 60.0 * successes / time,
        "recovery": successes / (amount.throws + passed),
        "success": successes / amount.throws,
        "passed_per_pick": passed / amount.throws,
    }


def rules(settings: Settings, amount: Amount) -> list[Figures]:
    """Figures of each rule with their intervals over shifts, and their gains over the first rule, shift by shift.

    Args:
        settings: `level`, the `rules`, and the number of `shifts`.
        amount: throws of each shift.
    """
    by_rule = {rule: _by_shift(settings, rule, amount) for rule in settings["rules"]}
    first = next(iter(by_rule.values()))
    rows: list[Figures] = []
    for rule, shifts in by_rule.items():
        gains = {
            f"{name}_gain": None if shifts is first else vars(metrics.interval(shifts[name] / first[name] - 1.0))
            for name in ("picks_per_min", "sorted_per_min", "recovery")
        }
        rows.append(
            {"rule": rule, **{name: vars(metrics.interval(column)) for name, column in shifts.items()}, **gains}
        )
    return rows


def patience(settings: Settings, amount: Amount) -> Figures:
    """Mean gain in picks a minute of `atc` over `first`, by plans alone: how long a cycle takes needs no physics.

    Args:
        settings: `level`, the `patience` [s], the number of `shifts`, and `seed_offset`, which is added to the seed so
            that other streams are met than those on which rules are judged.
        amount: throws of each shift.
    """
    level, shifts, seed = settings["level"], settings["shifts"], amount.seed + settings["seed_offset"]
    atc = {**level, "dispatch": "atc", "patience": settings["patience"]}
    pace, first = (
        _pace_of_plans(rule_level, amount.throws, shifts, seed) for rule_level in (atc, {**level, "dispatch": "first"})
    )
    return {"gain": float((pace / first).mean() - 1.0)}


def _pace_of_plans(level: dict[str, Any], throws: int, shifts: int, seed: int) -> Floats:
    """Picks a minute of each shift (S,), by plans alone."""
    config = ConveyorConfig.load(level)
    planner = PickPlanner(config)
    source = BeltPicks(planner, generators(shifts, seed))
    context, total = source.first(np.arange(shifts)), np.zeros(shifts)
    for _ in range(throws):
        motion = planner.mover.throw(context.pick, context.plan, context.throw_limits, context.ceiling)
        following = source.following(motion, planner.config.robot.limits(context.objects.percent))
        total += motion.stop_time + following.back.durations.sum(axis=1) + config.motion.dwell
        context = following.context
    return 60.0 * throws / total
