"""The conveyor cell: N robots at N belts, throwing in step."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal, final

import numpy as np

from pnt_gym.cells.context import Context
from pnt_gym.cells.motion import ThrowMotion
from pnt_gym.cells.movers import Return
from pnt_gym.cells.objects import Objects
from pnt_gym.cells.outcome import Outcome
from pnt_gym.cells.picks import PickPlanner
from pnt_gym.cells.plant import ConveyorPlant
from pnt_gym.cells.sources import BeltPicks, IndependentPicks, PickSource
from pnt_gym.config import CellConfig
from pnt_gym.planning.arrays import Bools, Floats, Ints
from pnt_gym.planning.plan import ReleaseBatch
from pnt_gym.planning.trajectory import JerkTrajectory
from pnt_gym.rows import put

Picks = Literal["belt", "independent"]


@final
class ConveyorCell:
    """N cells in step: `context` holds the coming picks, `throw` carries them out and brings the next.

    Args:
        config: the cell.
        count: number of cells N.
        picks: "belt" for a stream of objects on the moving belt, "independent" for unrelated picks.
        threads: worker threads of the physics; results do not depend on it.
    """

    def __init__(self, config: CellConfig, count: int, picks: Picks, threads: int = 1) -> None:
        self.config = config
        self.count = count
        self.planner = PickPlanner(config)
        self.plant = ConveyorPlant(config, count, threads)
        self._source: PickSource = (
            BeltPicks(self.planner, count) if picks == "belt" else IndependentPicks(self.planner, count)
        )
        generators = [np.random.default_rng(0) for _ in range(count)]
        self.context: Context = self._source.first(np.arange(count), generators)
        self.upstream: tuple[Objects, Floats] | None = None
        """What was on the belt when the recorded throw began; for pictures."""

    def reset(self, rows: Ints, generators: list[np.random.Generator]) -> None:
        """Begin new episodes in some rows, each with its own generator."""
        first = self._source.first(rows, generators)
        put(self.context, rows, first)
        # A copy drops the values derived from the rows that were overwritten.
        self.context = replace(self.context)

    def is_feasible(self, release: ReleaseBatch) -> Bools:
        """The plan check for releases at the coming picks (N,)."""
        return self.planner.is_feasible(self.context, release)

    def throw(self, release: ReleaseBatch, clipped: Bools) -> Outcome:
        """Throw in every cell and move on to the next picks.

        Args:
            release: feasible releases, one per cell.
            clipped: which of them are shortened residuals (N,), passed on to the outcome.
        """
        context, motion = self.context, self.planner.mover.throw(self.context, release)
        if self.plant.record_row is not None:
            self.upstream = self._source.waiting(self.plant.record_row)
        following = self._source.following(motion, context.limits)
        path = _joined(motion, following.back)
        outcome = self.plant.throw(context, release, motion.release_time, path)
        self.context = following.context
        dwell = self.config.motion.dwell
        return replace(outcome, cycle_time=path.duration + dwell, wait_time=following.wait, clipped=clipped)

    def preview(self, release: ReleaseBatch, jitter: bool = False) -> Outcome:
        """What the coming throws would do, without moving on; the hand returns to its own pick.

        Args:
            release: feasible releases, one per cell.
            jitter: whether the release time carries its random part.
        """
        motion = self.planner.mover.throw(self.context, release)
        path = _joined(motion, self.planner.mover.back(motion, self.context.pick, self.context.limits))
        return self.plant.throw(self.context, release, motion.release_time, path, jitter)

    def waiting(self, row: int) -> tuple[Objects, Floats] | None:
        """Objects upstream of one cell's present pick and their centres (K, 3) [m]; for pictures."""
        return self._source.waiting(row)


def _joined(motion: ThrowMotion, back: Return) -> JerkTrajectory:
    """The whole cycle: throw and return."""
    return JerkTrajectory.concatenate(motion.pick, [*motion.parts, back.segments])
