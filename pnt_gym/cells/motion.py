"""The hand's path through one pick: throw, window, brake, return above the next object, vertical approach.

Every piece is a minimum-time S-curve piece on a straight line, joined at rest or at constant velocity, so the norms of
velocity, acceleration and jerk stay within the limits without blending.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from pnt_gym.config import FollowThrough
from pnt_gym.planning.arrays import Bools, Floats
from pnt_gym.planning.ballistics import GRAVITY
from pnt_gym.planning.limits import MotionLimits
from pnt_gym.planning.plan import ReleaseBatch
from pnt_gym.planning.segments import accelerate, brake, brake_distance, coast, rest_to_rest
from pnt_gym.planning.trajectory import JerkTrajectory, Segments
from pnt_gym.planning.workspace import EllipticWorkspace


@final
@dataclass(frozen=True)
class ThrowMotion:
    """N throws from rest at the pick to rest after braking.

    Attributes:
        pick: start (N, 3) [m].
        parts: acceleration, window and braking.
        release_time: when the planned release is reached (N,) [s].
        stop: where the hand comes to rest (N, 3) [m].
        stop_time: when it does (N,) [s].
    """

    pick: Floats
    parts: tuple[Segments, ...]
    release_time: Floats
    stop: Floats
    stop_time: Floats


def throw_motion(pick: Floats, release: ReleaseBatch, limits: MotionLimits, follow: FollowThrough) -> ThrowMotion:
    """The throw along the line from pick to release, the window at constant velocity, and the stop on that line."""
    direction = release.direction
    window = np.full(len(pick), follow.window)
    slow = braking_limits(release, limits, follow)
    parts = (
        accelerate(direction, release.distance, limits),
        coast(window),
        brake(direction, release.speed, slow),
    )
    times = [part.durations.sum(axis=1) for part in parts]
    return ThrowMotion(
        pick=pick,
        parts=parts,
        release_time=times[0],
        stop=pick + direction * (release.distance + _run_out(release, limits, follow))[:, None],
        stop_time=times[0] + times[1] + times[2],
    )


def braking_limits(release: ReleaseBatch, limits: MotionLimits, follow: FollowThrough) -> MotionLimits:
    """Limits of the braking: with `gravity_share`, the hand falls away no faster than that share of g."""
    if follow.gravity_share is None:
        return limits
    velocity, acceleration, jerk = limits.arrays(len(release.speed))
    rise = np.maximum(np.sin(release.angle), 1e-3)
    return MotionLimits(velocity, np.minimum(acceleration, follow.gravity_share * GRAVITY / rise), jerk)


def stays_inside(
    pick: Floats,
    release: ReleaseBatch,
    limits: MotionLimits,
    follow: FollowThrough,
    workspace: EllipticWorkspace,
) -> Bools:
    """Which throws exist and keep release, window and stop inside the workspace (N,).

    The workspace is convex and the path straight, so the two end points are enough.
    """
    planned = replace(
        release,
        speed=np.where(release.feasible, release.speed, 0.0),
        angle=np.where(release.feasible, release.angle, 0.0),
    )
    stop = pick + release.direction * (release.distance + _run_out(planned, limits, follow))[:, None]
    return release.feasible & workspace.contains(pick) & workspace.contains(stop)


def cycle_path(
    motion: ThrowMotion, limits: MotionLimits, wait: Floats, next_pick: Floats, clearance: float
) -> JerkTrajectory:
    """The whole cycle: throw, straight return above the next pick, a wait if it is still to come, vertical approach.

    Args:
        motion: the throw.
        limits: of the whole cycle.
        wait: standstill above the next pick (N,) [s].
        next_pick: (N, 3) [m].
        clearance: height of the vertical approach [m].
    """
    above = next_pick + np.array([0.0, 0.0, clearance])
    down = np.broadcast_to(np.array([0.0, 0.0, -clearance]), above.shape)
    back = rest_to_rest(above - motion.stop, limits)
    return JerkTrajectory.concatenate(motion.pick, [*motion.parts, back, coast(wait), rest_to_rest(down, limits)])


def _run_out(release: ReleaseBatch, limits: MotionLimits, follow: FollowThrough) -> Floats:
    """Way of the hand after the release (N,) [m]."""
    return follow.window * release.speed + brake_distance(release.speed, braking_limits(release, limits, follow))
