"""A check that free throws keep their rules, on fine samples and with arithmetic independent of the planners."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Bools, Floats, length
from pnt_gym.constants import GRAVITY
from pnt_gym.planning.free.rules import TOLERANCE, HandRules
from pnt_gym.planning.motion.limits import Limits
from pnt_gym.planning.motion.trajectory import HandPath

SAMPLE_RATE: Final = 10_000.0
"""Samples of the check per second [Hz]."""


class ThrowCheck(NamedTuple):
    """Peaks and margins of N motions against limits and rules; a negative excess is room to spare.

    Attributes:
        velocity: largest |v| / V (N,).
        acceleration: largest |a| / A (N,).
        jerk: largest |j| / J (N,).
        gap: least height of the hand over the object beyond the margin, until both are apart sideways (N,) [m].
        height: excess of the hand's height over ceiling and cap (N,) [m].
        outside: greatest distance of the hand outside the workspace (N,) [m]; -inf without a workspace.
        landing: distance of the drag-free landing from the target (N,) [m].
    """

    velocity: Floats
    acceleration: Floats
    jerk: Floats
    gap: Floats
    height: Floats
    outside: Floats
    landing: Floats

    def keeps_rules(self, landing: float = TOLERANCE) -> Bools:
        """Whether each motion keeps all limits and rules and lands within `landing` [m] of its target (N,)."""
        within_limits: Bools = np.asarray(
            np.maximum(np.maximum(self.velocity, self.acceleration), self.jerk) <= 1.0 + TOLERANCE
        )
        return (
            within_limits
            & (self.gap >= -TOLERANCE)
            & (self.height <= TOLERANCE)
            & (self.outside <= TOLERANCE)
            & (self.landing <= landing)
        )


def check_throw(
    path: HandPath,
    release_time: Floats,
    targets: Floats,
    limits: Limits,
    ceiling: ArrayLike,
    rules: HandRules,
) -> ThrowCheck:
    """Sample N motions and compare them with limits and rules.

    Args:
        path: N motions of the hand from pick to next pick.
        release_time: times of the release (N,) [s].
        targets: points at which the objects have to land (N, 3) [m].
        limits: speed, acceleration and jerk.
        ceiling: greatest height of the release [m], one number or (N,).
        rules: rules that bind the hand.
    """
    count = len(release_time)
    times = np.arange(0.0, float(path.duration.max()) + 1.0 / SAMPLE_RATE, 1.0 / SAMPLE_RATE)
    bounds = limits.arrays(count)
    motion = path.sample(times)
    release = path.sample(release_time[:, None])
    start, velocity = release.position[:, 0], release.velocity[:, 0]
    roof = np.broadcast_to(np.asarray(ceiling, dtype=np.float64), (count,))
    excess = motion.position[..., 2].max(axis=1) - roof - rules.hand_cap
    area = rules.workspace
    return ThrowCheck(
        length(motion.velocity).max(axis=1) / bounds[0],
        length(motion.acceleration).max(axis=1) / bounds[1],
        length(path.jerk(times)).max(axis=1) / bounds[2],
        least_gap(motion.position, times[None] - release_time[:, None], start, velocity, rules),
        # The release is bound by the ceiling, the hand by ceiling and cap.
        np.maximum(excess, start[:, 2] - roof),
        np.full(count, -np.inf) if area is None else -area.margin(motion.position).min(axis=1),
        miss(start, velocity, targets),
    )


def least_gap(position: Floats, elapsed: Floats, start: Floats, velocity: Floats, rules: HandRules) -> Floats:
    """Least height (N,) [m] of the hand over the object beyond the margin, until both are apart sideways.

    Args:
        position: positions of the hand (N, M, 3) [m].
        elapsed: time since the release (N, M) [s]; negative times do not count.
        start: release points (N, 3) [m].
        velocity: release velocities (N, 3) [m/s].
        rules: margin and clear distance.
    """
    after = elapsed[..., None]
    away = position - start[:, None] - after * velocity[:, None]
    sideways = np.sqrt(away[..., 0] ** 2 + away[..., 1] ** 2)
    is_clear: Bools = np.maximum.accumulate((sideways >= rules.clear_distance) & (elapsed > 0.0), axis=1)
    # Height of the hand over the object, z - z_0 - v_z t + g t^2 / 2, less the margin's share of the fall.
    gap = away[..., 2] + 0.5 * (1.0 - rules.margin) * GRAVITY * elapsed**2
    return np.where((elapsed >= 0.0) & ~is_clear, gap, np.inf).min(axis=1)


def miss(start: Floats, velocity: Floats, targets: Floats) -> Floats:
    """Horizontal distance (N,) [m] of the drag-free landing from the target; inf where the object never lands.

    An object that starts below the target's height lands only if it rises above that height.
    """
    drop = start[:, 2] - targets[:, 2]
    # Square of the vertical speed at the target's height; negative where the object never gets there.
    square = velocity[:, 2] ** 2 + 2.0 * GRAVITY * drop
    flight = (velocity[:, 2] + np.sqrt(np.maximum(square, 0.0))) / GRAVITY
    offset = start[:, :2] + flight[:, None] * velocity[:, :2] - targets[:, :2]
    return np.where((square >= 0.0) & (flight >= 0.0), np.sqrt(offset[:, 0] ** 2 + offset[:, 1] ** 2), np.inf)
