"""Motions of the arm up to the release and until it stands again, N at a time (Miyashita et al., section 4.1)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats, numbers
from pnt_gym.errors import PlanningError


class ArmSample(NamedTuple):
    """Angle [rad], speed [rad/s] and acceleration [rad/s2] of the arm, each (N, M)."""

    angle: Floats
    speed: Floats
    acceleration: Floats


@final
@dataclass(frozen=True, eq=False)
class ArmMotion:
    """N motions of the arm: rest, a uniform cubic B-spline up to the release, constant braking, rest.

    A row of NaN stands for a throw without a motion; the row's samples are NaN.

    Attributes:
        knots: control points (N, n + 3) of the spline's n intervals [rad] (Eqs. 13, 14).
        time_step: length of an interval (N,) [s].
        braking: acceleration after the release (N,), against the speed of the release [rad/s2].

    Raises:
        ValueError: shapes disagree, a time step is not positive, or a braking acceleration does not stop the arm.
    """

    knots: Floats
    time_step: Floats
    braking: Floats

    def __post_init__(self) -> None:
        if self.knots.ndim != 2 or self.knots.shape[1] < 4:
            raise PlanningError(f"knots must have shape (N, n + 3) with n >= 1, got {self.knots.shape}")
        for name in ("time_step", "braking"):
            shape, rows = getattr(self, name).shape, self.knots.shape[:1]
            if shape != rows:
                raise PlanningError(f"{name} must have shape {rows}, got {shape}")
        if (self.time_step <= 0.0).any():
            raise PlanningError(f"time_step must be positive [s], got {np.nanmin(self.time_step)}")
        wrong = (self.braking * self.release_speed >= 0.0) & (self.release_speed != 0.0)
        if wrong.any():
            row = int(np.argmax(wrong))
            raise PlanningError(
                f"braking is {self.braking[row]:.4g} rad/s2 at a release speed of {self.release_speed[row]:.4g} rad/s; "
                "it must point the other way"
            )

    @classmethod
    def of(cls, start: Floats, time_step: Floats, accelerations: Floats, braking: Floats) -> ArmMotion:
        """Return the motions from rest with accelerations that are linear between the borders of the intervals.

        Args:
            start: angles at rest (N,) [rad].
            time_step: length of an interval (N,) [s].
            accelerations: accelerations at the borders (N, n + 1) [rad/s2].
            braking: acceleration after the release (N,) [rad/s2].
        """
        # The second differences of the control points are the accelerations at the borders times the squared time step.
        bends = accelerations * (time_step * time_step)[:, None]
        # At rest the first and the third control point are equal, so the angle at the border is middle + bend / 6.
        middle = start - bends[:, 0] / 6.0
        slopes = np.cumsum(bends, axis=1) - 0.5 * bends[:, :1]
        later = middle[:, None] + np.cumsum(slopes, axis=1)
        knots = np.concatenate([(middle + 0.5 * bends[:, 0])[:, None], middle[:, None], later], axis=1)
        return cls(knots, time_step, braking)

    @property
    def intervals(self) -> int:
        """The number n of the spline's intervals."""
        return self.knots.shape[1] - 3

    @property
    def duration(self) -> Floats:
        """Release time t_t = n Delta t (N,) [s] (Eq. 23, which prints t_f)."""
        return self.intervals * self.time_step

    @property
    def start_angle(self) -> Floats:
        """Angle at which the arm rests before the throw (N,) [rad]."""
        return _mean(self.knots[:, :3])

    @property
    def release_angle(self) -> Floats:
        """Angle theta_t of the arm at the release (N,) [rad]."""
        return _mean(self.knots[:, -3:])

    @property
    def release_speed(self) -> Floats:
        """Speed of the arm at the release (N,) [rad/s]."""
        # At a border of the intervals the cubic B-spline's slope depends on the two outer control points only.
        return (self.knots[:, -1] - self.knots[:, -3]) / (2.0 * self.time_step)

    @property
    def release_acceleration(self) -> Floats:
        """Acceleration just before the release (N,) [rad/s2]."""
        return (self.knots[:, -3] - 2.0 * self.knots[:, -2] + self.knots[:, -1]) / self.time_step**2

    @property
    def stop_time(self) -> Floats:
        """Time at which the arm stands again (N,) [s]."""
        return self.duration + self._braking_time()

    @property
    def stop_angle(self) -> Floats:
        """Angle at which the arm stands again (N,) [rad]."""
        return self.release_angle + 0.5 * self.release_speed * self._braking_time()

    def sample(self, times: ArrayLike) -> ArmSample:
        """Return the motion at ``times`` [s], shape (M,) for all rows or (N, M), each result (N, M).

        Before 0 the arm rests at its first angle; the release itself belongs to the spline.
        """
        time, count = numbers(times, "times"), self.knots.shape[0]
        if time.ndim not in (1, 2) or (time.ndim == 2 and time.shape[0] != count):
            raise PlanningError(f"times must have shape (M,) or ({count}, M), got {time.shape}")
        time = np.broadcast_to(time, (count, time.shape[-1]))
        # Constant braking from the release on, then rest.
        braking_time = self._braking_time()[:, None]
        speed, braking = self.release_speed[:, None], self.braking[:, None]
        elapsed = np.clip(time - self.duration[:, None], 0.0, braking_time)
        moving = elapsed < braking_time
        brake = (
            self.release_angle[:, None] + elapsed * (speed + 0.5 * elapsed * braking),
            np.where(moving, speed + elapsed * braking, 0.0 * braking_time),
            np.where(moving, braking, 0.0 * braking_time),
        )
        after = time > self.duration[:, None]
        angle, speed, acceleration = (np.where(after, b, s) for b, s in zip(brake, self._spline(time), strict=True))
        # Rows without a motion compare as False everywhere and keep their NaN.
        return ArmSample(angle, speed, np.where(time < 0.0, 0.0 * acceleration, acceleration))

    def _braking_time(self) -> Floats:
        speed = self.release_speed
        return np.where(speed == 0.0, 0.0, -speed / np.where(speed == 0.0, 1.0, self.braking))

    def _spline(self, time: Floats) -> ArmSample:
        """Samples of the spline of Eq. 13, with times clipped to its ends."""
        count, intervals = self.knots.shape[0], self.intervals
        step = self.time_step[:, None]
        share = np.clip(np.where(np.isnan(step), 0.0, time / step), 0.0, float(intervals))
        index = np.minimum(share.astype(np.int64), intervals - 1)
        s = share - index
        rows = index + intervals * np.arange(count, dtype=np.int64)[:, None]
        # The uniform B-spline basis: coefficients of each interval's cubic in s from 0 to 1, constant first.
        w, x, y, z = self.knots[:, :-3], self.knots[:, 1:-2], self.knots[:, 2:-1], self.knots[:, 3:]
        cubics = np.stack(
            [(w + 4.0 * x + y) / 6.0, 0.5 * (y - w), 0.5 * (w - 2.0 * x + y), (z - w + 3.0 * (x - y)) / 6.0], axis=2
        )
        c = np.take(cubics.reshape(count * intervals, 4), rows, axis=0)
        c0, c1, c2, c3 = c[..., 0], c[..., 1], c[..., 2], c[..., 3]
        return ArmSample(
            c0 + s * (c1 + s * (c2 + s * c3)),
            (c1 + s * (2.0 * c2 + s * (3.0 * c3))) / step * (time >= 0.0),
            (2.0 * c2 + s * (6.0 * c3)) / (step * step),
        )


def _mean(three: Floats) -> Floats:
    # Uniform cubic B-splines at a border of their intervals: 1/6, 4/6, 1/6.
    return (three[:, 0] + 4.0 * three[:, 1] + three[:, 2]) / 6.0
