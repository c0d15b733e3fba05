"""The mover that throws some objects and puts others down."""

from __future__ import annotations

from functools import partial
from typing import Final, final

from pnt_gym.arrays import Bools, Floats, recompute_rows
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.movers.placing import EllipseMover, is_at_rest
from pnt_gym.cells.conveyor.movers.straight import Meeting, Mover, StraightMover, ThrowMotion
from pnt_gym.planning.motion.limits import EllipticWorkspace, LimitRows
from pnt_gym.planning.motion.rows import Segments
from pnt_gym.planning.paths.arcs import PIECES
from pnt_gym.planning.straight.plan import ReleaseBatch

COLUMNS: Final = PIECES + 16
"""Segments of a wait, straight parts and an ellipse; straight throws and returns have fewer."""


@final
class AutoMover(Mover):
    """Throws objects straight, or puts them down over an ellipse; a release at rest means putting down.

    `plan` plans throws. A caller that decides to put an object down plans with an `EllipseMover`.
    """

    def __init__(self, config: ConveyorConfig, workspace: EllipticWorkspace) -> None:
        self._throw_mover = StraightMover(config, workspace)
        self._put_mover = EllipseMover(config, workspace)

    def plan(self, pick: Floats, target: Floats, limits: LimitRows, ceiling: Floats) -> ReleaseBatch:
        """Releases of straight throws."""
        return self._throw_mover.plan(pick, target, limits, ceiling)

    def aim_at(self, context: Context, goal: Floats, slack: float) -> ReleaseBatch:
        """Releases for moved targets, thrown or put down like the nominal plan."""
        releases = self._throw_mover.aim_at(context, goal, slack)
        return recompute_rows(
            releases, is_at_rest(context.plan), partial(self._put_mover.aim_at, slack=slack), context, goal
        )

    def release_at(self, context: Context, point: Floats) -> ReleaseBatch:
        """Releases at given points, thrown or put down like the nominal plan."""
        releases = self._throw_mover.release_at(context, point)
        return recompute_rows(releases, is_at_rest(context.plan), self._put_mover.release_at, context, point)

    def reserve(self, release: ReleaseBatch) -> Floats:
        """Reserves (N,) [m] of throws and of releases at rest."""
        return recompute_rows(self._throw_mover.reserve(release), is_at_rest(release), self._put_mover.reserve, release)

    def is_feasible(self, pick: Floats, release: ReleaseBatch, limits: LimitRows) -> Bools:
        """Which throws and releases at rest the robot can execute (N,)."""
        good = self._throw_mover.is_feasible(pick, release, limits)
        return recompute_rows(good, is_at_rest(release), self._put_mover.is_feasible, pick, release, limits)

    def throw(self, pick: Floats, release: ReleaseBatch, limits: LimitRows, ceiling: Floats) -> ThrowMotion:
        """Motions of throws and of releases at rest."""

        def put_down(*arguments: object) -> ThrowMotion:
            return _pad(self._put_mover.throw(*arguments))  # pyright: ignore[reportArgumentType] - rows of what stands below

        motions = _pad(self._throw_mover.throw(pick, release, limits, ceiling))
        return recompute_rows(motions, is_at_rest(release), put_down, pick, release, limits, ceiling)

    def back(self, motion: ThrowMotion, next_pick: Floats, limits: LimitRows) -> Segments:
        """Motions to next picks: over the rims after a release at rest, straight after a throw."""

        def over(motion: ThrowMotion, next_pick: Floats, limits: LimitRows) -> Segments:
            return self._put_mover.back(motion, next_pick, limits).pad(COLUMNS)

        straight = self._throw_mover.back(motion, next_pick, limits).pad(COLUMNS)
        return recompute_rows(straight, motion.placed, over, motion, next_pick, limits)

    def reach(self, motion: ThrowMotion, place: Floats, limits: LimitRows) -> Meeting:
        """The earliest meetings, with motions as `back`."""

        def over(motion: ThrowMotion, place: Floats, limits: LimitRows) -> Meeting:
            return _meet_padded(self._put_mover, motion, place, limits)

        straight = _meet_padded(self._throw_mover, motion, place, limits)
        return recompute_rows(straight, motion.placed, over, motion, place, limits)


def _pad(motion: ThrowMotion) -> ThrowMotion:
    return motion.replace(segments=motion.segments.pad(COLUMNS))


def _meet_padded(mover: Mover, motion: ThrowMotion, place: Floats, limits: LimitRows) -> Meeting:
    meeting, back = mover.meet(motion, place, limits)
    return meeting.replace(back=back.pad(COLUMNS))
