"""The conveyor cell: N robots at N belts that throw at the same time."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager
from functools import partial
from operator import attrgetter
from typing import Any, ClassVar, Final, Literal, Self, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, Ints, recompute_rows, stand_ins, take_rows
from pnt_gym.cells.base.action import Correction
from pnt_gym.cells.base.canvas import Marker
from pnt_gym.cells.base.cell import Cell, Generators
from pnt_gym.cells.base.recorded import REWARD_TERMS
from pnt_gym.cells.base.view import ThrowView
from pnt_gym.cells.conveyor.action import MODES, correction, modes_of
from pnt_gym.cells.conveyor.belt.belt_picks import BeltPicks
from pnt_gym.cells.conveyor.belt.sources import IndependentPicks, PickSource
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.cup.hold import Grips, grips, picked, slip
from pnt_gym.cells.conveyor.furniture import furniture
from pnt_gym.cells.conveyor.hand import HandCycle
from pnt_gym.cells.conveyor.movers.straight import ThrowMotion
from pnt_gym.cells.conveyor.movers.tracking import empty_motion
from pnt_gym.cells.conveyor.objects.fill import bins_of_cells
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.cells.conveyor.outcome import Outcome, PlannedResults, judge
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.cells.conveyor.plant import ConveyorPlant
from pnt_gym.cells.conveyor.shift import make_drift
from pnt_gym.cells.conveyor.view import camera, objects_on_belt
from pnt_gym.engine import MjData, MjModel
from pnt_gym.planning.motion.rows import Segments
from pnt_gym.planning.motion.trajectory import JerkTrajectory
from pnt_gym.planning.straight.plan import ReleaseBatch

Picks = Literal["belt", "shift", "independent"]
RESULTS: Final = (
    "landing_along", "landing_across", "wait_time", "in_opening", "in_bin", "rim", "recontact", "picked", "dropped",
    "disturbed", "grip_margin", "passed", "placed", "peak_torque", "energy", "ended_in", "belongs", "sorted",
)  # fmt: skip
"""Fields of an outcome that the info contains, under the same names."""


@final
class ConveyorCell(Cell[ConveyorConfig, Context, ReleaseBatch, Outcome]):
    """N cells that throw at the same time: `context` has the coming picks, `throw` simulates them and draws the next.

    Args:
        config: description of the cell.
        count: number of cells N.
        picks: "belt" for a stream of objects on the moving belt, "independent" for unrelated picks, "shift" for
            unrelated picks in episodes as long as on the belt.
        threads: worker threads of the physics; results do not depend on it.
        feedback: whether a camera over the bins measures each landing for the next observation, in shifts.
        source: kind of source of the picks; None for that of `picks`.

    Raises:
        ConfigError: a level that drifts without the camera, or a shift of one pick with the camera.
    """

    modes = MODES
    reward_terms: ClassVar[tuple[str, ...]] = REWARD_TERMS

    def __init__(
        self,
        config: ConveyorConfig,
        count: int,
        picks: Picks,
        threads: int = 1,
        feedback: bool = False,
        source: type[PickSource] | None = None,
    ) -> None:
        super().__init__(config, count, threads)
        self._feedback = feedback
        self._source_kind = source or (BeltPicks if picks == "belt" else IndependentPicks)
        self.terminates = picks == "independent"
        self.episode = 1 if self.terminates else config.picks_per_shift
        self.modes = modes_of(config.planner)
        self.item_names = config.items
        self.target_names = tuple(fixed.name for fixed in config.bins.fixed)
        self.dwell = config.motion.dwell
        self.planner = PickPlanner(config)
        if not config.ships():
            self.planner.warn_of_reach()
        self.plant = ConveyorPlant(config, count, threads)
        self._set_up(self.generators)
        self.context = self.first(np.arange(count))
        self._thrown: Ints = np.arange(count)
        """Rows whose throws are simulated (K,)."""
        self.upstream: tuple[Objects, Floats] | None = None
        """Objects on the belt when the recorded throw began, and their centres (K, 3) [m]; for pictures."""

    def _set_up(self, generators: Generators) -> None:
        """Set up belts, bins and drift of rows that draw from generators, as before the first episode."""
        self._drift = make_drift(self.config, generators, self._feedback)
        self.table, self.hidden = self._drift.table, self._drift.hidden
        self.source: PickSource = self._source_kind(self.planner, generators)
        self._bins = bins_of_cells(self.config, len(generators), carried=not self.terminates)

    def first(self, rows: Ints) -> Context:
        """First picks of an episode for some rows; bins whose contents carry over are empty."""
        picks = self._drift.begin(rows, [self.generators[row] for row in rows], self.source.first(rows))
        return picks.replace(depth=self._bins.begin(rows, picks.depth))

    def target_of(self, throws: Context) -> Ints:
        """Index of the fixed bin that is each throw's target (N,)."""
        return throws.bin

    def scout(self, generators: Generators) -> Self:
        """A copy of this cell with one row per generator and empty belts, to see which first picks they draw."""
        scout = super().scout(generators)
        scout._set_up(generators)
        return scout

    def throw(self, plans: ReleaseBatch) -> Outcome:
        """Simulate the throws of all cells and advance to the next picks."""
        context = self.context
        motion, grip_results = self._motion(context, plans)
        if self.plant.record_row is not None:
            self.upstream = self.source.waiting(self.plant.record_row)
        passed, collisions = self.source.passed.copy(), self.source.find_collisions(context, motion, grip_results)
        self.source.knock(collisions)
        # Without a belt, the present pick's draws say where the next object waits.
        limits = self.config.robot.limits(context.objects.percent)
        following = self.source.following(motion, limits, context.objects.draws.place[:, 1:3])
        planned_results = PlannedResults(following.wait, passed, motion.placed, np.asarray(collisions.any(axis=1)))
        outcome = self._simulate(context, plans, motion, following.back, grip_results, planned_results)
        picks = self._drift.after(context, plans, outcome, following.context)
        self.context = picks.replace(depth=self._bins.after(context.objects, outcome.ended_in, picks.depth))
        return outcome

    @contextmanager
    def hold_back(self, rows: Bools) -> Generator[None]:
        """Context in which some rows (N,) throw nothing, and at whose end their belts and bins are as before.

        The outcomes of these rows mean nothing.
        """
        with self.source.hold_back(rows), self._bins.hold_back(rows), self._drift.hold_back(rows):
            self._thrown = np.flatnonzero(~rows)
            try:
                yield
            finally:
                self._thrown = np.arange(self.count)

    def ride(self, rows: Ints, time: float) -> None:
        """Move the belts of some rows on for a time [s], in which the hands try to grasp again."""
        self.source.ride(rows, time)

    def preview(self, plans: ReleaseBatch, jitter: bool = False) -> Outcome:
        """Simulated outcome of the coming throws, with a return to the same pick; `jitter` is of the release time."""
        context = self.context if jitter else self.context.without_jitter()
        motion, grip_results = self._motion(context, plans)
        back = self.planner.mover.back(motion, context.pick, self.config.robot.limits(context.objects.percent))
        wait, disturbed = (
            np.zeros(self.count),
            np.asarray(self.source.find_collisions(context, motion, grip_results).any(axis=1)),
        )
        planned_results = PlannedResults(wait, self.source.passed.copy(), motion.placed, disturbed)
        return self._simulate(context, plans, motion, back, grip_results, planned_results)

    def reward(self, outcome: Outcome) -> dict[str, Floats]:
        """Weighted reward terms by name, each (N,); before weighting every term lies in [0, 1]."""
        return outcome.rewards(self.config.reward)

    def info(self, outcome: Outcome, throws: Context) -> dict[str, NDArray[Any]]:
        """Info of throws beyond `COMMON_INFO`, (N,) each."""
        return {
            **dict(zip(RESULTS, attrgetter(*RESULTS)(outcome), strict=True)),
            "slip": slip(throws, self.config),
            "true_kind": throws.objects.kind.copy(),
            "bin": throws.bin.copy(),
            "bin_depth": throws.bin_depth.copy(),
            "target_x": throws.target[:, 0].copy(),
            "target_y": throws.target[:, 1].copy(),
            **self._drift.feedback(self.context.before),
        }

    def correction(self, mode: str) -> Correction | None:
        """How an action moves the landing along and across the throw; None where not one to one."""
        return correction(self.config, mode, self._drift.info_errors)

    def view(self) -> ThrowView:
        """Pictures of the cells; row 0 is recorded from now on."""
        return ThrowView(self, camera(), around=furniture(self.config, self.plant.scene.robot.mount))

    def pose(self, row: int) -> tuple[MjModel, MjData]:
        """Model and data of one simulation before the coming throw."""
        self.plant.write(self.context)
        return self.plant.current_state(row)

    def target(self, row: int) -> Floats:
        """Target point of the coming throw (3,) [m]."""
        return self.context.target[row]

    def markers(self, row: int) -> list[Marker]:
        """Markers of the objects on the belt, which the physics does not simulate before they are picked."""
        return objects_on_belt(self.source.waiting(row), self.config.belt, 0.0)

    def markers_at(self, time: float) -> list[Marker]:
        """Markers of the objects on the belt, a time [s] after the recorded throw began."""
        return objects_on_belt(self.upstream, self.config.belt, time)

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in vars(self).items() if name not in ("table", "hidden")}  # which are code

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self.table, self.hidden = self._drift.table, self._drift.hidden

    def _motion(self, context: Context, plans: ReleaseBatch) -> tuple[ThrowMotion, Grips]:
        """Motions and grips of throws; a hand whose pick failed stays at the pick, or stops at once if it rides."""
        motion = self.planner.mover.throw(context.pick, plans, context.throw_limits, context.ceiling)
        sealed, belt = picked(context, self.config), self.config.belt
        empty = partial(empty_motion, belt=belt, columns=motion.segments.durations.shape[1])
        motion = recompute_rows(motion, ~sealed, empty, context.pick, context.throw_limits)
        return motion, grips(context, sealed, motion.path, motion.release_time, self.config)

    def _simulate(
        self,
        context: Context,
        plans: ReleaseBatch,
        motion: ThrowMotion,
        back: Segments,
        grip_results: Grips,
        planned_results: PlannedResults,
    ) -> Outcome:
        """Simulate throws and returns, and judge them; only rows that are not held back are simulated."""
        rows, count = self._thrown, len(context.pick)
        throws = context, plans, motion, back, grip_results, planned_results
        context, plans, motion, back, grip_results, planned_results = take_rows(throws, rows, count)
        begin = motion.pick_velocity
        path = JerkTrajectory.concatenate(motion.pick, [motion.segments, back], begin, rides=begin is not None)
        simulated = self.plant.fly(context, HandCycle(plans, motion.release_time, path, grip_results), rows)
        cycle = path.duration + self.dwell + context.spent
        outcome = judge(simulated, context, self.config, self.planner.accepts, cycle, planned_results)
        return take_rows(outcome, stand_ins(rows, count), len(rows))
