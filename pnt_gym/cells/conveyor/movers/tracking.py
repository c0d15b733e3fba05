"""A hand that rides with the belt while the vacuum builds up, whatever mover plans its throws and returns.

A mover plans from rest to rest. Here its throws begin at a virtual pick downstream of the true one, under what the
belt's fading velocity leaves of the limits, and its returns end at a virtual touch upstream of the true one; the fading
is added to both (`planning.motion.riding`). Releases, corrections and the motion after a release are the mover's own.

A pick is where the hand lifts the object, as everywhere in the cell: `dwell` x speed downstream of where it touches it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, joined
from pnt_gym.cells.base.sorting import Belt
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.movers.straight import Meeting, Mover, Reach, ThrowMotion
from pnt_gym.planning.motion.limits import EllipticWorkspace, LimitRows, Limits
from pnt_gym.planning.motion.riding import DOWNSTREAM, Fading, arrival_time
from pnt_gym.planning.motion.scurve import coast
from pnt_gym.planning.motion.trajectory import Segments, superposed
from pnt_gym.planning.straight.plan import ReleaseBatch

STOPPING: Final = ("straight",)
"""Planners whose returns stop above the pick, at the clearance, or pass there at rest."""


@final
class TrackingMover(Mover):
    """Throws of another mover from a moving belt, and returns onto it.

    Args:
        config: the cell.
        workspace: where the hand may be.
        mover: what makes the other mover of both.
    """

    def __init__(
        self,
        config: ConveyorConfig,
        workspace: EllipticWorkspace,
        mover: Callable[[ConveyorConfig, EllipticWorkspace], Mover],
    ) -> None:
        self._speed = config.belt.speed
        self._workspace = workspace
        percent = np.array(config.limits.percent)
        drop = config.motion.clearance if config.planner in STOPPING else 0.0
        self._arrival = arrival_time(LimitRows.t3kr(percent), self._speed, drop)
        self._behind = self._speed * (self._arrival / 2.0 + config.motion.dwell) * DOWNSTREAM
        """Picks from the virtual touches."""
        self._early = self._speed * self._arrival / 2.0 * DOWNSTREAM
        """Touches from where hands would have to be that go from rest to rest [m]."""
        low, high = config.lift_x
        window = low - self._behind[0], high - self._behind[0]
        self._mover = mover(
            config.model_copy(update={"belt": config.belt.model_copy(update={"pick_x": window})}), workspace
        )

    def reserve(self, release: ReleaseBatch) -> Floats:
        """The other mover's."""
        return self._mover.reserve(release)

    def plan(self, pick: Floats, target: Floats, limits: Limits, ceiling: Floats) -> ReleaseBatch:
        """The other mover's releases from the virtual picks."""
        fading = Fading.under(limits, len(pick), self._speed)
        return self._mover.plan(_virtual(pick, fading), target, fading.left(limits), ceiling)

    def aimed(self, context: Context, goal: Floats, slack: float) -> ReleaseBatch:
        """The other mover's releases for moved targets (N, 3) [m]."""
        return self._mover.aimed(self._seen(context), goal, slack)

    def moved(self, context: Context, point: Floats) -> ReleaseBatch:
        """The other mover's releases at given points (N, 3) [m]."""
        return self._mover.moved(self._seen(context), point)

    def is_feasible(self, pick: Floats, release: ReleaseBatch, limits: Limits) -> Bools:
        """Which releases the robot can execute.

        While the belt's velocity fades, the hand stays inside the triangle of pick, virtual pick and where it is then.
        """
        fading = Fading.under(limits, len(pick), self._speed)
        good = self._mover.is_feasible(_virtual(pick, fading), release, fading.left(limits))
        return good & fading.is_possible(limits) & self._workspace.contains(pick)

    def throw(self, pick: Floats, release: ReleaseBatch, limits: Limits, ceiling: Floats) -> ThrowMotion:
        """The other mover's motions, at the belt's speed at first; quick ones begin late enough for it to fade."""
        fading = Fading.under(limits, len(pick), self._speed)
        motion = self._mover.throw(_virtual(pick, fading), release, fading.left(limits), ceiling)
        delay = np.maximum(fading.time - motion.release_time, 0.0)
        return replace(
            motion,
            pick=pick,
            segments=superposed(joined([coast(delay), motion.segments], axis=1), fading.out()),
            release_time=motion.release_time + delay,
            stop_time=motion.stop_time + delay,
            pick_velocity=np.tile(self._speed * DOWNSTREAM, (len(pick), 1)),
        )

    def back(self, motion: ThrowMotion, next_pick: Floats, limits: Limits) -> Segments:
        """The motions to where the objects are touched that are lifted at next picks (N, 3) [m]."""
        growing = self._growing(len(next_pick))
        return _ending(self._mover.back(motion, next_pick - self._behind, growing.left(limits)), growing)

    def meet(self, motion: ThrowMotion, place: Floats, limits: Limits) -> Meeting:
        """The earliest meetings, of which the positions are those of the lifts."""
        growing = self._growing(len(place))
        found = self._mover.meet(motion, place - self._early, growing.left(limits))
        good = found.feasible & (found.back.durations.sum(axis=1) >= growing.time)
        return replace(found, position=found.position + self._behind, back=_ending(found.back, growing), feasible=good)

    def reach(self, motion: ThrowMotion, place: Floats, limits: Limits) -> Reach:
        """The same without the motions, none of which is shorter than the growing."""
        growing = self._growing(len(place))
        found = self._mover.reach(motion, place - self._early, growing.left(limits))
        good = found.feasible & (found.time >= growing.time)
        return replace(found, position=found.position + self._behind, feasible=good)

    def _growing(self, count: int) -> Fading:
        return Fading(self._speed, np.full(count, self._arrival))

    def _seen(self, context: Context) -> Context:
        """Picks as the other mover sees them."""
        fading = Fading.under(context.throw_limits, len(context.pick), self._speed)
        return replace(context, pick=_virtual(context.pick, fading), throw_limits=fading.left(context.throw_limits))


def brought_to_rest(pick: Floats, limits: Limits, speed: float) -> ThrowMotion:
    """Hands that lift nothing from a belt of a speed [m/s] at picks (N, 3) [m], and come to rest downstream."""
    fading = Fading.under(limits, len(pick), speed)
    return replace(
        ThrowMotion.resting(_virtual(pick, fading)),
        pick=pick,
        segments=fading.out(),
        stop_time=fading.time,
        pick_velocity=np.tile(speed * DOWNSTREAM, (len(pick), 1)),
    )


def left_empty(pick: Floats, limits: Limits, belt: Belt, columns: int) -> ThrowMotion:
    """Hands that lift nothing at picks (N, 3) [m] and stay there, or stop at once if they ride; so many segments."""
    resting = brought_to_rest(pick, limits, belt.speed) if belt.tracking else ThrowMotion.resting(pick)
    return replace(resting, segments=resting.segments.padded(columns))


def _virtual(pick: Floats, fading: Fading) -> Floats:
    """Where throws would begin that begin at rest (N, 3) [m]."""
    return pick + fading.way[:, None] * DOWNSTREAM


def _ending(back: Segments, growing: Fading) -> Segments:
    """Returns that end at the belt's speed; none is shorter than the growing, for it goes down to the belt."""
    return superposed(back, growing.into(np.maximum(back.durations.sum(axis=1) - growing.time, 0.0)))
