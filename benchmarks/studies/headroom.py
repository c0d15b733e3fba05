"""The headroom of planning: what the planners of the cell take for a pick, beside the quickest motion found."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, replace
from typing import Final

import numpy as np

from agents.ground import metrics
from agents.results.study import Amount, Figures, Settings
from benchmarks.studies.optimum import NoMotionFound, fastest_throw
from pnt_gym.arrays import Bools, Floats, take
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.movers.free_mover import FreeMover
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.planning.free.rules import HandRules
from pnt_gym.planning.motion.limits import MotionLimits

PLANNERS: Final = ("straight", "straight_flying", "free_direction")
"""Planners of the cell; the first one chooses the bins of the picks."""


def headroom(settings: Settings, amount: Amount) -> Iterator[Figures]:
    """Times from pick to next pick by each planner and by the optimum, on the same picks, one row each.

    Args:
        settings: `level`, with one share of the robot's limits.
        amount: number of picks that every planner can throw.
    """
    planners = {name: PickPlanner(ConveyorConfig.load({**settings["level"], "planner": name})) for name in PLANNERS}
    context, following = _draw(planners, amount)
    times = {name: _planned_times(planner, context, following) for name, planner in planners.items()}
    mover = planners["free_direction"].mover
    assert isinstance(mover, FreeMover)
    for name, rules in (("optimum", mover.rules), ("optimum, no window", replace(mover.rules, window=0.0))):
        times[name] = _optimal_times(context, following, rules)
    solved = np.all([np.isfinite(seconds) for seconds in times.values()], axis=0)
    for name, seconds in times.items():
        own, best = seconds[solved], times["optimum"][solved]
        yield {
            "planner": name,
            "picks": int(solved.sum()),
            "unsolved": int((~solved).sum()),
            "seconds": asdict(metrics.interval(own)),
            "picks_per_min": 60.0 / float(own.mean()),
            "over_optimum": asdict(metrics.interval(own / best - 1.0)),
        }


def _draw(planners: dict[str, PickPlanner], amount: Amount) -> tuple[Context, Floats]:
    """Picks that every planner can throw into the same bin (N,), and the next picks (N, 3) [m]."""
    first = planners[PLANNERS[0]]
    rows, generators = np.arange(4 * amount.throws), [np.random.default_rng([amount.seed, k]) for k in (0, 1)]
    objects, pick = first.draw_picks([generators[0]] * len(rows), rows)
    following = first.draw_picks([generators[1]] * len(rows), rows)[1]
    context, good = first.plan(objects, pick)
    for planner in planners.values():
        good &= _is_planned(planner, context)
    chosen = good.nonzero()[0][: amount.throws]
    return take(context, chosen), following[chosen]


def _is_planned(planner: PickPlanner, context: Context) -> Bools:
    """Which picks a planner can throw into their bins (N,)."""
    plan = planner.mover.plan(context.pick, context.target, context.throw_limits, context.ceiling)
    return planner.mover.is_feasible(context.pick, plan, context.throw_limits)


def _planned_times(planner: PickPlanner, context: Context, following: Floats) -> Floats:
    """Times from rest at the picks to rest at the next picks by a planner (N,) [s]."""
    mover, limits = planner.mover, context.throw_limits
    plan = mover.plan(context.pick, context.target, limits, context.ceiling)
    motion = mover.throw(context.pick, plan, limits, context.ceiling)
    return motion.stop_time + mover.back(motion, following, limits).durations.sum(axis=1)


def _optimal_times(context: Context, following: Floats, rules: HandRules) -> Floats:
    """Times of the quickest motions that the optimum finds (N,) [s]; NaN where it finds none."""
    times = np.full(len(following), np.nan)
    columns = zip(*context.throw_limits, strict=True)
    for row, (limits, pick, target, last) in enumerate(
        zip(columns, context.pick, context.target, following, strict=True)
    ):
        bounds = MotionLimits(*map(float, limits))
        try:
            found = fastest_throw(pick, target, last, bounds, ceiling=float(context.ceiling[row]), rules=rules)
        except NoMotionFound:
            continue
        times[row] = found.duration
    return times
