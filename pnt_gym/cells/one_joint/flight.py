"""Recorded motion of part and arm in a throw, and quantities derived from it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.constants import GRAVITY
from pnt_gym.robots.one_joint.references import Clock

EXTRAPOLATION_TIME: Final = 0.1
"""Time for which an ended flight is extrapolated, to find its nearest point to a goal [s]."""


@final
@dataclass(frozen=True)
class Flight:
    """N recorded throws. Sample k is the end of physics step k; rows hold zeros after their last step."""

    pose: Floats
    """x, y [m] and angle [rad] of the thrown part (N, M, 3)."""
    velocity: Floats
    """Velocity of the part in the middle of step k (N, M, 3) [m/s, rad/s]."""
    arm_angle: Floats
    """Angle of the arm (N, M) [rad]."""
    arm_speed: Floats
    """Speed of the arm in the middle of step k (N, M) [rad/s]."""
    torque: Floats
    """Torque of the motor during step k (N, M) [N m]."""
    touch: Bools
    """Whether the thrown part touches each pallet, then each other part (N, M, Q + P - 1)."""
    pushed: Bools
    """Whether a contact with a pallet or another part acted during step k, even one only about to be made (N, M)."""
    clock: Clock
    """Times of the steps on the motion's clock; the release is in the middle of step `clock.release_step`."""
    last_step: Ints
    """Last step that counts (N,)."""
    step: float
    """Physics step [s]."""
    final_pose: Floats
    """Pose of every part at the end (N, P, 3) [m, m, rad]."""
    final_velocity: Floats
    """Velocity of every part at the end (N, P, 3) [m/s, rad/s]."""

    @cached_property
    def time(self) -> Floats:
        """Time of each sample on the motion's clock (N, M) [s]; 0 is the beginning of the motion."""
        return self.clock.start[:, None] + self.step * (1.0 + np.arange(int(self.pose.shape[1]), dtype=np.int64))

    @cached_property
    def after_release(self) -> Bools:
        """Samples after the release that count (N, M)."""
        samples = np.arange(int(self.pose.shape[1]), dtype=np.int64)
        return (samples >= self.clock.release_step[:, None]) & (samples <= self.last_step[:, None])

    @cached_property
    def free(self) -> Bools:
        """Samples after the release and before a pallet or another part first acts (N, M)."""
        pushed = self.pushed & self.after_release
        return self.after_release & ~np.logical_or.accumulate(pushed, axis=1)

    @property
    def release_time(self) -> Floats:
        """Time at which the part comes free, on the motion's clock (N,) [s]."""
        return self.clock.start + self.step * (self.clock.release_step + 0.5)

    @property
    def release_angle(self) -> Floats:
        """The arm's angle at the release (N,) [rad]."""
        rows, at = np.arange(len(self.pose)), self.clock.release_step
        return self.arm_angle[rows, at] - 0.5 * self.step * self.arm_speed[rows, at]

    @property
    def release_speed(self) -> Floats:
        """The arm's speed at the release (N,) [rad/s]."""
        return self.arm_speed[np.arange(len(self.pose)), self.clock.release_step]

    @property
    def peak_torque(self) -> Floats:
        """Largest motor torque (N,) [N m]."""
        return np.abs(self.torque).max(axis=1)

    def touches(self) -> Bools:
        """Whether the part touched each pallet and other part after the release (N, Q + P - 1)."""
        return np.asarray((self.touch & self.after_release[..., None]).any(axis=1))

    def nearest(self, goal: Floats, weights: Floats) -> Floats:
        """State x, y, phi, dy (N, 4) of the free flight where it passes nearest to goals.

        A flight that ends at a pallet, or with the simulation, is extrapolated ballistically for a while, because the
        state measures the throw and not the pallet.

        Args:
            goal: goals (N, 4).
            weights: T of the Appendix (4,).
        """
        extra_steps, rows = round(EXTRAPOLATION_TIME / self.step), np.arange(len(goal))
        # Velocities belong to the middle of a step; gravity adds half a step until its end.
        fall = np.array([0.0, -GRAVITY, 0.0])
        rate = self.velocity + 0.5 * self.step * fall
        state = np.concatenate([self.pose, rate[..., 1:2]], axis=2)
        state = np.concatenate([state, np.zeros((len(rows), extra_steps, 4))], axis=1)
        samples = np.arange(state.shape[1], dtype=np.int64)
        first, end = self.clock.release_step, self.last_step + extra_steps
        last = first + np.maximum(self.free.sum(axis=1) - 1, 0)
        steps_after = samples - last[:, None]
        t: Floats = (self.step * steps_after)[..., None]
        start, speed = self.pose[rows, last][:, None], rate[rows, last][:, None]
        pose: Floats = start + speed * t + 0.5 * fall * t * t
        extrapolated = np.concatenate([pose, speed[..., 1:2] - GRAVITY * t], axis=2)
        state = np.where((steps_after > 0)[..., None], extrapolated, state)
        distance = (((state - goal[:, None]) * weights) ** 2).sum(axis=2)
        counts = (samples >= first[:, None]) & (samples <= end[:, None])
        # The interpolation needs one valid sample on either side.
        best = np.clip(np.where(counts, distance, np.inf).argmin(axis=1), first + 1, end - 1)
        left, middle, right = (distance[rows, best + i] for i in (-1, 0, 1))
        # Vertex of the parabola through three samples of the squared distance, and the state interpolated there.
        curvature = left - 2.0 * middle + right
        vertex = np.clip(0.5 * (left - right) / np.where(curvature > 0.0, curvature, np.inf), -1.0, 1.0)[:, None]
        a, b, c = (state[rows, best + i] for i in (-1, 0, 1))
        return b + 0.5 * vertex * (c - a) + 0.5 * vertex**2 * (a - 2.0 * b + c)
