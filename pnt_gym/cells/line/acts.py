"""What the robots of one line do, kept for pictures: where hands and objects are at every moment of each cycle.

Hands go to their objects as planned. A throw that was simulated is the one that is kept, stepped again; one that a
table decided about is kept as it was planned: the hand's motion, and a flight without air from the planned release to
the bin, where the object then lies if the table has it so, and is gone if not.
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
"""Hands and objects are looked at this often, and interpolated in between [s]."""


MOST_SEEN: Final = 400
"""Acts that are kept, the latest ones: in a long shift bins are emptied now and then."""


class Track(NamedTuple):
    """A way through space: K moments."""

    time: Floats
    """Since the begin of the shift, not falling (K,) [s]."""
    pose: Floats
    """What is tracked, column by column (K, C)."""

    def at(self, time: float) -> Floats:
        """The pose at a time [s]; the first one before it all and the last one after it (C,)."""
        after = min(int(np.searchsorted(self.time, time)), len(self.time) - 1)
        before = max(after - 1, 0)
        span = max(float(self.time[after] - self.time[before]), 1e-12)
        share = min(max((time - float(self.time[before])) / span, 0.0), 1.0)
        return self.pose[before] + share * (self.pose[after] - self.pose[before])

    def onward(self, time: float) -> Self:
        """What matters of it from a time [s] on."""
        first = min(max(int(np.searchsorted(self.time, time, "right")) - 1, 0), len(self.time) - 1)
        return type(self)(self.time[first:], self.pose[first:])


@final
@dataclass(frozen=True)
class Act:
    """One cycle of a robot; x from its base."""

    robot: int
    number: int
    """Of the object in the stream."""
    start: float
    """When it was decided, since the begin of the shift [s]."""
    lift: float
    """When the object is lifted, or would have been [s]."""
    end: float
    """When the robot is free again [s]."""
    hand: Track
    """Tip of the cup (K, 3) [m]."""
    taken: float
    """When the belt no longer carries the object; infinity where the cup does not seal [s]."""
    thing: Track | None
    """Middle of the object's extents and its attitude from the lift on (K, 7); None where the cup does not seal."""
    lies: bool
    """Whether it can be seen when its way is over; where that is unknown, it cannot."""

    def seen(self, time: float) -> Floats | None:
        """The object (7,) from its lift on; None before, without one, and where it is gone."""
        if self.thing is None or time < self.lift or (not self.lies and time > self.thing.time[-1]):
            return None
        return self.thing.at(time)

    def onward(self, time: float) -> Act:
        """What matters of it from a time [s] on."""
        thing = None if self.thing is None else self.thing.onward(time)
        return replace(self, hand=self.hand.onward(time), thing=thing)


class Decision(NamedTuple):
    """One decision that was carried out; each field is of one row."""

    robot: int
    number: int
    hand: Floats
    """Where the hand stood, from the base (1, 3) [m]."""
    place: Floats
    """Where the planner would have had to pick the object at that moment (1, 3) [m]."""
    start: float
    lift: float
    end: float
    context: Context
    picked: bool
    lies: bool
    """Lies in a bin."""


def act(decision: Decision, tip: Floats, cell: ConveyorConfig, mover: Mover, recording: Recording | None) -> Act:
    """What is seen of a decision.

    Args:
        decision: what was decided.
        tip: of the cup from where the planner has the hand, before (3,) [m].
        cell: the robot's.
        mover: of its planner.
        recording: its throw as it was simulated; None where it was not.
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
    """Times from one to the other [s], both among them."""
    return np.linspace(begin, end, max(int(np.ceil((end - begin) / LOOK)), 1) + 1)


def _chase(decision: Decision, tip: Floats, mover: Mover) -> Track:
    """From where the hand stands to its object, and along with it until the lift."""
    resting = ThrowMotion.resting(decision.hand)
    meeting = mover.meet(resting, decision.place, decision.context.limits)
    path = JerkTrajectory.concatenate(decision.hand, [meeting.back], rides=True)
    time = _moments(0.0, decision.lift - decision.start)
    share = np.minimum(time / max(path.duration[0], LOOK), 1.0)[:, None]
    offset = tip + share * (decision.context.cup_offset[0] - tip)
    return Track(decision.start + time, path.sample(time).position[0] + offset)


def _planned_hand(decision: Decision, motion: ThrowMotion) -> Track:
    """As the planner has it after the lift."""
    path = JerkTrajectory.concatenate(motion.pick, [motion.segments], motion.pick_velocity)
    time = _moments(0.0, decision.end - decision.lift)
    return Track(decision.lift + time, path.sample(time).position[0] + decision.context.cup_offset[0])


def _planned_thing(decision: Decision, motion: ThrowMotion) -> Track:
    """Held until the planned release, without air to the middle of the opening, and down to the bottom of the bin."""
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
        sinks = max(way[-1, 2] - float(context.target[0, 2] - context.bin_depth[0]) - high / 2, 0.0)
        falling = _moments(0.0, np.sqrt(2.0 * sinks / GRAVITY))
        down = way[-1] - np.array([0.0, 0.0, 0.5 * GRAVITY]) * falling[:, None] ** 2
        way, time = np.concatenate([way, down]), np.concatenate([time, time[-1] + falling])
    attitude = np.tile(upright(context.objects.yaw), (len(way), 1))
    return Track(decision.lift + time, np.concatenate([way, attitude], axis=1))


def _simulated(decision: Decision, recording: Recording) -> tuple[Track, Track]:
    """Hand and object as they were, stepped again."""
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
    """What the robots of one line have done in a shift, as far as it can still be seen."""

    rest: Floats
    """Where tips of cups are that have done nothing yet (R, 3) [m]."""
    since: float = 0.0
    """When the decision before the coming one was taken, since the begin of the shift [s]."""
    made: tuple[Act, ...] = ()
    """In the order in which they were decided."""

    def then(self, since: float, more: Act | None) -> Acts:
        """The next decision comes; what was over before this one is kept as it ended."""
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
    """The acts that are kept: the latest ones, and the last one of every robot, where its hand is."""
    if len(acts) <= MOST_SEEN:
        return acts
    last = {one.robot: number for number, one in enumerate(acts)}.values()
    return tuple(one for number, one in enumerate(acts) if number >= len(acts) - MOST_SEEN or number in last)
