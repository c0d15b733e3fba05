"""Predicted outcomes of logged throws in a cell with given parameters: the planner's and the flight's own equations.

No hidden value of a simulation comes in here: objects are made from what the log's gauges read (`hidden`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final, cast, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, concatenate_records, join_columns, length, take
from pnt_gym.cells.base.airborne import Airborne
from pnt_gym.cells.base.items import CUP_RADIUS, ItemTable, item_arrays
from pnt_gym.cells.conveyor.config import LIP_GAP, ConveyorConfig
from pnt_gym.cells.conveyor.context import (
    Context,
    HiddenCell,
    HiddenDrift,
    ThrowBins,
    apply_bias,
    constant_bias,
    unseen_grasp,
)
from pnt_gym.cells.conveyor.cup.hold import Grips, smallest_margin, true_hold
from pnt_gym.cells.conveyor.free import cross_rims
from pnt_gym.cells.conveyor.hand import HandCycle, ThrowClock
from pnt_gym.cells.conveyor.objects.drawing import cup_numbers, random_spin, release_delay, spin_at_grasp
from pnt_gym.cells.conveyor.objects.kernel import inside_outline
from pnt_gym.cells.conveyor.objects.records import Measured, Objects
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.cells.conveyor.shift import apply_cell, apply_drift
from pnt_gym.planning.motion.ballistics import flight_time, landing_point
from pnt_gym.planning.motion.trajectory import HandPath, JerkTrajectory
from pnt_gym.planning.straight.plan import ReleaseBatch
from pnt_gym.rows import Rows1

from ..ground.cli import UsageError
from .hidden import NORMALS, Hidden, draw_hidden, standard_draws
from .log import ThrowLog

PLANNERS: Final = ("straight", "straight_flying")
"""Planners whose throws follow from pick and release alone."""
DRAWS: Final = 32
"""Draws of each throw's hidden values."""
CHUNK: Final = 256
"""Throws simulated at once, so that their arrays stay in the processor's cache."""
SPEED_TOLERANCE: Final = 0.05
"""Largest relative difference of a logged release speed from that of the level's limits."""
COARSE: Final = 0.004
"""Time between two accelerations at which a grip is judged [s]."""
RUN_UP: Final = 0.1
"""Time that a hand of unknown motion moves evenly to its release, as it does after it [s]."""
QUICK: Final = 2
"""Physics steps of the level in one step of a quick prediction; its error of a millimetre is the same for all draws."""


@final
@dataclass(frozen=True)
class Outcomes:
    """Predicted outcomes of M throws."""

    landing: Floats
    """Where an object that is thrown, and not touched again, crosses the plane of the rims (M, 2) [m]."""
    touched: Bools
    """Whether the cup touches the object again after the release (M,)."""
    sealed: Floats
    """Chance that the cup seals (M,)."""
    holds: Bools
    """Whether a cup that has sealed holds the object until the release (M,)."""


@final
class ThrowModel:
    """Predicts the outcomes of logged throws.

    Args:
        log: the throws.
        config: the cell, whose parameters a call may replace.
        draws: draws of each throw's hidden values, an even number; they are the same at all parameters. 0 is enough for
            landings at mean hidden values.

    Raises:
        UsageError: the level's planner, or a release that its limits do not give.
    """

    def __init__(self, log: ThrowLog, config: ConveyorConfig, draws: int = DRAWS) -> None:
        if not log.has_free_motion and config.planner not in PLANNERS:
            raise UsageError(
                f"planner is {config.planner!r}; `fit` knows the throws of {' and '.join(PLANNERS)}, and with "
                "--free-motion throws of any motion"
            )
        if log.has_free_motion:  # nobody knows how its accelerations made an object swing
            config = config.model_copy(update={"cup": config.cup.model_copy(update={"stiffness": None})})
        self.log, self.config, self.draws = log, config, draws
        self._table = item_arrays(config.item_list())
        self.flown = ~((log.sealed == 0.0) | (log.lost == 1.0))
        """Which throws have a flight; others have NaN landings (N,)."""
        self.chances = self._table.pick_chance.copy()
        """Chance of each item that a cup well inside its outline seals (K,)."""
        normals = {"mean": np.zeros((len(log), 1, len(NORMALS)))}
        normals |= {"draws": standard_draws(len(log), draws)} if draws else {}
        self._hidden = {name: draw_hidden(log, config, numbers) for name, numbers in normals.items()}
        self._objects = {name: _objects(hidden, log, config, self._table) for name, hidden in self._hidden.items()}
        self._planner = PickPlanner(config)
        self._set_up_motions()

    def _set_up_motions(self) -> None:
        """Motions of the hands, from the commanded releases: the planner's, or even ones with the logged velocity."""
        log, config, objects = self.log, self.config, self._objects["mean"]
        pick, count = _picks(log, config), len(log)
        limits, _ = self._planner.grip_limits(objects, pick)
        rim = np.full(count, config.bins.rim)
        target = np.concatenate([landing_point(log.release, log.velocity, rim)[:, :2], rim[:, None]], axis=1)
        target = np.where(np.isfinite(target), target, log.release)
        picks = Context.new(
            objects, pick, ThrowBins(target, np.ones((count, 2)), np.zeros(count, dtype=np.int64)), np.ones((count, 1)),
            throw_limits=limits, plan=cast("ReleaseBatch", None), ceiling=pick[:, 2] + config.motion.ceiling,
            belt=config.belt,
        )  # fmt: skip
        if log.has_free_motion:
            self._picks = picks
            self._set_up_even_motions(pick, rim)
            return
        releases = self._planner.mover.release_at(picks, log.release)
        # The level's limits must give the logged releases.
        logged, planned = length(log.velocity), releases.speed
        wrong = ~(np.abs(np.nan_to_num(planned) - logged) <= SPEED_TOLERANCE * logged)
        if wrong.any():
            first = int(np.flatnonzero(wrong)[0])
            raise UsageError(
                f"{wrong.sum()} of {len(log)} releases do not have the speed that the level's limits give on the way "
                f"from the pick (throw {first + 1}: {logged[first]:.2f} m/s logged, {planned[first]:.2f} m/s by the "
                "level); check percent, belt.speed, and that pick and release are the cup's, or give --free-motion for "
                "a robot that moves otherwise"
            )
        self._picks = picks.replace(plan=releases)
        self.move(releases)

    def aim(self, offset: Floats) -> None:
        """Move the releases off those of the log, as a residual of the planner does.

        Args:
            offset: from the drag-free landings of the log's releases, along and left of the throws (N, 2) [m].
        """
        picks = self._picks
        goal = picks.target + picks.from_throw_frame(*offset.T)
        self.move(self._planner.mover.aim_at(picks, goal, self.config.motion.ceiling_slack))

    def move(self, releases: ReleaseBatch) -> None:
        """Let the hands move to releases of N throws at the targets of the log."""
        self.releases = releases
        self.__dict__.pop("_motion", None)

    @cached_property
    def _motion(self) -> tuple[HandPath, Floats]:
        """Paths of the hands, and the times of their releases (N,) [s]; planned when a throw is predicted."""
        picks = self._picks
        motion = self._planner.mover.throw(picks.pick, self.releases, picks.throw_limits, picks.ceiling)
        return motion.path, motion.release_time

    def _set_up_even_motions(self, pick: Floats, rim: Floats) -> None:
        """Motions of hands that keep the logged velocities before and after their releases."""
        log, count = self.log, len(self.log)
        flight = flight_time(log.release, log.velocity, rim)
        if not np.isfinite(flight).all():
            first = int(np.flatnonzero(~np.isfinite(flight))[0])
            raise UsageError(
                f"throw {first + 1} never comes down to the rims of the bins at {rim[first]:g} m; check release_z, "
                "release_vz and bins.rim"
            )
        release_time = np.full(count, RUN_UP)
        self.releases = ReleaseBatch.from_velocities(
            pick, log.release, log.velocity, log.velocity, ceiling_active=np.zeros(count, dtype=np.bool_),
            reason=np.zeros(count, dtype=np.int64), acceleration=np.zeros(count), time=release_time,
            flight_time=flight,
        )  # fmt: skip
        start, duration = log.release - RUN_UP * log.velocity, np.full((count, 1), 2.0 * RUN_UP)
        path = JerkTrajectory(start, duration, np.zeros((count, 1, 3)), log.velocity, rides=True)
        self._motion = path, release_time

    def landings(self, config: ConveyorConfig, draught: tuple[float, float] = (0.0, 0.0)) -> Floats:
        """Landings (N, 2) [m] of throws at the conditional means of their hidden values; NaN without a flight."""
        context = self._context("mean", config)
        if any(draught):
            wind = np.tile(np.array(draught), (len(context.pick), 1))
            context = context.replace(drift=context.drift.replace(draught=wind))
        return self._fly(context, self._hidden["mean"].row, config)[0]

    def quick_landings(self, configs: Sequence[ConveyorConfig]) -> Floats:
        """Landings (C, N, 2) [m] of the same throws in C cells, by longer steps; changes from cell to cell are true."""
        contexts = concatenate_records([self._context("mean", config) for config in configs])
        rows, first = np.tile(self._hidden["mean"].row, len(configs)), configs[0]
        landing, _ = self._fly(contexts, rows, first.model_copy(update={"timestep": QUICK * first.timestep}))
        return landing.reshape(len(configs), -1, 2)

    def landings_in(self, cells: HiddenCell, drift: HiddenDrift, row: Ints) -> Floats:
        """Landings (M, 2) [m] of throws `row` (M,), each in a cell and with a drift of its own, as `quick_landings`."""
        config = self.config.model_copy(update={"timestep": QUICK * self.config.timestep})
        context = apply_cell(take(self._context("mean", config), row), cells, config)
        return self._fly(apply_drift(context, drift, config), row, config)[0]

    def outcomes(self, config: ConveyorConfig) -> Outcomes:
        """Outcomes (N x K,) of throws at the draws of their hidden values, K of each throw in a row."""
        context, row = self._context("draws", config), self._hidden["draws"].row
        quick = config.model_copy(update={"timestep": QUICK * config.timestep})
        landing, touched = self._fly(context, row, quick, watch=not self.log.has_free_motion)
        landing += (self.landings(config) - self.quick_landings([config])[0])[row]
        return Outcomes(landing, touched, self.seals(config), self._holds(context, row, config))

    def seals(self, config: ConveyorConfig) -> Floats:
        """Chances that the cups seal at the draws of hidden values (N x K,)."""
        if not config.pick.fails:
            return np.ones(len(self._hidden["draws"].row))
        chance = self.chances[self._objects["draws"].kind] * self.overhangs(config)
        return np.clip(1.0 - config.mismatch * (1.0 - chance), 0.0, 1.0)

    def overhangs(self, config: ConveyorConfig) -> Floats:
        """Shares of the items' seal chances at the draws of hidden values (N x K,); as of `cup.hold.fail_chance`."""
        hidden, objects = self._hidden["draws"], self._objects["draws"]
        pick = self._picks.pick[hidden.row]
        grasp = hidden.grasp + unseen_grasp(constant_bias(config, len(pick)), pick, config.belt)
        grasp[:, 0] += hidden.belt_error * (pick[:, 0] - config.belt.camera_x)
        inside, radius = inside_outline(objects.rows, -grasp), objects.cup_radius
        return np.clip((inside + radius) / (2.0 * radius), 0.0, 1.0)

    def _context(self, name: str, config: ConveyorConfig) -> Context:
        """Picks of objects with hidden values, in a cell with given parameters."""
        hidden, base, m = self._hidden[name], self._objects[name].replace(**cup_numbers(config)), config.mismatch
        delay = release_delay(base.seal, base.mass, base.valve, base.tau, config.suction)
        delay = m * (delay + self._table.clings[base.kind])
        spin = spin_at_grasp(base.replace(grasp=np.zeros_like(hidden.grasp)), hidden.grasp, config)
        if not config.cup.peel:
            spin = spin + random_spin(hidden.spin, np.zeros_like(hidden.grasp))
        objects = base.replace(delay=np.maximum(delay + hidden.jitter, 0.0), spin=spin)
        picks = take(self._picks.replace(objects=self._objects["mean"], plan=self.releases), hidden.row)
        shift = hidden.belt_error * (picks.pick[:, 0] - config.belt.camera_x)
        picks = picks.replace(objects=objects, belt_shift=shift)
        return apply_bias(picks, config) if config.bias.applies else picks

    def _fly(self, context: Context, row: Ints, config: ConveyorConfig, watch: bool = False) -> tuple[Floats, Bools]:
        """Landings of throws (M, 2) [m], and if watched, which objects the cup touches again (M,)."""
        landing, touched = np.full((len(row), 2), np.nan), np.zeros(len(row), dtype=np.bool_)
        flown = np.flatnonzero(self.flown[row])
        for start in range(0, len(flown), CHUNK):
            part = flown[start : start + CHUNK]
            landing[part], touched[part] = self._fly_part(take(context, part), row[part], config, watch)
        return landing, touched

    def _fly_part(self, context: Context, row: Ints, config: ConveyorConfig, watch: bool) -> tuple[Floats, Bools]:
        count = len(row)
        holds = Grips(np.full(count, np.inf), np.full(count, -1, dtype=np.int64), np.ones(count, dtype=np.bool_))
        path, release_time = take(self._motion[0], row), self._motion[1][row]
        clock = ThrowClock.of(context, HandCycle(take(self.releases, row), release_time, path, holds), config)
        flying = Airborne(context.objects.body, context.drift.draught, config.mismatch)
        landing, records, steps = cross_rims(flying, clock, context.target[:, 2].copy())
        if not watch:
            return landing, np.zeros(count, dtype=np.bool_)
        motion = records[..., :3], records[..., 7:10], records[..., 3:7]
        return landing, clock.meets(context, motion, steps)

    def _holds(self, context: Context, row: Ints, config: ConveyorConfig) -> Bools:
        if not config.grip.limit or self.log.has_free_motion:  # of whose accelerations nothing is known
            return np.ones(len(row), dtype=np.bool_)
        path, release_time = self._motion
        times = COARSE * np.arange(int(np.floor(release_time.max() / COARSE)) + 1)
        loads = path.sample(np.minimum(times, release_time[:, None])).acceleration
        counts = (times <= release_time[:, None]).sum(axis=1)
        return smallest_margin(true_hold(context), loads[row], counts[row], config.mismatch)[1] < 0


def _picks(log: ThrowLog, config: ConveyorConfig) -> Floats:
    """Lifts (N, 3) [m]; a height that the log lacks is that of the belt and the object."""
    table = item_arrays(config.item_list())
    height = np.where(np.isfinite(log.size[:, 2]), log.size[:, 2], table.size[log.kind, 2])
    top = config.belt.height + height + LIP_GAP
    return join_columns(log.pick[:, 0], log.pick[:, 1], 0.0) + join_columns(
        np.zeros(len(log)), 0.0, np.where(np.isfinite(log.pick[:, 2]), log.pick[:, 2], top)
    )


def _objects(hidden: Hidden, log: ThrowLog, config: ConveyorConfig, table: ItemTable) -> Objects:
    """Objects with hidden values; delay and spin, which depend on the parameters, are zero."""
    row, count, kind = hidden.row, len(hidden.row), log.kind[hidden.row]
    rows = Objects.zeros(
        count, kind=kind, shape=table.shape[kind], size=hidden.size, mass=hidden.mass, drag=hidden.drag,
        com_depth=hidden.com_depth, known_depth=max(1.0 - config.mismatch, 0.0) * hidden.com_depth, seal=hidden.seal,
        jitter=hidden.jitter, friction=table.friction[kind], cup_friction=table.cup_friction[kind],
        cup_radius=table.cup_radius[kind] if config.cup.fitted else CUP_RADIUS,
        rolling_friction=table.rolling_friction[kind], restitution=table.restitution[kind], yaw=hidden.yaw,
        grasp=hidden.grasp, belt_error=hidden.belt_error, pick_chance=table.pick_chance[kind], pick_draw=1.0,
        percent=np.nan_to_num(log.percent[row], nan=max(config.limits.percent)),
        measured=_gauge_readings(take(log, row), table),
    )  # fmt: skip
    return Objects(rows, np.zeros((count, max(len(config.bins.fixed), 1))))


def _gauge_readings(log: ThrowLog, table: ItemTable) -> Rows1[Measured]:
    """What the gauges read, or the item's own values where the log lacks them."""
    kind = log.kind

    def fill(read: Floats, usual: Any) -> Floats:
        return np.where(np.isfinite(read), read, usual)

    return Measured.zeros(
        len(log), kind=kind, shape=table.shape[kind], size=fill(log.size, table.size[kind]),
        mass=fill(log.mass, table.mass[kind]), seal=fill(log.seal, table.seal_force[kind]),
        yaw=fill(log.yaw, 0.0), friction=table.cup_friction[kind], grasp_noise=fill(log.grasp, 0.0),
    )  # fmt: skip
