"""The conveyor cell: N robots at N belts, throwing in step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, ClassVar, Final, Literal, Self, final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Floats, Ints, made_anew, replaced
from pnt_gym.cells.base.action import Correction
from pnt_gym.cells.base.canvas import Marker
from pnt_gym.cells.base.cell import Cell, Generators
from pnt_gym.cells.base.features import FeatureTable, Quantity
from pnt_gym.cells.base.plant import REWARD_TERMS
from pnt_gym.cells.base.view import ThrowView
from pnt_gym.cells.conveyor.action import MODES, correction, modes_of
from pnt_gym.cells.conveyor.belt.sources import BeltPicks, IndependentPicks, PickSource
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.cup.hold import Grips, grips, slip
from pnt_gym.cells.conveyor.cup.seal import picked
from pnt_gym.cells.conveyor.hand import HandCycle
from pnt_gym.cells.conveyor.movers.straight import ThrowMotion
from pnt_gym.cells.conveyor.movers.tracking import brought_to_rest
from pnt_gym.cells.conveyor.objects.fill import Fill, volume_of
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.cells.conveyor.observation import DRIFT, HIDDEN, SHIFT_TABLE, TABLE
from pnt_gym.cells.conveyor.outcome import Outcome, Told, judge
from pnt_gym.cells.conveyor.planner import PickPlanner
from pnt_gym.cells.conveyor.plant import ConveyorPlant
from pnt_gym.cells.conveyor.shift import Shift, drifted, known
from pnt_gym.cells.conveyor.view import camera, objects_on_belt
from pnt_gym.engine import MjData, MjModel
from pnt_gym.errors import ConfigError
from pnt_gym.planning.motion.limits import LimitRows
from pnt_gym.planning.motion.trajectory import JerkTrajectory, Segments
from pnt_gym.planning.straight.plan import ReleaseBatch

Picks = Literal["belt", "independent"]
SEEN: Final = ("seen_along", "seen_across")
"""Landing errors as a camera over the bins tells them."""
FEWEST_PICKS: Final = 2
"""In a shift from whose throws something can be learned."""
MOST_PICKS: Final = 100_000
"""In a shift that is drawn whole when it begins."""


@final
class ConveyorCell(Cell[ConveyorConfig, Context, ReleaseBatch, Outcome]):
    """N cells in step: `context` holds the coming picks, `throw` carries them out and brings the next.

    Args:
        config: the cell.
        count: number of cells N.
        picks: "belt" for a stream of objects on the moving belt, "independent" for unrelated picks.
        threads: worker threads of the physics; results do not depend on it.
        feedback: whether a camera over the bins tells of each throw for those that follow, on the belt.

    Raises:
        ConfigError: a level that drifts without that camera, or a shift of one pick with it.
    """

    modes = MODES
    reward_terms: ClassVar[tuple[str, ...]] = REWARD_TERMS
    table: FeatureTable = TABLE
    hidden: Sequence[Quantity] = HIDDEN

    def __init__(
        self, config: ConveyorConfig, count: int, picks: Picks, threads: int = 1, feedback: bool = False
    ) -> None:
        super().__init__(config, count, threads)
        self._shift: Shift | None = None
        """How each cell drifts; None where nobody could tell."""
        if feedback:
            self._begin_shifts()
        elif config.drift.moves:
            raise ConfigError(
                f"level {config.name!r} drifts, and nothing in this environment tells of it; use PnTAdapt-v0, or set "
                "the parts of its section `drift` to 0"
            )
        self.terminates = picks == "independent"
        self.episode = 1 if self.terminates else config.picks_per_shift
        self.modes = modes_of(config)
        self.item_names = config.items
        self.target_names = tuple(fixed.name for fixed in config.bins.fixed)
        self.dwell = config.motion.dwell
        self.planner = PickPlanner(config)
        if not config.ships():
            self.planner.warn_of_reach()
        self.plant = ConveyorPlant(config, count, threads)
        source = IndependentPicks if self.terminates else BeltPicks
        self._source: PickSource = source(self.planner, self.generators)
        self._fill = self._empty(count)
        self.context = self.first(np.arange(count))
        self.upstream: tuple[Objects, Floats] | None = None
        """What was on the belt when the recorded throw began; for pictures."""

    def first(self, rows: Ints) -> Context:
        """First picks of an episode for some rows; where bins are carried along, they are empty."""
        picks = self._source.first(rows)
        if self._shift is not None:
            shift = Shift.drawn([self.generators[row] for row in rows], self.config)
            self._shift = replaced(self._shift, rows, shift)
            picks = self._drifting(picks, shift)
        if not self._carries:
            return picks
        self._fill = replaced(self._fill, rows, self._empty(len(rows)))
        return replace(picks, depth=self._empty(len(rows)).depth(self.planner.areas, self.config))

    def target_of(self, throws: Context) -> Ints:
        """Which fixed bin throws are for (N,)."""
        return throws.bin

    def scout(self, generators: Generators) -> Self:
        """This cell with other rows, to see which first picks they draw from an empty belt of their own."""
        scout = super().scout(generators)
        scout._source = type(self._source)(self.planner, generators)
        scout._fill = self._empty(len(generators))
        if self._shift is not None:
            scout._shift = Shift.drawn(generators, self.config)
        return scout

    def throw(self, plans: ReleaseBatch) -> Outcome:
        """Throw in every cell and move on to the next picks."""
        context = self.context
        motion = self._motion(context, plans)
        if self.plant.record_row is not None:
            self.upstream = self._source.waiting(self.plant.record_row)
        held = grips(context, motion.path, motion.release_time, self.config)
        passed, met = self._source.passed.copy(), self._source.swept(context, motion, held)
        if self.config.belt.neighbours == "solid":
            self._source.knock(met)
        # Where the hand returns to without a belt belongs to the present pick's draw.
        following = self._source.following(motion, context.limits, context.objects.place[:, 1:3])
        told = Told(following.wait, passed, motion.placed, np.asarray(met.any(axis=1)))
        outcome = self._flown(context, _cycle(plans, motion, following.back, held), told)
        self.context = self._told(outcome, plans, self._after(outcome, following.context))
        return outcome

    def preview(self, plans: ReleaseBatch, jitter: bool = False) -> Outcome:
        """What the coming throws would do; the hand returns to its own pick, `jitter` is that of the release time."""
        context = self.context if jitter else self.context.expected()
        motion = self._motion(context, plans)
        held = grips(context, motion.path, motion.release_time, self.config)
        back = self.planner.mover.back(motion, context.pick, context.limits)
        wait, met = np.zeros(self.count), np.asarray(self._source.swept(context, motion, held).any(axis=1))
        told = Told(wait, self._source.passed.copy(), motion.placed, met)
        return self._flown(context, _cycle(plans, motion, back, held), told)

    def reward(self, outcome: Outcome) -> dict[str, Floats]:
        """Weighted reward terms by name, each (N,); before weighting every term lies in [0, 1]."""
        return outcome.rewards(self.config.reward)

    def info(self, outcome: Outcome, thrown: Context) -> dict[str, NDArray[Any]]:
        """What the belt cell tells of throws, (N,) each."""
        return {
            "landing_along": outcome.landing_along,
            "landing_across": outcome.landing_across,
            "wait_time": outcome.wait_time,
            "in_opening": outcome.in_opening,
            "in_bin": outcome.in_bin,
            "rim": outcome.rim,
            "recontact": outcome.recontact,
            "picked": outcome.picked,
            "dropped": outcome.dropped,
            "disturbed": outcome.disturbed,
            "grip_margin": outcome.grip_margin,
            "passed": outcome.passed,
            "placed": outcome.placed,
            "slip": slip(thrown, self.config),
            "peak_torque": outcome.peak_torque,
            "energy": outcome.energy,
            "true_kind": thrown.objects.kind.copy(),
            "bin": thrown.bin.copy(),
            "ended_in": outcome.ended_in,
            "belongs": outcome.belongs,
            "sorted": outcome.sorted,
            "bin_depth": thrown.bin_depth.copy(),
            "target_x": thrown.target[:, 0].copy(),
            "target_y": thrown.target[:, 1].copy(),
            **self._feedback(),
        }

    def correction(self, mode: str) -> Correction | None:
        """How an action shifts the landing along and across the throw; None where it has no such meaning."""
        return correction(self.config, mode, SEEN if self._shift is not None else ())

    def view(self) -> ThrowView:
        """Pictures of the cells; row 0 is recorded from now on."""
        return ThrowView(self, camera())

    def pose(self, row: int) -> tuple[MjModel, MjData]:
        """Model and data of one simulation as it stands before the coming throw."""
        self.plant.write(self.context)
        return self.plant.stand(row)

    def target(self, row: int) -> Floats:
        """Where the coming throw should go (3,) [m]."""
        return self.context.target[row]

    def markers(self, row: int) -> list[Marker]:
        """The objects upstream, which the physics does not simulate before they are picked."""
        return objects_on_belt(self._source.waiting(row), self.config.belt, 0.0)

    def markers_at(self, time: float) -> list[Marker]:
        """The same, a time [s] after the recorded throw began."""
        return objects_on_belt(self.upstream, self.config.belt, time)

    def _begin_shifts(self) -> None:
        """A camera over the bins from now on."""
        if not FEWEST_PICKS <= self.config.picks_per_shift <= MOST_PICKS:
            raise ConfigError(
                f"picks_per_shift is {self.config.picks_per_shift}; a shift in which a throw tells something for the "
                f"next has {FEWEST_PICKS} to {MOST_PICKS}"
            )
        self._shift = Shift.drawn(self.generators, self.config)
        self._tell()

    def _tell(self) -> None:
        """What is seen and hidden where shifts are drawn."""
        if self._shift is not None:
            self.table, self.hidden = SHIFT_TABLE, (*HIDDEN, *DRIFT)

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in vars(self).items() if name not in ("table", "hidden")}  # which are code

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self._tell()

    def _drifting(self, picks: Context, shift: Shift) -> Context:
        """Picks as they come in cells that are off by now."""
        return drifted(picks, shift.now(), self.config) if self.config.drift.moves else picks

    def _told(self, outcome: Outcome, plans: ReleaseBatch, picks: Context) -> Context:
        """The next picks, with what is known of the throws before, in cells that have drifted on."""
        if self._shift is None:
            return picks
        seen, error = self._shift.told(outcome, self.config)
        self._shift = self._shift.thrown()
        before = known(self.context, plans, seen, error, self._shift.at / self.config.picks_per_shift)
        return replace(self._drifting(picks, self._shift), before=before)

    def _feedback(self) -> dict[str, NDArray[Any]]:
        """What the camera over the bins tells of the throws just made, NaN where it saw nothing; if there is one."""
        if self._shift is None:
            return {}
        before = self.context.before
        told = np.where(before.seen[:, None], before.error, np.nan)
        return {**dict(zip(SEEN, told.T.copy(), strict=True)), "pick_in_shift": self._shift.at - 1}

    @property
    def _carries(self) -> bool:
        """Whether what ends in bins stays there for the throws that follow."""
        return self.config.bins.emptied is not None and bool(self.config.bins.fixed) and not self.terminates

    def _empty(self, count: int) -> Fill:
        return Fill.nothing(count, max(len(self.config.bins.fixed), 1))

    def _after(self, outcome: Outcome, picks: Context) -> Context:
        """The next picks, whose bins hold what the throws have brought."""
        emptied, objects = self.config.bins.emptied, self.context.objects
        if emptied is None or not self._carries:
            return picks
        self._fill = self._fill.after(outcome.ended_in, volume_of(objects.shape, objects.size), emptied)
        return replace(picks, depth=self._fill.depth(self.planner.areas, self.config))

    def _motion(self, context: Context, plans: ReleaseBatch) -> ThrowMotion:
        """The throws; hands that hold nothing stay where they are, or stop at once, to go on from there."""
        motion = self.planner.mover.throw(context.pick, plans, context.throw_limits, context.ceiling)
        columns = motion.segments.durations.shape[1]

        def left(pick: Floats, limits: LimitRows) -> ThrowMotion:
            belt = self.config.belt
            resting = brought_to_rest(pick, limits, belt.speed) if belt.tracking else ThrowMotion.resting(pick)
            return replace(resting, segments=resting.segments.padded(columns))

        return made_anew(motion, ~picked(context, self.config), left, context.pick, context.throw_limits)

    def _flown(self, context: Context, cycle: HandCycle, told: Told) -> Outcome:
        """The outcome of throws and returns."""
        return judge(self.plant.fly(context, cycle), context, self.config, cycle.path.duration + self.dwell, told)


def _cycle(release: ReleaseBatch, motion: ThrowMotion, back: Segments, held: Grips) -> HandCycle:
    """Throws and returns, one after the other."""
    begin = motion.pick_velocity
    path = JerkTrajectory.concatenate(motion.pick, [motion.segments, back], begin, rides=begin is not None)
    return HandCycle(release, motion.release_time, path, held)
