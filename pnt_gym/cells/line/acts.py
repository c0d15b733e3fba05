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
from pnt_gym.cells.base.fluid import lying_size
from pnt_gym.cells.base.plant import Recording
from pnt_gym.cells.base.rotations import upright
from pnt_gym.cells.conveyor.config import LIP_GAP, ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.movers.straight import Mover, ThrowMotion
from pnt_gym.cells.conveyor.movers.tracking import brought_to_rest
from pnt_gym.constants import GRAVITY
from pnt_gym.planning.motion.ballistics import flight_state
from pnt_gym.planning.motion.trajectory import JerkTrajectory

LOOK: Final = 0.004
"""Time between two recorded poses of hands and objects; poses in between are interpolated [s]."""


MOST_SEEN: Final = 400
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

    def onward(self, time: float) -> Self:
        """Track from the last moment before a time [s] on."""
        first = min(max(int(np.searchsorted(self.time, time, "right")) - 1, 0), len(self.time) - 1)
        return type(self)(self.time[first:], self.pose[first:])


@final
@dataclass(frozen=True)
class Act:
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
    taken: float
    """Time from which the belt no longer carries the object; infinity where the cup does not seal [s]."""
    thing: Track | None
    """Middle of the object's extents and the object's attitude from the lift on (K, 7); None where the cup does not
    seal."""
    lies: bool
    """Whether the object stays in the picture after its track ends; False where its place is unknown."""

    def seen(self, time: float) -> Floats | None:
        """Pose of the object (7,); None before its lift, without an object, and after the object has disappeared."""
        if self.thing is None or time < self.lift or (not self.lies and time > self.thing.time[-1]):
            return None
        return self.thing.at(time)

    def onward(self, time: float) -> Act:
        """The cycle with its tracks from a time [s] on."""
        thing = None if self.thing is None else self.thing.onward(time)
        return replace(self, hand=self.hand.onward(time), thing=thing)


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
    lies: bool
    """Whether the object lies in a bin."""


def act(decision: Decision, tip: Floats, cell: ConveyorConfig, mover: Mover, recording: Recording | None) -> Act:
    """Tracks of hand and object for an executed decision.

    Args:
        decision: the executed decision.
        tip: tip of the cup relative to the planner's position of the hand, at the decision (3,) [m].
        cell: level of the robot's cell.
        mover: mover of the robot's planner.
        recording: recording of the simulated throw; None where the throw was not simulated.
    """
    context = decision.context
    chase = _chase(decision, tip, mover)
    if not decision.picked:
        motion = ThrowMotion.resting(context.pick)
        if cell.belt.tracking:
            motion = brought_to_rest(context.pick, context.limits, cell.belt.speed)
        hand, thing = _planned_hand(decision, motion), None
    elif recording is None:
        motion = mover.throw(context.pick, context.plan, context.throw_limits, context.ceiling)
        hand = _planned_hand(decision, motion)
        thing = _planned_thing(decision, motion)
    else:
        hand, thing = _simulated(decision, recording)
    time = np.concatenate([chase.time, hand.time])
    own = Track(time, np.concatenate([chase.pose, hand.pose]))
    held = decision.lift if cell.belt.tracking else decision.lift - cell.motion.dwell
    return Act(
        robot=decision.robot,
        number=decision.number,
        start=decision.start,
        lift=decision.lift,
        end=decision.end,
        hand=own,
        taken=held if decision.picked else np.inf,
        thing=thing,
        lies=decision.lies or recording is not None,
    )


def _moments(begin: float, end: float) -> Floats:
    """Times from `begin` to `end` [s], both included."""
    return np.linspace(begin, end, max(int(np.ceil((end - begin) / LOOK)), 1) + 1)


def _chase(decision: Decision, tip: Floats, mover: Mover) -> Track:
    """Track of the hand to its object, and along with the object until the lift."""
    resting = ThrowMotion.resting(decision.hand)
    meeting = mover.meet(resting, decision.place, decision.context.limits)
    path = JerkTrajectory.concatenate(decision.hand, [meeting.back], rides=True)
    time = _moments(0.0, decision.lift - decision.start)
    share = np.minimum(time / max(path.duration[0], LOOK), 1.0)[:, None]
    offset = tip + share * (decision.context.cup_offset[0] - tip)
    return Track(decision.start + time, path.sample(time).position[0] + offset)


def _planned_hand(decision: Decision, motion: ThrowMotion) -> Track:
    """Track of the hand after the lift, as planned."""
    path = JerkTrajectory.concatenate(motion.pick, [motion.segments], motion.pick_velocity)
    time = _moments(0.0, decision.end - decision.lift)
    return Track(decision.lift + time, path.sample(time).position[0] + decision.context.cup_offset[0])


def _planned_thing(decision: Decision, motion: ThrowMotion) -> Track:
    """Track of the object: held until the planned release, flight without air, fall to the bottom of the bin."""
    context, plan = decision.context, decision.context.plan
    path = JerkTrajectory.concatenate(motion.pick, [motion.segments], motion.pick_velocity)
    held = _moments(0.0, float(motion.release_time[0]))
    flying = _moments(0.0, float(plan.flight_time[0]))
    points = flight_state(plan.position, plan.velocity, flying)[0]
    high = lying_size(context.objects.shape, context.objects.size)[0, 2]
    hangs = context.cup_offset[0] + [*context.grasp[0], -LIP_GAP - high / 2]
    way = np.concatenate([path.sample(held).position[0], points]) + hangs
    time = np.concatenate([held, held[-1] + flying])
    if decision.lies:
        # Free fall from the opening to the bottom of the bin: t = sqrt(2 h / g).
        sinks = max(way[-1, 2] - float(context.target[0, 2] - context.bin_depth[0]) - high / 2, 0.0)
        falling = _moments(0.0, np.sqrt(2.0 * sinks / GRAVITY))
        down = way[-1] - np.array([0.0, 0.0, 0.5 * GRAVITY]) * falling[:, None] ** 2
        way, time = np.concatenate([way, down]), np.concatenate([time, time[-1] + falling])
    attitude = np.tile(upright(context.objects.yaw), (len(way), 1))
    return Track(decision.lift + time, np.concatenate([way, attitude], axis=1))


def _simulated(decision: Decision, recording: Recording) -> tuple[Track, Track]:
    """Tracks of hand and object, from stepping the recorded throw again."""
    model = recording.model
    tip, geom, first = model.site("tcp").id, model.geom("object").id, int(model.joint("object").qposadr[0])
    time, hand, thing = list[float](), list[Floats](), list[Floats]()
    for data, _ in recording.play(LOOK):
        time.append(decision.lift + float(data.time))
        hand.append(data.site_xpos[tip].copy())
        thing.append(np.concatenate([data.geom_xpos[geom], data.qpos[first + 3 : first + 7]]))
    times = np.array(time)
    count = int(np.searchsorted(times, decision.end, "right"))
    return Track(times[:count], np.stack(hand)[:count]), Track(times, np.stack(thing))


@final
@dataclass(frozen=True)
class Acts:
    """Recorded cycles of the robots of one line in a shift, as far as pictures still show their hands and objects."""

    rest: Floats
    """Cup tips of robots that have not moved yet (R, 3) [m]."""
    since: float = 0.0
    """Time of the decision before the coming one, since the begin of the shift [s]."""
    made: tuple[Act, ...] = ()
    """Cycles in the order of their decisions."""

    def then(self, since: float, more: Act | None) -> Acts:
        """History at the next decision; the tracks of earlier cycles before `since` are dropped."""
        kept = tuple(one.onward(since) for one in _latest(self.made))
        return replace(self, since=since, made=kept if more is None else (*kept, more))

    def tips(self, time: float) -> Floats:
        """Tips of the robots' cups at a time, each from its robot's base (R, 3) [m]."""
        found = self.rest.copy()
        for one in self.made:
            if one.start <= time:
                found[one.robot] = one.hand.at(time)
        return found


def _latest(acts: tuple[Act, ...]) -> tuple[Act, ...]:
    """The latest cycles, and the last cycle of every robot, which holds the position of its hand."""
    if len(acts) <= MOST_SEEN:
        return acts
    last = {one.robot: number for number, one in enumerate(acts)}.values()
    return tuple(one for number, one in enumerate(acts) if number >= len(acts) - MOST_SEEN or number in last)
