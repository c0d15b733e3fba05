"""Motion of hands and objects in every cycle of one line, recorded for pictures.

Hands move to their objects as planned. A simulated throw is stepped again. A throw that a table decides is drawn as
planned: the hand's motion, and a flight without air from the planned release to the bin. There the object lies if the
table counts a hit; after a miss the object disappears.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, NamedTuple, Self, final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.bodies import lying_size, yaw_attitude
from pnt_gym.cells.base.plant import Recording
from pnt_gym.cells.conveyor.config import LIP_GAP, ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.movers.straight import Mover, ThrowMotion
from pnt_gym.cells.conveyor.movers.tracking import stop_motion
from pnt_gym.constants import GRAVITY
from pnt_gym.planning.motion.ballistics import flight_state
from pnt_gym.planning.motion.trajectory import JerkTrajectory

SAMPLE_TIME: Final = 0.004
"""Time between two recorded poses of hands and objects; poses in between are interpolated [s]."""


MAX_CYCLES: Final = 400
"""Cycles that are kept at most, the latest ones; older objects disappear from pictures of a long shift."""


class Track(NamedTuple):
    """A path through space at K moments."""

    time: Floats
    """Time since the begin of the shift, not decreasing (K,) [s]."""
    pose: Floats
    """Pose at each time, column by column (K, C)."""

    def at(self, time: float) -> Floats:
        """Pose (C,) at a time [s], interpolated; the first pose before the track begins, the last one after its end."""
        after = min(int(np.searchsorted(self.time, time)), len(self.time) - 1)
        before = max(after - 1, 0)
        span = max(float(self.time[after] - self.time[before]), 1e-12)
        share = min(max((time - float(self.time[before])) / span, 0.0), 1.0)
        return self.pose[before] + share * (self.pose[after] - self.pose[before])

    def from_time(self, time: float) -> Self:
        """Track from the last moment before a time [s] on."""
        first = min(max(int(np.searchsorted(self.time, time, "right")) - 1, 0), len(self.time) - 1)
        return type(self)(self.time[first:], self.pose[first:])


@final
@dataclass(frozen=True)
class RobotCycle:
    """One cycle of a robot; x counts from the robot's base."""

    robot: int
    number: int
    """Index of the object in the stream."""
    start: float
    """Time of the decision, since the begin of the shift [s]."""
    lift: float
    """Time at which the object is lifted, or would have been [s]."""
    end: float
    """Time at which the robot is free again [s]."""
    hand: Track
    """Position of the cup's tip (K, 3) [m]."""
    off_belt: float
    """Time from which the belt no longer carries the object; infinity where the cup does not seal [s]."""
    object_track: Track | None
    """Middle of the object's extents and the object's attitude from the lift on (K, 7); None where the cup does not
    seal."""
    stays_visible: bool
    """Whether the object stays in the picture after its track ends; False where its place is unknown."""

    @classmethod
    def of(
        cls, decision: Decision, tip: Floats, cell: ConveyorConfig, mover: Mover, recording: Recording | None
    ) -> Self:
        """Tracks of hand and object for an executed decision.

        Args:
            decision: the executed decision.
            tip: tip of the cup relative to the planner's position of the hand, at the decision (3,) [m].
            cell: level of the robot's cell.
            mover: mover of the robot's planner.
            recording: recording of the simulated throw; None where the throw was not simulated.
        """
        context = decision.context
        limits = cell.robot.limits(context.objects.percent)
        # The hand moves to its object, and along with the object until the lift.
        _, back = mover.meet(ThrowMotion.resting(decision.hand), decision.place, limits)
        path = JerkTrajectory.concatenate(decision.hand, [back], rides=True)
        moments = _times(0.0, decision.lift - decision.start)
        share = np.minimum(moments / max(path.duration[0], SAMPLE_TIME), 1.0)[:, None]
        offset = tip + share * (context.cup_offset[0] - tip)
        approach = Track(decision.start + moments, path.sample(moments).position[0] + offset)
        if decision.picked and recording is not None:
            hand, object_track = _replay_tracks(decision, recording)
        else:
            # As planned: the throw, or the stop of a hand that carries nothing.
            if decision.picked:
                motion = mover.throw(context.pick, context.plan, context.throw_limits, context.ceiling)
            elif cell.belt.tracking:
                motion = stop_motion(context.pick, limits, cell.belt.speed)
            else:
                motion = ThrowMotion.resting(context.pick)
            path = JerkTrajectory.concatenate(motion.pick, [motion.segments], motion.pick_velocity)
            moments = _times(0.0, decision.end - decision.lift)
            hand = Track(decision.lift + moments, path.sample(moments).position[0] + context.cup_offset[0])
            object_track = _object_track(decision, path, float(motion.release_time[0])) if decision.picked else None
        time = np.concatenate([approach.time, hand.time])
        tip_track = Track(time, np.concatenate([approach.pose, hand.pose]))
        off_belt = decision.lift if cell.belt.tracking else decision.lift - cell.motion.dwell
        return cls(
            robot=decision.robot,
            number=decision.number,
            start=decision.start,
            lift=decision.lift,
            end=decision.end,
            hand=tip_track,
            off_belt=off_belt if decision.picked else np.inf,
            object_track=object_track,
            stays_visible=decision.in_bin or recording is not None,
        )

    def object_pose(self, time: float) -> Floats | None:
        """Pose of the object (7,); None before its lift, without an object, and after the object has disappeared."""
        if (
            self.object_track is None
            or time < self.lift
            or (not self.stays_visible and time > self.object_track.time[-1])
        ):
            return None
        return self.object_track.at(time)

    def from_time(self, time: float) -> RobotCycle:
        """The cycle with its tracks from a time [s] on."""
        object_track = None if self.object_track is None else self.object_track.from_time(time)
        return replace(self, hand=self.hand.from_time(time), object_track=object_track)


class Decision(NamedTuple):
    """One executed decision; each field is of one row."""

    robot: int
    number: int
    hand: Floats
    """Position of the hand at the decision, from the base (1, 3) [m]."""
    place: Floats
    """Place where the planner would have to pick the object at that moment (1, 3) [m]."""
    start: float
    lift: float
    end: float
    context: Context
    picked: bool
    in_bin: bool
    """Whether the object lies in a bin."""


def _times(begin: float, end: float) -> Floats:
    """Times from `begin` to `end` [s], both included."""
    return np.linspace(begin, end, max(int(np.ceil((end - begin) / SAMPLE_TIME)), 1) + 1)


def _object_track(decision: Decision, path: JerkTrajectory, release_time: float) -> Track:
    """Track of the object: held until the planned release, flight without air, fall to the bottom of the bin."""
    context, plan = decision.context, decision.context.plan
    hold_times = _times(0.0, release_time)
    flight_times = _times(0.0, float(plan.flight_time[0]))
    points = flight_state(plan.position, plan.velocity, flight_times)[0]
    height = lying_size(context.objects.shape, context.objects.size)[0, 2]
    hang_offset = context.cup_offset[0] + [*context.grasp[0], -LIP_GAP - height / 2]
    path_points = np.concatenate([path.sample(hold_times).position[0], points]) + hang_offset
    time = np.concatenate([hold_times, hold_times[-1] + flight_times])
    if decision.in_bin:
        # Free fall from the opening to the bottom of the bin: t = sqrt(2 h / g).
        drop = max(path_points[-1, 2] - float(context.target[0, 2] - context.bin_depth[0]) - height / 2, 0.0)
        fall_times = _times(0.0, np.sqrt(2.0 * drop / GRAVITY))
        fall_points = path_points[-1] - np.array([0.0, 0.0, 0.5 * GRAVITY]) * fall_times[:, None] ** 2
        path_points, time = np.concatenate([path_points, fall_points]), np.concatenate([time, time[-1] + fall_times])
    attitude = np.tile(yaw_attitude(context.objects.yaw), (len(path_points), 1))
    return Track(decision.lift + time, np.concatenate([path_points, attitude], axis=1))


def _replay_tracks(decision: Decision, recording: Recording) -> tuple[Track, Track]:
    """Tracks of hand and object, from stepping the recorded throw again."""
    model = recording.model
    tip, geom, joint_address = model.site("tcp").id, model.geom("object").id, int(model.joint("object").qposadr[0])
    time, hand, poses = list[float](), list[Floats](), list[Floats]()
    for data, _ in recording.play(SAMPLE_TIME):
        time.append(decision.lift + float(data.time))
        hand.append(data.site_xpos[tip].copy())
        poses.append(np.concatenate([data.geom_xpos[geom], data.qpos[joint_address + 3 : joint_address + 7]]))
    times = np.array(time)
    count = int(np.searchsorted(times, decision.end, "right"))
    return Track(times[:count], np.stack(hand)[:count]), Track(times, np.stack(poses))


@final
@dataclass(frozen=True)
class CycleHistory:
    """Recorded cycles of the robots of one line in a shift, as far as pictures still show their hands and objects."""

    initial_tips: Floats
    """Cup tips of robots that have not moved yet (R, 3) [m]."""
    since: float = 0.0
    """Time of the decision before the coming one, since the begin of the shift [s]."""
    cycles: tuple[RobotCycle, ...] = ()
    """Cycles in the order of their decisions."""

    def advance(self, since: float, new_cycle: RobotCycle | None) -> CycleHistory:
        """History at the next decision; the tracks of earlier cycles before `since` are dropped."""
        # The last cycle of every robot holds the position of its hand.
        last = {cycle.robot: number for number, cycle in enumerate(self.cycles)}.values()
        earliest = len(self.cycles) - MAX_CYCLES
        kept = [cycle for number, cycle in enumerate(self.cycles) if number >= earliest or number in last]
        cycles = tuple(cycle.from_time(since) for cycle in kept)
        return replace(self, since=since, cycles=cycles if new_cycle is None else (*cycles, new_cycle))

    def tips(self, time: float) -> Floats:
        """Tips of the robots' cups at a time, each from its robot's base (R, 3) [m]."""
        tips = self.initial_tips.copy()
        for cycle in self.cycles:
            if cycle.start <= time:
                tips[cycle.robot] = cycle.hand.at(time)
        return tips
