"""A hand that rides with the belt while the vacuum builds up, around any mover that plans throws and returns.

The inner mover plans from rest to rest. Its throws begin at a virtual pick downstream of the true pick, and its returns
end at a virtual touch upstream of the true touch, both under the limits that remain beside the belt's fading velocity.
The fading is then added to the motions (`planning.motion.riding`). Releases, corrections and the motion after a release
are those of the inner mover.

A pick is the point where the hand lifts the object, as everywhere in the cell: `dwell` x speed downstream of the point
where the hand touches the object.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.base.sorting import Belt
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.movers.straight import Meeting, Mover, ThrowMotion
from pnt_gym.planning.motion.kernel import fade, grow, margins, superpose
from pnt_gym.planning.motion.limits import EllipticWorkspace, LimitRows, Space
from pnt_gym.planning.motion.riding import DOWNSTREAM, arrival_time
from pnt_gym.planning.motion.rows import Fading, Segments
from pnt_gym.planning.straight.plan import ReleaseBatch, TargetChoice

STOPPING: Final = ("straight",)
"""Planners whose returns stop above the pick, at the clearance."""


@final
class TrackingMover(Mover):
    """Throws of another mover from a moving belt, and returns onto it.

    Args:
        config: the cell.
        workspace: the positions that the hand can reach.
        mover: function that builds the inner mover from config and workspace.
    """

    def __init__(
        self,
        config: ConveyorConfig,
        workspace: EllipticWorkspace,
        mover: Callable[[ConveyorConfig, EllipticWorkspace], Mover],
    ) -> None:
        self._speed = config.belt.speed
        self._space = Space.of(workspace)
        percent = np.array(config.limits.percent)
        drop = config.motion.clearance if config.planner in STOPPING else 0.0
        self._arrival = arrival_time(config.robot.limits(percent), self._speed, drop)
        self._behind = self._speed * (self._arrival / 2.0 + config.motion.dwell) * DOWNSTREAM
        """Picks relative to the virtual touches (3,) [m]."""
        self._early = self._speed * self._arrival / 2.0 * DOWNSTREAM
        """Touches relative to the end points of motions from rest to rest (3,) [m]."""
        low, high = config.lift_x
        window = low - self._behind[0], high - self._behind[0]
        self._mover = mover(
            config.model_copy(update={"belt": config.belt.model_copy(update={"pick_x": window})}), workspace
        )

    def reserve(self, release: ReleaseBatch) -> Floats:
        """The inner mover's reserves (N,) [m]."""
        return self._mover.reserve(release)

    def plan(self, pick: Floats, target: Floats, limits: LimitRows, ceiling: Floats) -> ReleaseBatch:
        """The inner mover's releases from the virtual picks."""
        fading = fade(limits, self._speed, 0.0)
        return self._mover.plan(pick + fading.lead, target, fading.left, ceiling)

    def aim_at(self, context: Context, goal: Floats, slack: float) -> ReleaseBatch:
        """The inner mover's releases for moved targets (N, 3) [m]."""
        return self._mover.aim_at(self._virtual_context(context), goal, slack)

    def release_at(self, context: Context, point: Floats) -> ReleaseBatch:
        """The inner mover's releases at given points (N, 3) [m]."""
        return self._mover.release_at(self._virtual_context(context), point)

    def is_feasible(self, pick: Floats, release: ReleaseBatch, limits: LimitRows) -> Bools:
        """Which releases the robot can execute.

        While the belt's velocity fades, the hand stays inside the triangle of pick, virtual pick and the position
        at the end of the fading.
        """
        fading = fade(limits, self._speed, 0.0)
        good = self._mover.is_feasible(pick + fading.lead, release, fading.left)
        return good & fading.is_possible & (margins(pick, self._space) >= 0.0)

    def accepts(self, context: Context, shift: Floats | None) -> Bools:
        """Which nominal plans the robot can execute, also for moved targets."""
        good = self._mover.accepts(self._virtual_context(context), shift)
        is_possible = fade(context.throw_limits, self._speed, 0.0).is_possible
        return good & is_possible & (margins(context.pick, self._space) >= 0.0)

    def choose_targets(
        self, pick: Floats, targets: Floats, limits: LimitRows, ceiling: Floats, origin: Floats, may_throw: Bools
    ) -> TargetChoice | None:
        """The inner mover's choice, of throws from the virtual picks."""
        fading = fade(limits, self._speed, 0.0)
        may_ride = may_throw & fading.is_possible & (margins(pick, self._space) >= 0.0)
        return self._mover.choose_targets(pick + fading.lead, targets, fading.left, ceiling, origin, may_ride)

    def throw(self, pick: Floats, release: ReleaseBatch, limits: LimitRows, ceiling: Floats) -> ThrowMotion:
        """The inner mover's motions plus the fading belt speed; a short motion is delayed until the speed has faded."""
        fading = fade(limits, self._speed, 0.0)
        motion = self._mover.throw(pick + fading.lead, release, fading.left, ceiling)
        delay = np.maximum(fading.time - motion.release_time, 0.0)
        return motion.replace(
            pick=pick,
            segments=superpose(motion.segments.delay(delay), grow(fading.time, -self._speed, 2)),
            release_time=motion.release_time + delay,
            stop_time=motion.stop_time + delay,
            pick_velocity=np.zeros((len(pick), 3)) + self._speed * DOWNSTREAM,
        )

    def back(self, motion: ThrowMotion, next_pick: Floats, limits: LimitRows) -> Segments:
        """Motions to the touches of the objects that the hand lifts at next picks (N, 3) [m]."""
        growing = fade(limits, self._speed, self._arrival)
        return self._end_riding(self._mover.back(motion, next_pick - self._behind, growing.left), growing)

    def reach(self, motion: ThrowMotion, place: Floats, limits: LimitRows) -> Meeting:
        """The earliest meetings; a return is at least as long as the growth of the belt's speed."""
        growing = fade(limits, self._speed, self._arrival)
        meeting = self._mover.reach(motion, place - self._early, growing.left)
        time = meeting.time if meeting.back is None else meeting.back.durations.sum(axis=1)
        position, feasible = meeting.position + self._behind, meeting.feasible & (time >= growing.time)
        return meeting.replace(position=position, feasible=feasible)

    def approach(self, motion: ThrowMotion, meeting: Meeting, limits: LimitRows) -> Segments:
        """The inner mover's motions, onto the moving belt."""
        growing = fade(limits, self._speed, self._arrival)
        return self._end_riding(self._mover.approach(motion, meeting, growing.left), growing)

    def _virtual_context(self, context: Context) -> Context:
        """Picks as the inner mover needs them: at virtual points and with the remaining limits."""
        fading = fade(context.throw_limits, self._speed, 0.0)
        return context.replace(pick=context.pick + fading.lead, throw_limits=fading.left)

    def _end_riding(self, back: Segments, growing: Fading) -> Segments:
        """Returns that end at the belt's speed: the growing speed is added at their ends."""
        growth = grow(growing.time, self._speed, 3)
        growth.durations[:, 0] = np.maximum(back.durations.sum(axis=1) - growing.time, 0.0)
        return superpose(back, growth)


def stop_motion(pick: Floats, limits: LimitRows, speed: float) -> ThrowMotion:
    """Motions of empty hands that ride at picks (N, 3) [m] with a belt speed [m/s], and stop downstream."""
    fading = fade(limits, speed, 0.0)
    return ThrowMotion.resting(pick + fading.lead).replace(
        pick=pick,
        segments=grow(fading.time, -speed, 2),
        stop_time=fading.time,
        pick_velocity=np.tile(speed * DOWNSTREAM, (len(pick), 1)),
    )


def empty_motion(pick: Floats, limits: LimitRows, belt: Belt, columns: int) -> ThrowMotion:
    """Motions of empty hands at picks (N, 3) [m]: at rest, or a stop if they ride; padded to `columns` segments."""
    resting = stop_motion(pick, limits, belt.speed) if belt.tracking else ThrowMotion.resting(pick)
    return resting.replace(segments=resting.segments.pad(columns))
