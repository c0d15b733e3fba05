"""Paths of piecewise constant jerk in space, N at a time, which plans hand to robots."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol, final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats, concatenate_records, length
from pnt_gym.errors import PlanningError
from pnt_gym.planning.motion.limits import Limits


@final
@dataclass(frozen=True, eq=False)
class Segments:
    """Consecutive pieces of constant jerk.

    Attributes:
        durations: (N, K) [s].
        jerks: (N, K, 3) [m/s3].
    """

    durations: Floats
    jerks: Floats

    def pad(self, columns: int) -> Segments:
        """Return the same motions, filled up to ``columns`` segments with segments of no duration."""
        rows, count = self.durations.shape
        durations, jerks = np.zeros((rows, columns)), np.zeros((rows, columns, 3))
        durations[:, :count], jerks[:, :count] = self.durations, self.jerks
        return Segments(durations, jerks)

    def greatest_acceleration(self) -> Floats:
        """Return the greatest acceleration (N,) [m/s2] of motions that start without acceleration."""
        return length(np.cumsum(self.durations[..., None] * self.jerks, axis=1)).max(axis=1)


def superpose(first: Segments, second: Segments) -> Segments:
    """Return the sums of two motions that begin together; a motion that is over goes on without jerk.

    Each sum has the borders of both motions, so ``first`` and ``second`` of K and L segments give K + L segments.
    """
    end_times = [np.cumsum(part.durations, axis=1) for part in (first, second)]
    borders = np.sort(np.concatenate(end_times, axis=1), axis=1)
    durations = np.diff(borders, axis=1, prepend=0.0)
    middle = borders - 0.5 * durations
    jerks = np.zeros((*borders.shape, 3))
    for ends, part in zip(end_times, (first, second), strict=True):
        segments = part.pad(part.durations.shape[1] + 1)
        index = (middle[:, :, None] > ends[:, None, :]).sum(axis=2)
        jerks += np.take_along_axis(segments.jerks, index[:, :, None], axis=1)
    return Segments(durations, jerks)


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
    _table: Floats = field(init=False, repr=False)

    def __post_init__(self) -> None:
        _check_shapes(self.start, self.durations, self.jerks)
        zero = np.zeros_like(self.start)
        velocity = zero if self.start_velocity is None else self.start_velocity
        acceleration = zero if self.start_acceleration is None else self.start_acceleration
        times = np.concatenate([zero[:, :1], np.cumsum(self.durations, axis=1)], axis=1)
        knots = _integrate(Samples(self.start, velocity, acceleration), self.durations, self.jerks)
        object.__setattr__(self, "start_velocity", velocity)
        object.__setattr__(self, "start_acceleration", acceleration)
        object.__setattr__(self, "knot_times", times)
        object.__setattr__(self, "knots", knots)
        object.__setattr__(self, "_table", _coefficients(times, knots, self.jerks, self.rides))

    @classmethod
    def concatenate(
        cls,
        start: Floats,
        parts: Sequence[Segments],
        start_velocity: Floats | None = None,
        rides: bool = False,
    ) -> JerkTrajectory:
        """Return the paths that start at ``start`` (N, 3) and run through ``parts`` in turn."""
        whole = concatenate_records(parts, axis=1)
        return cls(start, whole.durations, whole.jerks, start_velocity, rides=rides)

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
        from pnt_gym.planning.motion.sampling import sample  # noqa: PLC0415 - numba takes a while

        time = self._times(times)
        position, velocity, acceleration = np.empty((3, *time.shape, 3))
        sample(self._table, time, position, velocity, acceleration)
        return Samples(position, velocity, acceleration)

    def jerk(self, times: ArrayLike) -> Floats:
        """Return the jerk at ``times`` [s], shape (M,) or (N, M), result (N, M, 3) [m/s3]; zero outside."""
        from pnt_gym.planning.motion.sampling import JERK, rows_at  # noqa: PLC0415 - numba takes a while

        time = self._times(times)
        rows = np.empty(time.shape, dtype=np.int64)
        rows_at(self._table, time, rows)
        return np.take_along_axis(self._table[..., JERK : JERK + 3], rows[..., None], axis=1)

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
        """Times of all paths (N, M) as a new array."""
        time, count = np.asarray(times, dtype=np.float64), len(self._table)
        if time.ndim not in (1, 2) or (time.ndim == 2 and time.shape[0] != count):
            raise PlanningError(f"times must have shape (M,) or ({count}, M), got {time.shape}")
        return np.array(np.broadcast_to(time, (count, time.shape[-1])), order="C")


def _check_shapes(start: Floats, durations: Floats, jerks: Floats) -> None:
    count = start.shape[0]
    if start.ndim != 2 or start.shape[1] != 3:
        raise PlanningError(f"start must have shape (N, 3), got {start.shape}")
    if durations.ndim != 2 or durations.shape[0] != count or durations.shape[1] == 0:
        raise PlanningError(f"durations must have shape ({count}, K) with K >= 1, got {durations.shape}")
    if jerks.shape != (*durations.shape, 3):
        raise PlanningError(f"jerks must have shape {(*durations.shape, 3)}, got {jerks.shape}")
    if not (np.isfinite(start).all() and np.isfinite(jerks).all()):
        raise PlanningError("start and jerks must be finite; leave infeasible plans out of a trajectory")
    bad = ~(np.isfinite(durations) & (durations >= 0.0))
    if bad.any():
        raise PlanningError(f"durations must be finite and not negative [s], got {durations[bad][0]}")


def _integrate(first: Samples, durations: Floats, jerks: Floats) -> Samples:
    """States at all borders, each (N, K + 1, 3), as sums of the segments' increments."""
    d = durations[:, :, None]
    acceleration = _running_sum(first.acceleration, d * jerks)
    velocity = _running_sum(first.velocity, d * (acceleration[:, :-1] + 0.5 * d * jerks))
    cubic = acceleration[:, :-1] + d * jerks / 3.0
    position = _running_sum(first.position, d * (velocity[:, :-1] + 0.5 * d * cubic))
    return Samples(position, velocity, acceleration)


def _running_sum(first: Floats, increments: Floats) -> Floats:
    return np.cumsum(np.concatenate([first[:, None], increments], axis=1), axis=1)


def _coefficients(times: Floats, knots: Samples, jerks: Floats, rides: bool) -> Floats:
    """Table (N, K + 2, 13): position, velocity, acceleration, jerk, start time; at both ends rest or constant speed."""
    count, borders = times.shape
    table = np.zeros((count, borders + 1, 13))
    table[:, 0, 0:3] = knots.position[:, 0]
    table[:, 1:, 0:3] = knots.position
    table[:, 1:-1, 3:6] = knots.velocity[:, :-1]
    table[:, 1:-1, 6:9] = knots.acceleration[:, :-1]
    table[:, 1:-1, 9:12] = jerks
    table[:, 1:, 12] = times
    if rides:
        table[:, [0, -1], 3:6] = knots.velocity[:, [0, -1]]
    return table
