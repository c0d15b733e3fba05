"""The throw of Hassan et al. 2022 with a release in any direction: the quickest motion under the same limits.

Picks, targets, release ceiling, tolerance and vertical approach are those of Table I. The hand stays above the falling
object until object and hand are apart. The parts `headroom-...` vary the hand's greatest height and the window after
the release.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache, partial
from typing import Any, Final, TypeAlias

import numpy as np

from agents.ground.drawings import COLOURS, WIDTH, Axes, dress, subplots, svg
from agents.reproduce.finding import Findings, Row
from pnt_gym.arrays import concatenate_records, length
from pnt_gym.planning import InfeasibleThrow
from pnt_gym.planning.free.rules import HandRules
from pnt_gym.planning.motion.trajectory import JerkTrajectory, Segments

from ..common.fastest import NoMotionFound
from . import cases
from .figures import draw_flight, side_view
from .per_pick import CYCLE, Cell, cell_mover, loss_rows, per_pick_cycle, per_pick_grid, timing_rows, two_phases
from .planning.cycle import Cycle
from .planning.optimum import fastest_throw
from .planning.throw_check import SAMPLE_RATE, check_throw
from .simulated import simulate, simulation_details, simulation_rows

OPTIMUM: Final = "table1/limits-respected/free-direction-throw"
PER_PICK: Final = "table1/limits-respected/free-direction-per-pick"
CONSTANT_JERK: Final = "table1/constant-jerk/free-direction-throw"
KEPT_MISS: Final = math.sqrt(2.0) * CYCLE.tolerance + cases.LIMIT_TOLERANCE
"""Greatest planned miss [m]: throws are aimed short of the target by delta along x or y, so by up to delta sqrt 2."""
RULES: Final = cell_mover(40).rules
"""Rules that bind the hand besides the limits: the conveyor cell's rules, without a window after the release."""
PlannedCycles: TypeAlias = Mapping[Cell, Cycle | str]
"""The cycles of every cell of Table I, or the reason why a cell has none."""
HEADROOM: Final = {
    "hand-cap-0": replace(RULES, hand_cap=0.0),
    "hand-cap-0.05": replace(RULES, hand_cap=0.05),
    "window-10ms": replace(RULES, window=0.010),
    "window-30ms": replace(RULES, window=0.030),
}
"""Rules with a lower roof for the hand, or with a window after the release in which the hand keeps its motion."""

EXAMPLE: Final = ("outside", 45)
"""Zone and percentage of the cycle from the first pick that is drawn."""
RATE: Final = 2000.0
"""Samples per second of the drawn motions [Hz]."""


def free_findings() -> Findings:
    """The optimum in every cell, the loss of the planning per pick against the optimum, and a drawing of two throws."""
    best = optima(RULES)
    quick = plan_cycles(per_pick_cycle)
    note = (
        "as the conveyor cell plans it with planner: free_direction, pick by pick and before the next pick is known, "
        f"beside the optimum for a known next pick; {describe_bounds(RULES)}"
    )
    later = [*loss_rows(PER_PICK, _feasible_cycles(quick), _feasible_cycles(best)), *timing_rows(PER_PICK, KEPT_MISS)]
    rows = [
        *free_rows(OPTIMUM, best, RULES, f"fastest motion found in a free direction; {describe_bounds(RULES)}"),
        *free_rows(PER_PICK, quick, RULES, note),
        *later,
    ]
    drawing = free_figure(free_cycle)
    return Findings(tuple(rows), figures={"hassan_free_direction.svg": drawing}, grids=(per_pick_grid(later),))


def constant_jerk_findings() -> Findings:
    """The optimum in every cell with J = 3000 m/s3 at every percentage."""
    cycles = plan_cycles(partial(free_cycle, constant_jerk=True))
    note = f"fastest motion found in a free direction, J = 3000 m/s3 at every percentage; {describe_bounds(RULES)}"
    return Findings(tuple(free_rows(CONSTANT_JERK, cycles, RULES, note, constant_jerk=True)))


def headroom_findings(variant: str) -> Findings:
    """The optimum in every cell under one further bound on the hand, stated in the name."""
    rules = HEADROOM[variant]
    return Findings(
        tuple(free_rows(f"headroom/{variant}", optima(rules), rules, f"as {OPTIMUM}, but {describe_bounds(rules)}"))
    )


def optima(rules: HandRules) -> PlannedCycles:
    """The fastest cycles of every cell under the limits with scaled jerk."""
    return plan_cycles(partial(free_cycle, rules=rules), f"{describe_bounds(rules)}: ")


def plan_cycles(plan: Callable[[str, int], Cycle], prefix: str = "") -> PlannedCycles:
    """Cycles that ``plan`` finds for zone and percentage of every cell; a reason begins with the text ``prefix``."""
    cycles: dict[Cell, Cycle | str] = {}
    for cell in cases.CELLS:
        try:
            cycles[cell] = plan(*cell).require()
        except (NoMotionFound, InfeasibleThrow) as error:
            cycles[cell] = f"{prefix}{error}"
    return cycles


@cache
def free_cycle(zone: str, percent: float, rules: HandRules = RULES, *, constant_jerk: bool = False) -> Cycle:
    """The fastest cycles of the loop with a release in any direction, one row per pick.

    Raises:
        NoMotionFound: the solver found no motion within all bounds for a pick of the loop.
    """
    limits = cases.limits_at(percent, constant_jerk=constant_jerk)
    throws = [
        fastest_throw(*ends, limits, ceiling=cases.CEILING, tolerance=CYCLE.tolerance, rules=rules)
        for ends in zip(*cases.scene(zone), strict=True)
    ]
    return two_phases(
        stack_paths([throw.path for throw in throws]),
        np.array([throw.release_time for throw in throws]),
        np.stack([throw.position for throw in throws]),
        np.stack([throw.velocity for throw in throws]),
    )


def stack_paths(paths: Sequence[JerkTrajectory]) -> JerkTrajectory:
    """Paths as rows of one path; rows with fewer segments end in segments of no duration."""
    count = max(path.durations.shape[1] for path in paths)
    padded = [Segments(path.durations, path.jerks).pad(count) for path in paths]
    return concatenate_records(
        [
            replace(path, durations=segments.durations, jerks=segments.jerks)
            for path, segments in zip(paths, padded, strict=True)
        ]
    )


def describe_bounds(rules: HandRules) -> str:
    """Greatest height of the hand and window after the release, in words."""
    window = f"a window of {1e3 * rules.window:.0f} ms" if rules.window else "no window"
    return f"the hand at most {rules.hand_cap:.2f} m above the release ceiling, {window} after the release"


def free_rows(
    folder: str, plans: PlannedCycles, rules: HandRules, note: str, *, constant_jerk: bool = False
) -> list[Row]:
    """One row for every cell, planned or infeasible, and rows that sum up the simulation of all cells."""
    names = {cell: f"{folder}/{cell[0]}/{cell[1]}" for cell in cases.CELLS}
    measured = simulate(
        {names[cell]: (cycle, cases.TARGETS[cell[0]]) for cell, cycle in _feasible_cycles(plans).items()}
    )
    rows: list[Row] = []
    for cell, name in names.items():
        cycle = plans[cell]
        if isinstance(cycle, str):
            rows.append(Row.missing(name, None, "picks/min", "infeasible", note=cycle))
            continue
        details = free_details(cell, cycle, rules, constant_jerk=constant_jerk) | simulation_details(measured[name])
        rows.append(Row.ours(name, cases.picks_per_min(cycle), "picks/min", note=note, **details))
    return rows + (simulation_rows(folder, measured.values()) if measured else [])


def _feasible_cycles(plans: PlannedCycles) -> dict[Cell, Cycle]:
    return {cell: cycle for cell, cycle in plans.items() if isinstance(cycle, Cycle)}


def free_details(cell: Cell, cycle: Cycle, rules: HandRules, *, constant_jerk: bool = False) -> dict[str, Any]:
    """Entries of a cell's row: picks per minute over the published throw, and limits and rules checked at 10 kHz."""
    targets, limits = cases.scene(cell[0])[1], cases.limits_at(cell[1], constant_jerk=constant_jerk)
    check = check_throw(cycle.path, cycle.release_time, targets, limits, cases.CEILING, rules)
    best = float(cases.PUBLISHED["min-time-throw", *cell])
    top = cycle.sample(rate=SAMPLE_RATE).position[..., 2].max(axis=1) - cases.CEILING
    level = np.hypot(cycle.release_velocity[:, 0], cycle.release_velocity[:, 1])
    return {
        "published_best": best,
        "over_published_best": cases.picks_per_min(cycle) / best - 1.0,
        "limits_kept": bool(check.keeps_rules(KEPT_MISS).all()),
        "peak_velocity_ratio": float(check.velocity.max()),
        "peak_acceleration_ratio": float(check.acceleration.max()),
        "peak_jerk_ratio": float(check.jerk.max()),
        "least_gap_m": float(check.gap.min()),
        "hand_above_ceiling_m": float(top.max()),
        "inside_workspace_m": float(-check.outside.max()),
        "planned_miss_m": float(check.landing.max()),
        "release_angles_deg": np.degrees(np.arctan2(cycle.release_velocity[:, 2], level)).tolist(),
        **cases.cycle_details(cycle),
    }


def free_figure(free: Callable[[str, float], Cycle]) -> str:
    """Drawing of the straight throw and of the throw in a free direction as SVG: side view, speed, acceleration."""
    cycles = {
        "straight throw": cases.cell_cycle("limits-respected", "min-time-throw", *EXAMPLE),
        "free direction": free(*EXAMPLE),
    }
    figure, axes = subplots(4, 1, (WIDTH, 11.0), height_ratios=(0.6, 0.8, 1.0, 1.0))
    for k, (name, cycle) in enumerate(cycles.items()):
        _draw_side_view(axes[k], cycle, f"{name}: pick to pick in {cycle.duration[0]:.3f} s")
    handles = axes[0].get_legend_handles_labels()
    axes[1].legend(*handles, fontsize=8, ncols=3, loc="upper center", bbox_to_anchor=(0.5, -0.28))
    limits = cases.limits_at(EXAMPLE[1]).numbers()
    for k, name in enumerate(("speed [m/s]", "acceleration [m/s²]")):
        _draw_over_time(axes[2 + k], cycles, k, name, limits[k])
    axes[2].legend(fontsize=8)
    figure.suptitle(f"first pick, target {EXAMPLE[0]}, {EXAMPLE[1]} % of the robot's limits, J scaled", fontsize=11)
    return svg(figure)


def _draw_side_view(axes: Axes, cycle: Cycle, title: str) -> None:
    """Draw the hand before and after the release, the object in flight, and the ceiling of the release."""
    released, ended = float(cycle.release_time[0]), float(cycle.duration[0])
    for k, (begin, end, label) in enumerate(((0.0, released, "hand and object"), (released, ended, "hand alone"))):
        points = cycle.sample(np.linspace(begin, end, 400)).position[0]
        axes.plot(*side_view(points, EXAMPLE[0]), color=COLOURS[k], label=label)
    draw_flight(axes, cycle, EXAMPLE[0], "black")
    axes.axhline(cases.CEILING, color=COLOURS[3], linewidth=1, label="ceiling of the release")
    across, up = "distance from the pick towards the target [m]", "height z [m]"
    dress(axes, across, up, title, aspect="equal", ylim=(-0.88, -0.56))


def _draw_over_time(axes: Axes, cycles: Mapping[str, Cycle], row: int, name: str, limit: float) -> None:
    """Draw speed (row 0) or acceleration (row 1) of both cycles, and the limit."""
    for colour, (title, cycle) in zip((COLOURS[2], COLOURS[4]), cycles.items(), strict=True):
        times = np.arange(0.0, cycle.duration[0], 1.0 / RATE)
        motion = cycle.sample(times)
        axes.plot(times, length((motion.velocity, motion.acceleration)[row][0]), color=colour, label=title)
        axes.axvline(cycle.release_time[0], color=colour, linestyle=":", linewidth=1)
    axes.axhline(limit, color=COLOURS[3], linestyle="--", linewidth=1, label="limit")
    dress(axes, "time [s]; dotted: release", name, ylim=(0.0, None))
