"""The mover with a free release direction: throw and return are planned as fast transfers between moving states.

Rows without such a throw are thrown straight. The hand returns through the top of the vertical approach without a stop.
The hand stops at the top where the object is not in the window yet, and where no return without a stop keeps the rules.
If a stop at the top breaks a rule too, the hand brakes along the line of the release and returns on straight lines, as
the straight mover does.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, concatenate_records, length, recompute_rows, replace_rows, take
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.movers.straight import Meeting, Mover, StraightMover, ThrowMotion
from pnt_gym.planning.free.approach import Entry
from pnt_gym.planning.free.check import keeps_rules
from pnt_gym.planning.free.legs import Departure, return_leg, throw_leg
from pnt_gym.planning.free.release import free_releases, greatest_height, turning_point
from pnt_gym.planning.free.rules import HandRules
from pnt_gym.planning.motion.ballistics import flight_time
from pnt_gym.planning.motion.limits import EllipticWorkspace, LimitRows
from pnt_gym.planning.motion.rows import Segments
from pnt_gym.planning.motion.scurve import accelerate, brake, brake_distance, coast
from pnt_gym.planning.motion.trajectory import JerkTrajectory
from pnt_gym.planning.motion.transfer import PIECES
from pnt_gym.planning.straight.plan import CONTACT, Reason, ReleaseBatch

COLUMNS: Final = PIECES + 8
"""Segments of a return: a transfer, a wait, and an approach from rest to rest; other returns have fewer."""
BELOW_LIMIT: Final = 0.98
"""Share of the largest speed from which a return without a stop begins: a transfer begins below the limit."""


class FreeMover(Mover):
    """Throws with a free release direction."""

    def __init__(self, config: ConveyorConfig, workspace: EllipticWorkspace) -> None:
        follow = config.motion.follow_through
        self._belt = config.belt
        self._straight = StraightMover(config, workspace)
        self._workspace = workspace
        self.rules = HandRules(
            approach=config.motion.clearance,
            window=follow.window,
            hand_cap=follow.hand_cap,
            clear_distance=follow.clear_distance,
            margin=follow.margin,
            workspace=workspace,
        )

    def plan(self, pick: Floats, target: Floats, limits: LimitRows, ceiling: Floats) -> ReleaseBatch:
        """The quickest feasible release of a grid of choices, or the straight throw where there is none."""
        # The next pick is not known yet, so the release must leave room for any return.
        free = free_releases(pick, target, limits, ceiling=ceiling, rules=self.rules)
        release = self._release_batch(pick, free.position, free.velocity, free.flight_time, limits, ceiling)
        good = self.is_feasible(pick, release, limits)
        return recompute_rows(release, ~good, self._straight.plan, pick, target, limits, ceiling)

    def aim_at(self, context: Context, goal: Floats, slack: float) -> ReleaseBatch:
        """The nominal releases moved by the targets' displacements, at the nominal velocity."""
        plan, shift = context.plan, goal - context.target
        release = self._move_release(context, plan.position + shift, plan.flight_time)
        return recompute_rows(release, plan.straight, partial(self._straight.aim_at, slack=slack), context, goal)

    def release_at(self, context: Context, point: Floats) -> ReleaseBatch:
        """Releases at given points, at the nominal velocity."""
        flight = flight_time(point, context.plan.velocity, context.target[:, 2])
        release = self._move_release(context, point, flight)
        return recompute_rows(release, context.plan.straight, self._straight.release_at, context, point)

    def reserve(self, release: ReleaseBatch) -> Floats:
        """Reserves of straight throws (N,) [m]."""
        return self._straight.reserve(release)

    def is_feasible(self, pick: Floats, release: ReleaseBatch, limits: LimitRows) -> Bools:
        """Which throws have a plan and leave the hand room to turn back inside the workspace."""
        has_plan = release.feasible[:, None]
        velocity = np.where(has_plan, release.velocity, 0.0)
        position = np.where(has_plan, release.position, pick)
        turn = turning_point(position + self.rules.window * velocity, velocity, limits)
        inside = self._workspace.contains
        good = release.feasible & inside(pick) & inside(position) & inside(turn)
        return np.where(release.straight, self._straight.is_feasible(pick, release, limits), good)

    def throw(self, pick: Floats, release: ReleaseBatch, limits: LimitRows, ceiling: Floats) -> ThrowMotion:
        """Motions to the release and through the window at constant velocity."""
        roof = greatest_height(ceiling, self.rules)
        curved = throw_leg(pick, release.position, release.velocity, limits, roof).segments
        line = accelerate(release.direction, release.distance, limits)
        straight = release.straight
        way = replace_rows(curved, straight, take(line.pad(curved.durations.shape[1]), straight))
        time = way.durations.sum(axis=1)
        window = np.full(len(pick), self.rules.window)
        rows = ThrowMotion.zeros(
            len(pick),
            pick=pick,
            release_time=time,
            stop=release.position + window[:, None] * release.velocity,
            stop_time=time + window,
            velocity=release.velocity,
            roof=roof,
        )
        return ThrowMotion(rows, concatenate_records([way, coast(window)], axis=1))

    def back(self, motion: ThrowMotion, next_pick: Floats, limits: LimitRows) -> Segments:
        """Returns through the top of the approach without a stop where that keeps the rules, otherwise with a stop."""
        moves, down = return_leg(_departure(motion), next_pick, limits, motion.roof, self.rules)
        returns = _join_padded([moves.segments, down])
        good = moves.feasible & self._keeps(motion, returns, next_pick, limits)
        return recompute_rows(returns, ~good, self._back_with_stop, motion, next_pick, limits)

    def reach(self, motion: ThrowMotion, place: Floats, limits: LimitRows) -> Meeting:
        """The earliest meetings, without a stop where that is possible."""
        low, high = self._belt.pick_x
        meetings = self._in_flight(motion, place, limits, None)
        meetings = recompute_rows(meetings, meetings.position[:, 0] < low, self._at_border, motion, place, limits)
        inside = (meetings.position[:, 0] >= low - 1e-9) & (meetings.position[:, 0] <= high)
        return recompute_rows(meetings, ~(meetings.feasible & inside), self._with_stop, motion, place, limits)

    def _in_flight(self, motion: ThrowMotion, place: Floats, limits: LimitRows, arrival: Floats | None) -> Meeting:
        """Meetings without a stop, not before `arrival` (N,) [s] if given."""
        drift = np.zeros_like(place)
        drift[:, 0] = self._belt.speed
        shortest = None
        if arrival is not None:
            shortest = arrival - Entry.of(limits, len(place), self.rules.approach).down.durations.sum(axis=1)
        moves, down = return_leg(
            _departure(motion), place, limits, motion.roof, self.rules, drift=drift, shortest=shortest
        )
        time = np.where(moves.feasible, moves.duration, 0.0) + down.durations.sum(axis=1)
        position = place + drift * time[:, None]
        back = _join_padded([moves.segments, down])
        good = moves.feasible & self._keeps(motion, back, position, limits)
        return Meeting.at(position, time, np.zeros(len(time)), good, back)

    def _at_border(self, motion: ThrowMotion, place: Floats, limits: LimitRows) -> Meeting:
        """Meetings at the window's border, for hands that arrive before the object: by a wait or a slower return."""
        enters = (self._belt.pick_x[0] - place[:, 0]) / self._belt.speed
        meetings = self._wait_at_border(motion, place, limits, enters)
        return recompute_rows(meetings, ~meetings.feasible, self._in_flight, motion, place, limits, enters)

    def _wait_at_border(self, motion: ThrowMotion, place: Floats, limits: LimitRows, enters: Floats) -> Meeting:
        """Meetings at the border of the window when the objects enter it (N,) [s], after a stop above that point."""
        position = place.copy()
        position[:, 0] = self._belt.pick_x[0]
        back, good = self._hover(motion, position, limits, np.zeros(len(place)))
        wait = enters - back.durations.sum(axis=1)
        good &= wait >= 0.0
        wait = np.where(good, wait, 0.0)
        durations = back.durations.copy()
        durations[:, PIECES] = wait
        return Meeting.at(position, enters, wait, good, back._replace(durations=durations))

    def _hover(self, motion: ThrowMotion, next_pick: Floats, limits: LimitRows, wait: Floats) -> tuple[Segments, Bools]:
        """Returns with a stop and a wait (N,) [s] above the next pick, and which of them keep the rules."""
        moves, down = return_leg(_departure(motion), next_pick, limits, motion.roof, self.rules, hover=True)
        back = _join_padded([moves.segments, coast(wait), down])
        return back, moves.feasible & self._keeps(motion, back, next_pick, limits)

    def _with_stop(self, motion: ThrowMotion, place: Floats, limits: LimitRows) -> Meeting:
        """Meetings of hands that brake, move straight above the pick, wait, and go down."""
        halt, halted_motion = self._halt(motion, limits)
        time = halt.durations.sum(axis=1)
        belt = np.array([self._belt.speed, 0.0, 0.0])
        meetings, back = self._straight.meet(halted_motion, place + belt * time[:, None], limits)
        return meetings.replace(time=meetings.time + time, back=_join_padded([halt, back]))

    def _back_with_stop(self, motion: ThrowMotion, next_pick: Floats, limits: LimitRows) -> Segments:
        """Returns with a stop above the next pick, or where that breaks a rule, straight after a stop at once."""
        hovered, good = self._hover(motion, next_pick, limits, np.zeros(len(next_pick)))
        halt, halted_motion = self._halt(motion, limits)
        straight = _join_padded([halt, self._straight.back(halted_motion, next_pick, limits)])
        return replace_rows(straight, good, take(hovered, good))

    def _halt(self, motion: ThrowMotion, limits: LimitRows) -> tuple[Segments, ThrowMotion]:
        """Braking along the release velocity, and the motion that ends at rest after it."""
        speed = length(motion.velocity)
        ahead = motion.velocity / np.maximum(speed, 1e-12)[:, None]
        stop = motion.stop + ahead * brake_distance(speed, limits)[:, None]
        return brake(ahead, speed, limits), ThrowMotion.resting(stop)

    def _keeps(self, motion: ThrowMotion, back: Segments, next_pick: Floats, limits: LimitRows) -> Bools:
        """Which returns keep the limits and the rules of the hand (N,)."""
        path = JerkTrajectory(motion.stop, back.durations, back.jerks, motion.velocity)
        low = np.minimum(motion.stop[:, 2], next_pick[:, 2])
        return keeps_rules(path, np.zeros(len(low)), limits, motion.roof, self.rules, (low, low))

    def _move_release(self, context: Context, position: Floats, flight: Floats) -> ReleaseBatch:
        """Releases at moved points with the nominal velocity."""
        return self._release_batch(
            context.pick, position, context.plan.velocity, flight, context.throw_limits, context.ceiling
        )

    def _release_batch(
        self,
        pick: Floats,
        position: Floats,
        velocity: Floats,
        flight: Floats,
        limits: LimitRows,
        ceiling: Floats,
    ) -> ReleaseBatch:
        """Releases as a `ReleaseBatch`; feasible where `throw_leg` has a motion to the release."""
        motion = throw_leg(
            pick,
            np.where(flight[:, None] > 0.0, position, np.nan),
            velocity,
            limits,
            greatest_height(ceiling, self.rules),
        )
        return ReleaseBatch.from_velocities(
            pick,
            position,
            velocity,
            velocity,
            acceleration=motion.segments.greatest_acceleration(),
            time=motion.duration,
            flight_time=flight,
            ceiling_active=position[:, 2] >= ceiling - CONTACT,
            reason=np.where(motion.feasible, int(Reason.FEASIBLE), int(Reason.CEILING)),
        )


@final
class FlyingMover(FreeMover):
    """Throws on straight lines, and returns that leave the window without a stop, as those of the free direction.

    Throws are those of `StraightMover`: release, elevation, and the rule that the hand could stop inside the workspace.
    The return keeps all limits, and takes the place of the corner blending of Hassan et al. 2022 (section III-C), which
    adds overlapping moves and exceeds the jerk limit. The hand need not stay above the object: behind an object that
    rises along the line no hand does, one that stops no more than one that flies on.
    """

    def __init__(self, config: ConveyorConfig, workspace: EllipticWorkspace) -> None:
        super().__init__(config, workspace)
        self.rules = replace(self.rules, clear_distance=0.0)

    def throw(self, pick: Floats, release: ReleaseBatch, limits: LimitRows, ceiling: Floats) -> ThrowMotion:
        """Motions along the line from pick to release, through the window, and down to a speed below the limit."""
        motion = super().throw(pick, release, limits, ceiling)
        largest, _, jerk = limits
        excess = np.maximum(release.speed - BELOW_LIMIT * largest, 0.0)
        # The jerk falls for this time and rises for the same time, which takes the excess off the speed.
        half = np.sqrt(excess / jerk)
        signs = np.array([-1.0, 1.0])[:, None]
        ease = Segments(np.stack([half, half], axis=1), signs * (jerk[:, None] * release.direction)[:, None])
        way = (2.0 * release.speed - excess) * half
        return motion.replace(
            segments=concatenate_records([motion.segments, ease], axis=1),
            stop=motion.stop + way[:, None] * release.direction,
            stop_time=motion.stop_time + 2.0 * half,
            velocity=(release.speed - excess)[:, None] * release.direction,
        )

    def plan(self, pick: Floats, target: Floats, limits: LimitRows, ceiling: Floats) -> ReleaseBatch:
        """Minimum-time releases on straight lines."""
        return self._straight.plan(pick, target, limits, ceiling)

    def aim_at(self, context: Context, goal: Floats, slack: float) -> ReleaseBatch:
        """Releases of the straight throw for moved targets."""
        return self._straight.aim_at(context, goal, slack)

    def release_at(self, context: Context, point: Floats) -> ReleaseBatch:
        """Releases of the straight throw at given points."""
        return self._straight.release_at(context, point)

    def is_feasible(self, pick: Floats, release: ReleaseBatch, limits: LimitRows) -> Bools:
        """Which straight throws have a plan and could stop inside the workspace."""
        return self._straight.is_feasible(pick, release, limits)

    def accepts(self, context: Context, shift: Floats | None) -> Bools:
        """Which nominal straight throws could stop inside the workspace, also to moved targets."""
        return self._straight.accepts(context, shift)


def _departure(motion: ThrowMotion) -> Departure:
    return Departure(motion.stop, motion.velocity)


def _join_padded(parts: list[Segments]) -> Segments:
    """The parts one after the other, filled up with segments of no duration."""
    return concatenate_records(parts, axis=1).pad(COLUMNS)
