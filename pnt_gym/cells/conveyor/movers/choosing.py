"""The mover that throws some objects and puts others down."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Final, final

from pnt_gym.arrays import Bools, Floats, made_anew
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.movers.placing import EllipseMover, placed
from pnt_gym.cells.conveyor.movers.straight import Meeting, Mover, StraightMover, ThrowMotion
from pnt_gym.planning.motion.limits import EllipticWorkspace, Limits
from pnt_gym.planning.motion.trajectory import Segments
from pnt_gym.planning.paths.arcs import PIECES
from pnt_gym.planning.straight.plan import ReleaseBatch

COLUMNS: Final = PIECES + 16
"""Segments of a wait, straight parts and an ellipse; straight throws and returns have fewer."""


@final
class AutoMover(Mover):
    """Throws objects straight, or puts them down over an ellipse; a release at rest means putting down.

    `plan` plans throws. A caller that decides to put an object down plans with an `EllipseMover`.

    Args:
        config: the cell.
        workspace: the positions that the hand can reach.
    """

    def __init__(self, config: ConveyorConfig, workspace: EllipticWorkspace) -> None:
        self._throws = StraightMover(config, workspace)
        self._puts = EllipseMover(config, workspace)

    def plan(self, pick: Floats, target: Floats, limits: Limits, ceiling: Floats) -> ReleaseBatch:
        """Releases of straight throws."""
        return self._throws.plan(pick, target, limits, ceiling)

    def aimed(self, context: Context, goal: Floats, slack: float) -> ReleaseBatch:
        """Releases for moved targets, thrown or put down like the nominal plan."""
        thrown = self._throws.aimed(context, goal, slack)
        return made_anew(thrown, placed(context.plan), partial(self._puts.aimed, slack=slack), context, goal)

    def moved(self, context: Context, point: Floats) -> ReleaseBatch:
        """Releases at given points, thrown or put down like the nominal plan."""
        thrown = self._throws.moved(context, point)
        return made_anew(thrown, placed(context.plan), self._puts.moved, context, point)

    def reserve(self, release: ReleaseBatch) -> Floats:
        """Reserves (N,) [m] of throws and of releases at rest."""
        return made_anew(self._throws.reserve(release), placed(release), self._puts.reserve, release)

    def is_feasible(self, pick: Floats, release: ReleaseBatch, limits: Limits) -> Bools:
        """Which throws and releases at rest the robot can execute (N,)."""
        good = self._throws.is_feasible(pick, release, limits)
        return made_anew(good, placed(release), self._puts.is_feasible, pick, release, limits)

    def throw(self, pick: Floats, release: ReleaseBatch, limits: Limits, ceiling: Floats) -> ThrowMotion:
        """Motions of throws and of releases at rest."""

        def put_down(*given: object) -> ThrowMotion:
            return _padded(self._puts.throw(*given))  # pyright: ignore[reportArgumentType] - rows of what stands below

        thrown = _padded(self._throws.throw(pick, release, limits, ceiling))
        return made_anew(thrown, placed(release), put_down, pick, release, limits, ceiling)

    def back(self, motion: ThrowMotion, next_pick: Floats, limits: Limits) -> Segments:
        """Motions to next picks: over the rims after a release at rest, straight after a throw."""

        def over(motion: ThrowMotion, next_pick: Floats, limits: Limits) -> Segments:
            return self._puts.back(motion, next_pick, limits).padded(COLUMNS)

        straight = self._throws.back(motion, next_pick, limits).padded(COLUMNS)
        return made_anew(straight, motion.placed, over, motion, next_pick, limits)

    def meet(self, motion: ThrowMotion, place: Floats, limits: Limits) -> Meeting:
        """The earliest meetings, with motions as `back`."""

        def over(motion: ThrowMotion, place: Floats, limits: Limits) -> Meeting:
            found = self._puts.meet(motion, place, limits)
            return replace(found, back=found.back.padded(COLUMNS))

        straight = self._throws.meet(motion, place, limits)
        straight = replace(straight, back=straight.back.padded(COLUMNS))
        return made_anew(straight, motion.placed, over, motion, place, limits)


def _padded(motion: ThrowMotion) -> ThrowMotion:
    return replace(motion, segments=motion.segments.padded(COLUMNS))
