"""How the hand moves through a pick: on a straight line, as in Hassan et al. 2022, or with a free release direction.

A mover plans the nominal release, the releases that corrections ask for, the motion to a release, and the motion from
there to the next pick. The cell, its plan check and the residuals know only this protocol; `planner` in the cell's
config chooses.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, final

import numpy as np

from pnt_gym.cells.context import Context
from pnt_gym.cells.motion import ThrowMotion, stays_inside, throw_motion
from pnt_gym.config import CellConfig
from pnt_gym.planning.arrays import Bools, Floats
from pnt_gym.planning.intercept import plan_intercept
from pnt_gym.planning.limits import MotionLimits
from pnt_gym.planning.plan import ReleaseBatch
from pnt_gym.planning.release import plan_release_batch, release_at_elevation, release_at_point
from pnt_gym.planning.segments import coast, rest_to_rest
from pnt_gym.planning.trajectory import Segments
from pnt_gym.planning.workspace import EllipticWorkspace

_LOWER_STEPS = 24
"""Elevations tried when a corrected release would rise above the ceiling and its slack."""
_HALVINGS = 12
"""Bisection of that elevation."""


@final
@dataclass(frozen=True)
class Return:
    """N motions from the end of a throw to rest at the next pick, as segments of constant jerk.

    Attributes:
        durations: (N, K) [s].
        jerks: (N, K, 3) [m/s3].
    """

    durations: Floats
    jerks: Floats

    @classmethod
    def joined(cls, parts: list[Segments]) -> Return:
        """The parts one after the other."""
        return cls(
            np.concatenate([part.durations for part in parts], axis=1),
            np.concatenate([part.jerks for part in parts], axis=1),
        )

    @property
    def segments(self) -> Segments:
        """The same, to be joined to the throw."""
        return Segments(self.durations, self.jerks)


@final
@dataclass(frozen=True)
class Meeting:
    """N meetings of hands and objects on the belt; rows that are not feasible hold placeholders.

    Attributes:
        position: where the hand picks (N, 3) [m].
        time: from the end of the throw to the pick (N,) [s].
        wait: standstill above the pick (N,) [s].
        back: the motion there.
        feasible: whether the object can be picked (N,).
    """

    position: Floats
    time: Floats
    wait: Floats
    back: Return
    feasible: Bools


class Mover(Protocol):
    """Plans the hand's motion for N picks at once; a row's result does not depend on the other rows."""

    def plan(self, pick: Floats, target: Floats, limits: MotionLimits, ceiling: Floats) -> ReleaseBatch:
        """Nominal releases for picks and targets (N, 3), below the ceilings (N,) [m]."""
        ...

    def aimed(self, context: Context, goal: Floats, slack: float) -> ReleaseBatch:
        """Releases for moved targets (N, 3) [m], as like the nominal ones as can be.

        `slack` is how far they may rise above the ceiling [m].
        """
        ...

    def moved(self, context: Context, point: Floats) -> ReleaseBatch:
        """Releases at given points (N, 3) [m]."""
        ...

    def is_feasible(self, pick: Floats, release: ReleaseBatch, limits: MotionLimits) -> Bools:
        """Which releases the robot can execute (N,)."""
        ...

    def throw(self, context: Context, release: ReleaseBatch) -> ThrowMotion:
        """The motions to feasible releases and on to where the return begins."""
        ...

    def back(self, motion: ThrowMotion, next_pick: Floats, limits: MotionLimits) -> Return:
        """The motions from there to next picks at rest (N, 3) [m]."""
        ...

    def meet(self, motion: ThrowMotion, place: Floats, limits: MotionLimits) -> Meeting:
        """The earliest meetings with objects on the belt.

        `place` (N, 3) [m] is where the hand would have to be to pick them when the throw ends.
        """
        ...


@final
class StraightMover:
    """Throws along the line from pick to release, stops on it, and returns on straight lines.

    Args:
        config: the cell.
        workspace: where the hand may be.
    """

    def __init__(self, config: CellConfig, workspace: EllipticWorkspace) -> None:
        self._motion = config.motion
        self._belt = config.belt
        self._workspace = workspace

    def plan(self, pick: Floats, target: Floats, limits: MotionLimits, ceiling: Floats) -> ReleaseBatch:
        """The exact optimum of Hassan et al. 2022."""
        return plan_release_batch(pick, target, limits, ceiling=ceiling)

    def aimed(self, context: Context, goal: Floats, slack: float) -> ReleaseBatch:
        """Releases at the nominal elevation, lower only where they would exceed ceiling and slack."""
        limits, top = context.limits, context.ceiling + slack
        angle = np.where(context.plan.feasible, context.plan.angle, 0.0)
        release = release_at_elevation(context.pick, goal, limits, angle)
        rows = np.flatnonzero(release.feasible & (release.position[:, 2] > top))
        if rows.size == 0:
            return release
        angle[rows] = _lowered(context.pick[rows], goal[rows], limits.take(rows), angle[rows], top[rows])
        return release_at_elevation(context.pick, goal, limits, angle)

    def moved(self, context: Context, point: Floats) -> ReleaseBatch:
        """Releases at the points, at the speed that the way there allows."""
        return release_at_point(context.pick, point, context.limits, plane_z=context.target[:, 2])

    def is_feasible(self, pick: Floats, release: ReleaseBatch, limits: MotionLimits) -> Bools:
        """Which throws exist and stay inside the workspace until the hand has stopped."""
        return stays_inside(pick, release, limits, self._motion.follow_through, self._workspace)

    def throw(self, context: Context, release: ReleaseBatch) -> ThrowMotion:
        """Acceleration, window, and the stop."""
        return throw_motion(context.pick, release, context.limits, self._motion.follow_through)

    def back(self, motion: ThrowMotion, next_pick: Floats, limits: MotionLimits) -> Return:
        """Straight above the next pick, then down."""
        return straight_back(motion.stop, next_pick, np.zeros(len(next_pick)), limits, self._motion.clearance)

    def meet(self, motion: ThrowMotion, place: Floats, limits: MotionLimits) -> Meeting:
        """The earliest meeting of a hand that moves from rest to rest."""
        found = plan_intercept(
            motion.stop,
            place,
            np.array([self._belt.speed, 0.0, 0.0]),
            limits,
            clearance=self._motion.clearance,
            window=self._belt.pick_x,
        )
        position = np.where(found.feasible[:, None], found.position, place)
        wait = np.where(found.feasible, found.wait, 0.0)
        time = np.where(found.feasible, found.time, 0.0)
        back = straight_back(motion.stop, position, wait, limits, self._motion.clearance)
        return Meeting(position, time, wait, back, found.feasible)


def straight_back(stop: Floats, next_pick: Floats, wait: Floats, limits: MotionLimits, clearance: float) -> Return:
    """From rest at `stop` straight above the next pick, a wait (N,) [s], and the vertical approach: 15 segments."""
    above = next_pick + np.array([0.0, 0.0, clearance])
    down = np.broadcast_to(np.array([0.0, 0.0, -clearance]), above.shape)
    return Return.joined([rest_to_rest(above - stop, limits), coast(wait), rest_to_rest(down, limits)])


def _lowered(pick: Floats, goal: Floats, limits: MotionLimits, angle: Floats, top: Floats) -> Floats:
    """The largest elevations (N,) below `angle` whose releases stay below `top`."""

    def fits(share: Floats) -> Bools:
        release = release_at_elevation(pick, goal, limits, angle * share)
        return release.feasible & (np.nan_to_num(release.position[:, 2], nan=np.inf) <= top)

    # A coarse walk down finds the first elevation that fits; bisection then refines its border.
    low, found = np.zeros(len(angle)), np.zeros(len(angle), dtype=np.bool_)
    for step in range(_LOWER_STEPS - 1, -1, -1):
        share = np.full(len(angle), step / _LOWER_STEPS)
        new = fits(share) & ~found
        low, found = np.where(new, share, low), found | new
    high = low + 1.0 / _LOWER_STEPS
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        good = fits(middle)
        low, high = np.where(good, middle, low), np.where(good, high, middle)
    return angle * low
