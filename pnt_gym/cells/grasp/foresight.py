"""What tries and throws of the coming objects would give, by all hidden values: for oracles and figures alone."""

from __future__ import annotations

from typing import final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, Ints, put_rows, take, take_rows
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.cup.hold import picked
from pnt_gym.cells.conveyor.outcome import Outcome
from pnt_gym.cells.grasp.attempts import tries_left
from pnt_gym.cells.grasp.core import GraspCore
from pnt_gym.cells.grasp.observation import GraspSight, encode


@final
class Foresight:
    """Simulates tries and throws before the tries and throws, without advancing the cells.

    A foreseen try is the try itself, its luck included. A foreseen throw lacks what differs from throw to throw of one
    object: the jitter of the release.

    Args:
        core: the cells, each with one object within reach.
    """

    def __init__(self, core: GraspCore) -> None:
        self._core = core

    def grasp(self, rows: Ints, place: Floats) -> tuple[Context, Bools, NDArray[np.float32]]:
        """What the next tries of some rows would give.

        Args:
            rows: rows whose cups are free, ascending (K,).
            place: places of the cups from the pictures' middles (K, 2) [m].

        Returns:
            The picks with the cups at the places (K,), whether the objects hang (K,), and the vectors that would be
            observed of them (K, D).
        """
        core = self._core
        before = take(core.attempts, rows)
        picks = take(core.picks_when_tried(rows), rows)
        grasped, at, leak = core.grasper.grasp(picks, place, before.tries)
        holds = picked(grasped, core.config)
        after = before.then(holds, at, at, grasped.objects.measured.seal, leak)
        left = tries_left(core.config, after.tries, picks)
        return grasped, holds, encode(GraspSight(grasped, after, left))

    def throw(self, rows: Ints, grasped: Context, pace: Floats, residual: Floats) -> Outcome:
        """Outcomes of throws of some rows (K,).

        Args:
            rows: rows, ascending (K,).
            grasped: picks whose objects hang under the cups (K,).
            pace: largest accelerations of the throws, as shares of the robot's (K,).
            residual: corrections of the releases, as the last two numbers of an action (K, 2).
        """
        core, kept = self._core, self._core.cell.context
        count, others = core.count, np.ones(core.count, dtype=np.bool_)
        others[rows] = False
        throws, _ = core.grasper.with_pace(grasped, pace)
        corrections = np.zeros((count, residual.shape[1]))
        corrections[rows] = residual
        core.cell.context = put_rows(kept, rows, throws, count)
        try:
            with core.cell.hold_back(others):
                outcome = core.throws.preview(corrections)
        finally:
            core.cell.context = kept
        return take_rows(outcome, rows, count)
