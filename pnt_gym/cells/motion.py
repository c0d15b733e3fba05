"""The straight throw of one pick: acceleration to the release, window, and brake.

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
from pnt_gym.planning.segments import accelerate, brake, brake_distance, coast
from pnt_gym.planning.trajectory import Segments
from pnt_gym.planning.workspace import EllipticWorkspace


@final
@dataclass(frozen=True)
class ThrowMotion:
    """N throws from rest at the pick to where the return begins: at rest, or in flight.

    Attributes:
        pick: start (N, 3) [m].
        parts: acceleration, window and braking.
        release_time: when the planned release is reached (N,) [s].
        stop: where the parts end and the return begins (N, 3) [m].
        stop_time: when they do (N,) [s].
        velocity: of the hand there (N, 3) [m/s]; zero after a stop.
        roof: greatest height of the hand on the return (N,) [m].
    """

    pick: Floats
    parts: tuple[Segments, ...]
    release_time: Floats
    stop: Floats
    stop_time: Floats
    velocity: Floats
    roof: Floats

    @classmethod
    def resting(cls, place: Floats) -> ThrowMotion:
        """Hands that rest at `place` (N, 3) [m] and have thrown nothing."""
        zero = np.zeros(len(place))
        return cls(place, (), zero, place, zero, np.zeros_like(place), zero + np.inf)


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
        velocity=np.zeros_like(pick),
        roof=np.full(len(pick), np.inf),
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


def _run_out(release: ReleaseBatch, limits: MotionLimits, follow: FollowThrough) -> Floats:
    """Way of the hand after the release (N,) [m]."""
    return follow.window * release.speed + brake_distance(release.speed, braking_limits(release, limits, follow))
