"""Pick and toss of the gripper robot as a function of time: grip, move, straight accelerated line, opening.

All motion is smooth: positions have continuous accelerations, or on the straight line continuous speeds with an
acceleration that rises and falls without a step.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from pnt_gym.arrays import Bools, Floats


@final
@dataclass(frozen=True)
class TossPlans:
    """N planned throws; times count from the moment the claws begin to close over the object."""

    pick: Floats
    """Position of the platform when the claws begin to close (N, 3) [m]; until the lift it moves with the belt."""
    belt: Floats
    """Velocity of the surface under the object (N, 3) [m/s]."""
    release: Floats
    """Position of the platform at the planned release (N, 3) [m]."""
    velocity: Floats
    """Velocity of the platform at the planned release (N, 3) [m/s]."""
    target: Floats
    """Point at which the object should pass the rim plane (N, 3) [m]."""
    hang: Floats
    """Distance of the object's middle below the platform (N,) [m]."""
    ramp: Floats
    """Time to accelerate, and again to brake (N,) [s]."""
    before: Floats
    """Time at constant velocity before the planned release (N,) [s]."""
    after: Floats
    """Time at constant velocity after the planned release (N,) [s]."""
    closing: Floats
    """Time to close the claws (N,) [s]."""
    grip_time: Floats
    """Time to close and to hold (N,) [s]."""
    move_time: Floats
    """Time from the grip to the line's start (N,) [s]."""
    theta: Floats
    """Angles of the halves: above the object, gripping, first contact with the planned width, released (N, 4) [rad]."""
    opening: Floats
    """Time to open the claws (N,) [s]."""
    lead: Floats
    """Time from the beginning of the opening to the planned release (N,) [s]."""
    shift: Floats
    """Time by which an action delays the opening (N,) [s]."""
    flight_time: Floats
    """Planned time of the flight to the rim plane (N,) [s]."""
    feasible: Bools
    """Whether the plan is within reach, strokes and motor speeds (N,)."""

    @property
    def line_time(self) -> Floats:
        """Time at which the straight line begins (N,) [s]."""
        return self.grip_time + self.move_time

    @property
    def belt_travel(self) -> Floats:
        """Displacement of the platform with the belt, until its velocity has faded at the line's start (N, 3) [m]."""
        return self.belt * (self.grip_time + 0.5 * self.move_time)[:, None]

    @property
    def release_time(self) -> Floats:
        """Time at which the object is planned to come free, without `shift` (N,) [s]."""
        return self.line_time + self.ramp + self.before

    @property
    def open_time(self) -> Floats:
        """Time of the command to open the claws (N,) [s]."""
        return self.release_time - self.lead + self.shift

    @property
    def stop_time(self) -> Floats:
        """Time at which the robot is at rest again and the claws are open (N,) [s]."""
        return np.maximum(self.release_time + self.after + self.ramp, self.open_time + self.opening)

    @property
    def start(self) -> Floats:
        """Position of the platform where the line begins (N, 3) [m]."""
        # A ramp takes half the way that full speed takes in the same time.
        return self.release - self.velocity * (0.5 * self.ramp + self.before)[:, None]

    @property
    def end(self) -> Floats:
        """Position of the platform where the line ends (N, 3) [m]."""
        return self.release + self.velocity * (0.5 * self.ramp + self.after)[:, None]

    @property
    def heading(self) -> Floats:
        """Horizontal unit vectors of the throw (N, 3); along x for a drop."""
        level = np.hypot(self.velocity[:, 0], self.velocity[:, 1])
        moving = level > 0.0
        x, y = self.velocity[:, :2].T / np.where(moving, level, 1.0)
        return np.stack([np.where(moving, x, 1.0), y, np.zeros_like(x)], axis=-1)

    def pose(self, time: Floats, delay: Floats | None = None) -> Floats:
        """Poses of the platform and its halves at times.

        Args:
            time: times (S,) or (N, S) [s]; before the start the platform moves with the belt, after the end it
                rests.
            delay: delay of the claws' opening after its command (N,) [s]; none when not given.

        Returns:
            x, y, z [m], theta [rad] (N, S, 4).
        """
        opening_delay = np.zeros_like(self.ramp) if delay is None else delay
        t = np.broadcast_to(time, (len(self.ramp), np.shape(time)[-1]))
        moving = (t - self.grip_time[:, None]) / self.move_time[:, None]
        # Way with the belt over the belt's speed: full speed until the grip, then fading.
        along = np.minimum(t, self.grip_time[:, None]) + self.move_time[:, None] * fading_travel(moving)
        position = self.pick[:, None] + along[..., None] * self.belt[:, None]
        position = position + ease(moving)[..., None] * (self.start - self.pick - self.belt_travel)[:, None]
        # The path length on the line, divided by the full speed [s].
        ramp, on_line = np.maximum(self.ramp, 1e-9)[:, None], t - self.line_time[:, None]
        flat = (self.before + self.after)[:, None]
        # Braking is the ramp backwards: the way at full speed less the way of a ramp.
        up, down = np.clip(on_line / ramp, 0.0, 1.0), np.clip((on_line - flat) / ramp - 1.0, 0.0, 1.0)
        level = np.clip(on_line - ramp, 0.0, flat)
        progress = ramp * _ramp_travel(up) + level + ramp * (down - _ramp_travel(down))
        position = position + progress[..., None] * self.velocity[:, None]
        open_angle, closed_angle, _, release_angle = self.theta.T[:, :, None]
        closing_share = ease(t / self.closing[:, None])
        opening_share = ease((t - (self.open_time + opening_delay)[:, None]) / self.opening[:, None])
        theta = (
            open_angle + closing_share * (closed_angle - open_angle) + opening_share * (release_angle - closed_angle)
        )
        return np.concatenate([position, theta[..., None]], axis=-1)


def ease(share: Floats) -> Floats:
    """Quintic ease from 0 to 1, without speed and acceleration at both ends; the largest speed is 1.875."""
    s = np.clip(share, 0.0, 1.0)
    return s * s * s * (10.0 + s * (6.0 * s - 15.0))


def fading_travel(share: Floats) -> Floats:
    """Path of a speed that falls from 1 to 0 as `1 - ease(s)`: 0 before, 1/2 at the end."""
    s = np.clip(share, 0.0, 1.0)
    # Integral of 1 - (10 s^3 - 15 s^4 + 6 s^5).
    return s - s**4 * (2.5 + s * (s - 3.0))


def ease_share(value: float) -> float:
    """Share of the time at which the quintic ease reaches a value."""
    share = np.linspace(0.0, 1.0, 2001)
    return float(np.interp(value, ease(share), share))


def _ramp_travel(s: Floats) -> Floats:
    """Integral of 3 s^2 - 2 s^3: path of a ramp whose acceleration begins and ends at zero, 1/2 at the end."""
    return s * s * s * (1.0 - 0.5 * s)
