"""Paths of piecewise constant jerk in space, N at a time, which plans hand to robots."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol, final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats, in_order, length, numbers
from pnt_gym.errors import PlanningError
from pnt_gym.planning.motion import kernel
from pnt_gym.planning.motion.limits import Limits
from pnt_gym.planning.motion.rows import Borders, Knot, Segments, Start
from pnt_gym.rows import Rows


class Samples(NamedTuple):
    """Position [m], velocity [m/s] and acceleration [m/s2], each (N, M, 3)."""

    position: Floats
    velocity: Floats
    acceleration: Floats


class PeakRatios(NamedTuple):
    """Largest |v| / V, |a| / A and |j| / J of each path, each (N,)."""

    velocity: Floats
    acceleration: Floats
    jerk: Floats


class HandPath(Protocol):
    """N timed paths of the hand, the only part of a plan that a robot needs."""

    @property
    def duration(self) -> Floats:
        """Total time of each path (N,) [s]."""
        ...

    def sample(self, times: ArrayLike) -> Samples:
        """Motion at ``times`` [s], shape (M,) for all paths or (N, M), each result (N, M, 3); rest outside."""
        ...

    def jerk(self, times: ArrayLike) -> Floats:
        """Jerk at ``times`` [s] as in ``sample``, (N, M, 3) [m/s3]; zero outside."""
        ...


@final
@dataclass(frozen=True, eq=False)
class JerkTrajectory:
    """N paths of K segments of constant jerk each.

    Attributes:
        start: first points (N, 3) [m].
        durations: segment times (N, K) [s], zero allowed.
        jerks: segment jerks (N, K, 3) [m/s3].
        start_velocity: velocities at time 0 (N, 3) [m/s], rest when not given.
        start_acceleration: accelerations at time 0 (N, 3) [m/s2], zero when not given.
        rides: whether a path has its first velocity before time 0 and its last velocity after its duration; if not,
            the path rests before and after.
        knot_times: segment borders (N, K + 1) [s], from 0 to the duration.
        knots: position, velocity and acceleration at the borders, each (N, K + 1, 3).
        table: the same for compiled functions, see `kernel.lay_out`.

    Raises:
        ValueError: if shapes disagree, a value is not finite, or a duration is negative.
    """

    start: Floats
    durations: Floats
    jerks: Floats
    start_velocity: Floats | None = None
    start_acceleration: Floats | None = None
    rides: bool = False
    knot_times: Floats = field(init=False)
    knots: Samples = field(init=False)
    table: Rows[Knot] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        begin, durations, jerks = self.start, self.durations, self.jerks
        if begin.ndim != 2 or begin.shape[1] != 3:
            raise PlanningError(f"start must have shape (N, 3), got {begin.shape}")
        if durations.ndim != 2 or durations.shape[0] != len(begin) or durations.shape[1] == 0:
            raise PlanningError(f"durations must have shape ({len(begin)}, K) with K >= 1, got {durations.shape}")
        if jerks.shape != (*durations.shape, 3):
            raise PlanningError(f"jerks must have shape {(*durations.shape, 3)}, got {jerks.shape}")
        zero, (count, columns) = np.zeros(begin.shape), durations.shape
        velocity = zero if self.start_velocity is None else self.start_velocity
        acceleration = zero if self.start_acceleration is None else self.start_acceleration
        times, table = np.empty((count, columns + 1)), Knot.empty(count, columns + 2)
        knots = np.empty((3, count, columns + 1, 3))
        start, segments = Start(*in_order(begin, velocity, acceleration)), Segments(*in_order(durations, jerks))
        if not kernel.lay_out(start, segments, self.rides, Borders(times, *knots), table):
            raise _value_error(begin, durations, jerks)
        self.__dict__.update(
            start_velocity=velocity,
            start_acceleration=acceleration,
            knot_times=times,
            knots=Samples(*knots),
            table=table,
        )

    @classmethod
    def concatenate(
        cls,
        start: Floats,
        parts: Sequence[Segments],
        start_velocity: Floats | None = None,
        rides: bool = False,
    ) -> JerkTrajectory:
        """Return the paths that start at ``start`` (N, 3) and run through ``parts`` in turn."""
        if len(parts) == 1:
            return cls(start, parts[0].durations, parts[0].jerks, start_velocity, rides=rides)
        durations = np.concatenate([part.durations for part in parts], axis=1)
        jerks = np.concatenate([part.jerks for part in parts], axis=1)
        return cls(start, durations, jerks, start_velocity, rides=rides)

    @property
    def duration(self) -> Floats:
        """Total time of each path (N,) [s]."""
        return self.knot_times[:, -1]

    @property
    def end(self) -> Floats:
        """Last point of each path (N, 3) [m]."""
        return self.knots.position[:, -1]

    def sample(self, times: ArrayLike) -> Samples:
        """Return the motion at ``times`` [s], shape (M,) for all paths or (N, M), each result (N, M, 3).

        A path rests at its start before time 0 and at its last point after its duration, unless the path ``rides``.
        """
        time = self._times(times)
        position, velocity, acceleration = np.empty((3, len(self.table), time.shape[1], 3))
        kernel.sample(self.table, time, position, velocity, acceleration)
        return Samples(position, velocity, acceleration)

    def jerk(self, times: ArrayLike) -> Floats:
        """Return the jerk at ``times`` [s], shape (M,) or (N, M), result (N, M, 3) [m/s3]; zero outside."""
        time = self._times(times)
        rows = np.empty((len(self.table), time.shape[1]), dtype=np.int64)
        kernel.rows_at(self.table, time, rows)
        return np.take_along_axis(self.table["jerk"], rows[..., None], axis=1)

    def peak_ratios(self, limits: Limits, samples: int = 33) -> PeakRatios:
        """Return each path's largest speed, acceleration and jerk as shares of ``limits``.

        Acceleration is linear and jerk constant within a segment, so the peaks of both lie on segment borders and
        are exact; speed is sampled at ``samples`` points of every segment.
        """
        count, columns = self.durations.shape
        velocity, acceleration, jerk = limits.arrays(count)
        share = np.linspace(0.0, 1.0, samples)
        times = self.knot_times[:, :-1, None] + self.durations[:, :, None] * share
        speed = length(self.sample(times.reshape(count, columns * samples)).velocity).max(axis=1)
        moving = self.durations > 0.0
        return PeakRatios(
            speed / velocity,
            length(self.knots.acceleration).max(axis=1) / acceleration,
            np.where(moving, length(self.jerks), 0.0).max(axis=1) / jerk,
        )

    def _times(self, times: ArrayLike) -> Floats:
        """Times of each path (N, M), or of all paths (1, M)."""
        time = np.asarray(numbers(times, "times"), order="C")
        if time.ndim == 1:
            return time[None]
        if time.ndim != 2 or time.shape[0] != len(self.table):
            raise PlanningError(f"times must have shape (M,) or ({len(self.table)}, M), got {time.shape}")
        return time


def _value_error(start: Floats, durations: Floats, jerks: Floats) -> PlanningError:
    """The error that names the values that no path can have."""
    if not (np.isfinite(start).all() and np.isfinite(jerks).all()):
        return PlanningError("start and jerks must be finite; leave infeasible plans out of a trajectory")
    bad = ~(np.isfinite(durations) & (durations >= 0.0))
    return PlanningError(f"durations must be finite and not negative [s], got {durations[bad][0]}")
