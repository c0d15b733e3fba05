"""How the hand moves through a pick: on a straight line, as in Hassan et al. 2022, or with a free release direction.

A mover plans the nominal release, the releases that corrections ask for, the motion to a release, and the motion from
there to the next pick. The cell, its plan check and the residuals know only this class; `planner` in the cell's
config chooses.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from functools import cached_property
from typing import final

import numpy as np

from pnt_gym.arrays import Bools, Floats, joined, take
from pnt_gym.cells.conveyor.config import ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.constants import GRAVITY
from pnt_gym.planning.motion.intercept import plan_intercept
from pnt_gym.planning.motion.limits import EllipticWorkspace, LimitRows, Limits
from pnt_gym.planning.motion.roots import bisect
from pnt_gym.planning.motion.scurve import accelerate, brake, brake_distance, coast, rest_to_rest
from pnt_gym.planning.motion.trajectory import JerkTrajectory, Segments
from pnt_gym.planning.straight.plan import ReleaseBatch
from pnt_gym.planning.straight.release import plan_release_batch, release_at_elevation, release_at_point

_LOWER_STEPS = 24
"""Elevations tried when a corrected release would rise above the ceiling and its slack."""
_HALVINGS = 12
"""Bisection of that elevation."""


@final
@dataclass(frozen=True)
class ThrowMotion:
    """N throws from the pick, at rest or with the belt, to where the return begins: at rest, or in flight.

    Attributes:
        pick: start (N, 3) [m].
        segments: acceleration, window and braking.
        release_time: when the planned release is reached (N,) [s].
        stop: where they end and the return begins (N, 3) [m].
        stop_time: when they do (N,) [s].
        velocity: of the hand there (N, 3) [m/s]; zero after a stop.
        roof: greatest height of the hand on the return (N,) [m].
        placed: the object was put down in rest, at its bin (N,).
        pick_velocity: of the hand when it lifts the object (N, 3) [m/s]; None where all begin at rest.
    """

    pick: Floats
    segments: Segments
    release_time: Floats
    stop: Floats
    stop_time: Floats
    velocity: Floats
    roof: Floats
    placed: Bools
    pick_velocity: Floats | None = None

    @cached_property
    def path(self) -> JerkTrajectory:
        """The way of the hand until the return begins, from rest or with its first velocity."""
        return JerkTrajectory.concatenate(self.pick, [self.segments], self.pick_velocity)

    @classmethod
    def resting(cls, place: Floats) -> ThrowMotion:
        """Hands that rest at `place` (N, 3) [m] and have thrown nothing."""
        zero = np.zeros(len(place))
        return cls(place, coast(zero), zero, place, zero, np.zeros_like(place), zero + np.inf, zero > 0.0)


@dataclass(frozen=True)
class Reach:
    """When and where N hands meet objects on the belt; rows that are not feasible hold placeholders.

    Attributes:
        position: where the hand lifts the object (N, 3) [m].
        time: from the end of the throw until the hand touches it (N,) [s].
        wait: standstill above the pick (N,) [s].
        feasible: whether the object can be picked (N,).
    """

    position: Floats
    time: Floats
    wait: Floats
    feasible: Bools


@final
@dataclass(frozen=True)
class Meeting(Reach):
    """The same with the motions there."""

    back: Segments


class Mover(ABC):
    """Abstract: plans the hand's motion for N picks at once; a row's result does not depend on the other rows."""

    @abstractmethod
    def plan(self, pick: Floats, target: Floats, limits: Limits, ceiling: Floats) -> ReleaseBatch:
        """Nominal releases for picks and targets (N, 3), below the ceilings (N,) [m]."""

    @abstractmethod
    def aimed(self, context: Context, goal: Floats, slack: float) -> ReleaseBatch:
        """Releases for moved targets (N, 3) [m], as like the nominal ones as can be.

        `slack` is how far they may rise above the ceiling [m].
        """

    @abstractmethod
    def moved(self, context: Context, point: Floats) -> ReleaseBatch:
        """Releases at given points (N, 3) [m]."""

    @abstractmethod
    def reserve(self, release: ReleaseBatch) -> Floats:
        """How far the targets of releases that are taken on may move along them (N,) [m]."""

    @abstractmethod
    def is_feasible(self, pick: Floats, release: ReleaseBatch, limits: Limits) -> Bools:
        """Which releases the robot can execute (N,)."""

    @abstractmethod
    def throw(self, pick: Floats, release: ReleaseBatch, limits: Limits, ceiling: Floats) -> ThrowMotion:
        """The motions to feasible releases and on to where the return begins."""

    @abstractmethod
    def back(self, motion: ThrowMotion, next_pick: Floats, limits: Limits) -> Segments:
        """The motions from there to next picks at rest (N, 3) [m]."""

    @abstractmethod
    def meet(self, motion: ThrowMotion, place: Floats, limits: Limits) -> Meeting:
        """The earliest meetings with objects on the belt.

        `place` (N, 3) [m] is where the hand would have to be to pick them when the throw ends.
        """

    def reach(self, motion: ThrowMotion, place: Floats, limits: Limits) -> Reach:
        """The same meetings, for those who compare many and need no motions."""
        return self.meet(motion, place, limits)


class StraightMover(Mover):
    """Throws along the line from pick to release, stops on it, and returns on straight lines.

    Args:
        config: the cell.
        workspace: where the hand may be.
    """

    def __init__(self, config: ConveyorConfig, workspace: EllipticWorkspace) -> None:
        self._belt = config.belt
        self._clearance = config.motion.clearance
        self._follow = config.motion.follow_through
        self._workspace = workspace
        self._reserve = config.motion.reserve

    def plan(self, pick: Floats, target: Floats, limits: Limits, ceiling: Floats) -> ReleaseBatch:
        """The exact optimum of Hassan et al. 2022."""
        return plan_release_batch(pick, target, limits, ceiling=ceiling)

    def aimed(self, context: Context, goal: Floats, slack: float) -> ReleaseBatch:
        """Releases at the nominal elevation, lower only where they would exceed ceiling and slack."""
        limits, top = context.throw_limits, context.ceiling + slack
        angle = np.where(context.plan.feasible, context.plan.angle, 0.0)
        release = release_at_elevation(context.pick, goal, limits, angle)
        rows = np.flatnonzero(release.feasible & (release.position[:, 2] > top))
        if rows.size == 0:
            return release
        angle[rows] = _lowered(context.pick[rows], goal[rows], take(limits, rows), angle[rows], top[rows])
        return release_at_elevation(context.pick, goal, limits, angle)

    def moved(self, context: Context, point: Floats) -> ReleaseBatch:
        """Releases at the points, at the speed that the way there allows."""
        return release_at_point(context.pick, point, context.throw_limits, plane_z=context.target[:, 2])

    def reserve(self, release: ReleaseBatch) -> Floats:
        """The same for all."""
        return np.full(len(release.speed), self._reserve)

    def is_feasible(self, pick: Floats, release: ReleaseBatch, limits: Limits) -> Bools:
        """Which throws exist and stay inside the workspace until the hand has stopped.

        The workspace is convex and the path straight, so pick and stop are enough.
        """
        planned = replace(
            release,
            speed=np.where(release.feasible, release.speed, 0.0),
            angle=np.where(release.feasible, release.angle, 0.0),
        )
        stop = pick + release.direction * (release.distance + self._run_out(planned, limits))[:, None]
        return release.feasible & self._workspace.contains(pick) & self._workspace.contains(stop)

    def throw(self, pick: Floats, release: ReleaseBatch, limits: Limits, ceiling: Floats) -> ThrowMotion:
        """Along the line from pick to release, the window at constant velocity, and the stop on that line."""
        direction, zero = release.direction, np.zeros(len(pick))
        ahead = accelerate(direction, release.distance, limits)
        window = coast(zero + self._follow.window)
        slow = brake(direction, release.speed, self.braking_limits(release, limits))
        release_time = ahead.durations.sum(axis=1)
        return ThrowMotion(
            pick=pick,
            segments=joined([ahead, window, slow], axis=1),
            release_time=release_time,
            stop=pick + direction * (release.distance + self._run_out(release, limits))[:, None],
            stop_time=release_time + self._follow.window + slow.durations.sum(axis=1),
            velocity=np.zeros_like(pick),
            roof=zero + np.inf,
            placed=zero > 0.0,
        )

    def back(self, motion: ThrowMotion, next_pick: Floats, limits: Limits) -> Segments:
        """Straight above the next pick, then down."""
        return straight_back(motion.stop, next_pick, np.zeros(len(next_pick)), limits, self._clearance)

    def meet(self, motion: ThrowMotion, place: Floats, limits: Limits) -> Meeting:
        """The earliest meeting of a hand that moves from rest to rest."""
        found = self.reach(motion, place, limits)
        back = straight_back(motion.stop, found.position, found.wait, limits, self._clearance)
        return Meeting(**vars(found), back=back)

    def reach(self, motion: ThrowMotion, place: Floats, limits: Limits) -> Reach:
        """Where and when that is."""
        found = plan_intercept(
            motion.stop,
            place,
            np.array([self._belt.speed, 0.0, 0.0]),
            limits,
            clearance=self._clearance,
            window=self._belt.pick_x,
        )
        return Reach(
            position=np.where(found.feasible[:, None], found.position, place),
            time=np.where(found.feasible, found.time, 0.0),
            wait=np.where(found.feasible, found.wait, 0.0),
            feasible=found.feasible,
        )

    def braking_limits(self, release: ReleaseBatch, limits: Limits) -> Limits:
        """Limits of the braking: with `gravity_share`, the hand falls away no faster than that share of g."""
        if self._follow.gravity_share is None:
            return limits
        velocity, acceleration, jerk = limits.arrays(len(release.speed))
        rise = np.maximum(np.sin(release.angle), 1e-3)
        return LimitRows(velocity, np.minimum(acceleration, self._follow.gravity_share * GRAVITY / rise), jerk)

    def _run_out(self, release: ReleaseBatch, limits: Limits) -> Floats:
        """Way of the hand after the release (N,) [m]."""
        way = brake_distance(release.speed, self.braking_limits(release, limits))
        return self._follow.window * release.speed + way


def straight_back(stop: Floats, next_pick: Floats, wait: Floats, limits: Limits, clearance: float) -> Segments:
    """From rest at `stop` straight above the next pick, a wait (N,) [s], and the vertical approach: 15 segments."""
    above = next_pick + np.array([0.0, 0.0, clearance])
    down = np.broadcast_to(np.array([0.0, 0.0, -clearance]), above.shape)
    return joined([rest_to_rest(above - stop, limits), coast(wait), rest_to_rest(down, limits)], axis=1)


def _lowered(pick: Floats, goal: Floats, limits: Limits, angle: Floats, top: Floats) -> Floats:
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
    return angle * bisect(fits, low, low + 1.0 / _LOWER_STEPS, _HALVINGS)[0]
