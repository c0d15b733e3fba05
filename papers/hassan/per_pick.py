"""The throw in a free direction as the conveyor cell plans it, pick by pick: loss of picks, and time of planning.

The cell's mover chooses the release before it knows the next pick, and the way back once the next pick is known.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Final, NamedTuple

import numpy as np

from agents.ground.tables import Grid
from agents.reproduce.finding import Row
from agents.reproduce.grids import NONE
from pnt_gym.arrays import Bools, Floats, take
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.movers.free_mover import FreeMover
from pnt_gym.planning import EllipticWorkspace, InfeasibleThrow, JerkTrajectory, Reason, ReleaseBatch
from pnt_gym.robots.t3kr.geometry import T3KR

from .cases import CEILING, CELLS, PICKS, PROTOCOLS, RISE, TARGETS, limits_at, picks_per_min, scene
from .methods import time_call
from .planning.cycle import Cycle
from .planning.throw_check import check_throw
from .trial import trial_context

CYCLE: Final = PROTOCOLS["limits-respected"].rules
"""Rules that Table I leaves open, the same as for the straight throw within the limits."""
WORKSPACE: Final = EllipticWorkspace(T3KR.workspace_x, T3KR.workspace_y, T3KR.z_min, T3KR.z_max)
BATCH: Final = 256
ROUNDS: Final = 9
TIMED: Final = (("inside", 40), ("outside", 45))
"""Cells of Table I whose target and limits the picks have for which planning is timed."""
COUNTS: Final = {
    "picks": "random picks of the belt in one batch",
    "planned": "planned",
    "straight": "of them straight",
    "limits_kept": "of them within limits and rules",
}

Cell = tuple[str, int]


def cell_config(percent: float) -> ConveyorConfig:
    """Configuration of the conveyor cell with the rules of `CYCLE` and no window after the release."""
    return ConveyorConfig.load(
        {
            "base": "nominal_plain",
            "planner": "free_direction",
            "limits": {"percent": (percent,)},
            "motion": {"ceiling": RISE, "clearance": CYCLE.approach, "follow_through": {"window": 0.0}},
        }
    )


def cell_mover(percent: float) -> FreeMover:
    """The conveyor cell's planner of throws in a free direction, at a percentage of the limits."""
    return FreeMover(cell_config(percent), WORKSPACE)


class PlannedThrows(NamedTuple):
    """Planned throws of N picks: which are feasible (N,), and release and motion of the feasible throws."""

    feasible: Bools
    release: ReleaseBatch
    release_time: Floats
    path: JerkTrajectory


def pick_context(picks: Floats, targets: Floats, percent: float) -> Context:
    """The cell's context for throws from picks at targets, each (N, 3) [m], aimed short by delta as in Table I."""
    config, count = cell_config(percent), len(picks)
    # The nearest point of the box of half width delta around the target, on the way to it (Eqs. 16-17).
    way = targets - picks
    aims = targets - CYCLE.tolerance / np.abs(way[:, :2]).max(axis=1)[:, None] * way
    plan = cell_mover(percent).plan(picks, aims, limits_at(percent), np.full(count, CEILING))
    return trial_context(config, config.items[:1] * count, range(count), picks, aims, plan, ceiling=CEILING)


def plan_free_throws(mover: FreeMover, context: Context, following: Floats) -> PlannedThrows:
    """Release, throw and return as the cell's mover plans them, from rest at the picks to rest at the next picks."""
    release = mover.plan(context.pick, context.target, context.limits, context.ceiling)
    feasible = mover.is_feasible(context.pick, release, context.limits)
    feasible_context, release = take(context, feasible), take(release, feasible)
    motion = mover.throw(feasible_context.pick, release, feasible_context.limits, feasible_context.ceiling)
    back = mover.back(motion, following[feasible], feasible_context.limits)
    path = JerkTrajectory.concatenate(motion.pick, [motion.segments, back])
    return PlannedThrows(feasible, release, motion.release_time, path)


def per_pick_cycle(zone: str, percent: float) -> Cycle:
    """The cycles of the loop as the conveyor cell plans them, one row per pick.

    Raises:
        InfeasibleThrow: a pick of the loop has no feasible throw.
    """
    picks, targets, following = scene(zone)
    throws = plan_free_throws(cell_mover(percent), pick_context(picks, targets, percent), following)
    if not throws.feasible.all():
        raise InfeasibleThrow(Reason.WORKSPACE)
    return two_phases(throws.path, throws.release_time, throws.release.position, throws.release.velocity)


def two_phases(path: JerkTrajectory, release_time: Floats, position: Floats, velocity: Floats) -> Cycle:
    """Cycles of two phases, throw and return, whose throw need not be a straight line; every row is feasible."""
    count = len(release_time)
    return Cycle(
        path=path,
        phases=("throw", "return"),
        phase_ends=np.stack([release_time, path.duration], axis=1),
        release_time=release_time,
        release_position=position,
        release_velocity=velocity,
        feasible=np.ones(count, dtype=np.bool_),
        reason=np.full(count, int(Reason.FEASIBLE)),
    )


def loss_rows(folder: str, quick: Mapping[Cell, Cycle], optimum: Mapping[Cell, Cycle]) -> list[Row]:
    """Row with the largest loss of picks per minute against the optimum, over the cells that both have."""
    cells = [cell for cell in quick if cell in optimum]
    if not cells:
        return []
    loss = {cell: 100.0 * (1.0 - picks_per_min(quick[cell]) / picks_per_min(optimum[cell])) for cell in cells}
    worst = max(cells, key=lambda cell: loss[cell])
    note = f"largest loss of picks/min against the optimum, at {worst[0]}/{worst[1]}"
    by_cell = {f"{zone}/{percent}": value for (zone, percent), value in loss.items()}
    return [Row.ours(f"{folder}/loss-max", loss[worst], "%", note=note, loss_by_cell=by_cell)]


def timing_rows(folder: str, near: float) -> Iterator[Row]:
    """Rows with the processor time per pick in a batch of random picks of the belt, and counts of planned throws.

    `near` is the greatest planned distance from the target at which a throw counts as within limits and rules [m].
    """
    for zone, percent in TIMED:
        picks, following = random_picks()
        targets = np.tile(TARGETS[zone], (BATCH, 1))
        mover, context = cell_mover(percent), pick_context(picks, targets, percent)
        throws = plan_free_throws(mover, context, following)
        seconds = min(time_call(partial(plan_free_throws, mover, context, following))[1] for _ in range(ROUNDS)) / BATCH
        aims, limits = targets[throws.feasible], limits_at(percent)
        check = check_throw(throws.path, throws.release_time, aims, limits, CEILING, mover.rules)
        yield Row.ours(
            f"{folder}/time-per-pick-{zone}-{percent}",
            1e6 * seconds,
            "us",
            note=f"release, throw and return: best of {ROUNDS} batches of {BATCH} random picks of the belt at "
            f"{percent} %, target {zone}, one core",
            picks=BATCH,
            planned=int(throws.feasible.sum()),
            straight=int(throws.release.straight.sum()),
            limits_kept=int(check.keeps_rules(near).sum()),
        )


def random_picks() -> tuple[Floats, Floats]:
    """Random picks and next picks, each (BATCH, 3) [m], in the region where the belt brings objects; fixed seed."""
    belt = ConveyorConfig.load().belt
    rng = np.random.default_rng(256)
    low, high = (np.array([belt.pick_x[k], belt.lane_y[k]]) for k in (0, 1))
    level = np.full((2, BATCH, 1), PICKS[0][2])
    points = np.concatenate([rng.uniform(low, high, (2, BATCH, 2)), level], axis=2)
    return points[0], points[1]


def per_pick_grid(rows: Sequence[Row]) -> Grid:
    """Table of the loss of planning per pick against the optimum, and of planning for random picks of the belt."""
    rows_by_name = {row.quantity.rsplit("/", 1)[1]: row for row in rows}
    loss = rows_by_name["loss-max"].details["loss_by_cell"] if "loss-max" in rows_by_name else {}
    costs = [rows_by_name.get(f"time-per-pick-{zone}-{percent}") for zone, percent in CELLS]
    shares = [loss.get(f"{zone}/{percent}") for zone, percent in CELLS]
    lines = [
        ["loss of picks/min against the optimum", *(NONE if share is None else f"{share:.1f} %" for share in shares)]
    ]
    for entry, name in COUNTS.items():
        lines.append([name, *(NONE if row is None else str(row.details[entry]) for row in costs)])
    lines.append(["processor time per pick", *(NONE if row is None else f"{row.reproduced:.0f} us" for row in costs)])
    return Grid("Free direction, planned per pick", ["", *(f"{zone} {percent} %" for zone, percent in CELLS)], lines)
