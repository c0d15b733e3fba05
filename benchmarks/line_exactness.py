"""Compare the choices of robots of a line with the plans of the conveyor's planner, each case planned by itself.

`python benchmarks/line_exactness.py` compares 10,000 random cases: an object, a bin and a speed setting in the state of
a line in mid-shift. The exit code is 1 if a case is feasible by one of the two alone, or if a time differs by more than
a millisecond.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from benchmarks.checks import check_parser, choices
from pnt_gym.arrays import take
from pnt_gym.cells.conveyor.movers.straight import ThrowMotion
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.cells.line.cell import LineCell
from pnt_gym.cells.line.config import LineConfig
from pnt_gym.cells.line.rows import CHOICES
from pnt_gym.planning.motion.limits import LimitRows

FIGURES: Final = ("lift", "wait", "throwing", "stop")
LEVELS: Final = ("single", "value", "speed", "line3", "skills3", "skills3_burst")
MOST: Final = 1e-3
"""Of a difference of times [s], and of places [m]."""


@dataclass
class Comparison:
    """Cases, and how they differ."""

    cases: int = 0
    feasible: int = 0
    """Of them, by the planner alone."""
    unlike: int = 0
    """Feasible on one side only, or a case that the line does not offer while it has places left."""
    hidden: int = 0
    """Feasible cases that did not find a place among the choices."""
    worst: float = 0.0
    """Largest difference of any of `FIGURES` [s or m]."""


def alone(cell: LineCell, planner: PickPlanner, index: int, into: int, percent: float) -> dict[str, Any] | None:
    """One case of the first line, planned as a single row; None where it is not feasible."""
    state, config = cell.state, planner.config
    robot = int(state.robot[0])
    objects = take(cell.stream.objects, (np.zeros(1, dtype=np.int64), np.array([index])))
    objects = objects.replace(percent=np.array([percent]))
    x = cell.stream.x[0, index] + config.belt.speed * state.clock[0] - cell.config.robots[robot].x
    limits, hand = LimitRows.t3kr(objects.percent), state.arms["hand"][:1, robot]
    met = planner.mover.reach(ThrowMotion.resting(hand), planner.pick_point(objects, np.array([x])), limits)
    if not met.feasible[0] or met.time[0] > cell.config.horizon:
        return None
    context, good = planner.plan_into(objects, met.position, np.array([into]))
    if not good[0]:
        return None
    motion = planner.mover.throw(context.pick, context.plan, context.throw_limits, context.ceiling)
    return {
        "lift": met.time[0] + config.motion.dwell,
        "wait": met.wait[0],
        "throwing": motion.stop_time[0],
        "stop": motion.stop[0],
    }


def cases_of(cell: LineCell) -> list[tuple[int, int, float]]:
    """Objects, bins and speed settings that the robot whose turn it is might think of, far ones included."""
    state, config = cell.state, cell.config
    robot = int(state.robot[0])
    cell_config = config.cell_of(robot)
    kinds, able = cell.stream.objects.measured.kind[0], config.can_take()[robot]
    x = cell.stream.x[0] + cell_config.belt.speed * state.clock[0]
    low, high = config.reach
    in_reach = (x >= low) & (x <= high) & (state.accounts["since"][0] <= state.clock[0]) & able[kinds]
    accepts = cell_config.acceptance()
    return [
        (int(i), int(b), float(p))
        for i in np.flatnonzero(in_reach)
        for b in np.flatnonzero(accepts[kinds[i]])
        for p in cell_config.limits.percent
    ]


def compare(cell: LineCell, planners: list[PickPlanner], comparison: Comparison) -> None:
    """All cases of the coming decision of the first line."""
    choices = take(cell.state.choices, 0)
    offered = {
        (int(choices["index"][k]), int(choices["bin"][k]), float(choices["percent"][k])): k
        for k in np.flatnonzero(choices["real"])
    }
    planner, met = planners[int(cell.state.robot[0])], 0
    for case in cases_of(cell):
        figures, k = alone(cell, planner, *case), offered.pop(case, None)
        comparison.cases += 1
        met += figures is not None
        if figures is None or k is None:
            comparison.unlike += figures is None and k is not None
            continue
        for name in FIGURES:
            comparison.worst = max(comparison.worst, float(np.abs(choices[name][k] - figures[name]).max()))
    comparison.unlike += len(offered) + abs(min(met, CHOICES) - int(choices["real"].sum()))
    comparison.hidden += max(met - CHOICES, 0)
    comparison.feasible += met


def compare_shift(level: Any, cases: int, seed: int) -> Comparison:
    """Cases of the decisions of a shift at random, and of those that follow."""
    config = LineConfig.load(level)
    cell, random, comparison = LineCell(config, 1), np.random.default_rng(seed), Comparison()
    planners = [PickPlanner(cell_config) for cell_config in config.cells()]
    cell.reset(np.arange(1), [np.random.default_rng(seed)])
    while comparison.cases < cases:
        compare(cell, planners, comparison)
        cell.take(choices(cell.state.choices["real"], random))
        if cell.over.any():
            cell.reset(np.arange(1), cell.generators)
    return comparison


def main() -> int:
    """Compare; exit code 1 where they differ."""
    parser = check_parser(__doc__)
    parser.add_argument("--cases", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    bad = False
    for level in LEVELS:
        comparison = compare_shift({"base": level, "throws": "flight"}, options.cases // len(LEVELS), options.seed)
        bad |= comparison.unlike > 0 or comparison.worst > MOST
        print(
            f"{level}: {comparison.cases} cases, {comparison.feasible} feasible, {comparison.unlike} unlike, largest "
            f"difference {comparison.worst:.1e} s or m"
        )
    return int(bad)


if __name__ == "__main__":
    sys.exit(main())
