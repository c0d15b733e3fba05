"""Minimum-time third-order S-curves between two rests (Hassan et al. 2022, Algorithm 1), along a line and in space.

The straight motions of a throw are halves and wholes of S-curves; each half and whole starts and ends with zero
acceleration.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Generic, TypeVar, final, overload

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats, column, finite_points, in_order, numbers, of_kind, rows_of_three
from pnt_gym.errors import PlanningError
from pnt_gym.planning.motion import kernel
from pnt_gym.planning.motion.limits import Limits, MotionLimits, limit_rows
from pnt_gym.planning.motion.rows import Segments

# float for one curve, an (N,) array for a batch.
ValueT = TypeVar("ValueT", float, Floats)


@final
@dataclass(frozen=True, eq=False)
class SCurve(Generic[ValueT]):
    """Minimum-time rest-to-rest motion along a line, one curve or N curves.

    Attributes:
        distance: stroke P [m].
        velocity: peak speed reached V [m/s].
        acceleration: peak acceleration reached A [m/s2].
        jerk: jerk of the outer segments J [m/s3].
        duration: total time T [s] (Eq. 4).
        durations: the seven segment times [s], shape (7,) or (N, 7): dj, da, dj, dv, dj, da, dj (Eq. 2).
    """

    distance: ValueT
    velocity: ValueT
    acceleration: ValueT
    jerk: ValueT
    duration: ValueT
    durations: Floats

    def sample(self, t: ArrayLike) -> tuple[Floats, Floats, Floats]:
        """Return position [m], velocity [m/s] and acceleration [m/s2] at times ``t`` [s].

        One curve: the results have the shape of ``t``. N curves: ``t`` of shape () gives (N,); (M,) gives (N,
        M) with every curve read at the same times; (N, M) gives (N, M). The curve rests before 0, after T.
        """
        time, durations = numbers(t, "t"), self.durations
        columns = [self.distance, self.velocity, self.acceleration, self.jerk, self.duration]
        arrays = [np.asarray(c, dtype=np.float64) for c in columns]
        if np.ndim(self.distance) == 1 and time.ndim > 0:
            count = arrays[0].shape[0]
            if time.ndim > 2 or (time.ndim == 2 and time.shape[0] != count):
                raise PlanningError(f"times must have shape (), (M,) or ({count}, M), got {time.shape}")
            arrays, durations = [a[:, None] for a in arrays], durations[:, None]
        time = np.broadcast_to(time, np.broadcast_shapes(arrays[0].shape, time.shape))
        curve = SCurve[Floats](*arrays, durations=durations)
        # Mirror the second half onto the first: the curve is symmetric, so both ends come out exact.
        second_half = time > 0.5 * curve.duration
        folded = np.maximum(np.where(second_half, curve.duration - time, time), 0.0)
        position, speed, acceleration = _first_half(curve, folded)
        position = np.where(second_half, curve.distance - position, position)
        return position, speed, np.where(second_half, -acceleration, acceleration)


def _first_half(curve: SCurve[Floats], time: Floats) -> tuple[Floats, Floats, Floats]:
    """Position, speed and acceleration at 0 <= time <= T/2, summed over the elapsed parts of the four segments."""
    jerk, peak = curve.jerk, curve.acceleration
    ramp, plateau = curve.durations[..., 0], curve.durations[..., 1]
    # Time that has elapsed in each segment: jerk up, plateau, jerk down, cruise.
    rise = np.minimum(time, ramp)
    flat = np.clip(time - ramp, 0.0, plateau)
    fall = np.clip(time - ramp - plateau, 0.0, ramp)
    cruise = np.maximum(time - 2.0 * ramp - plateau, 0.0)
    # Speeds at the ends of the first two segments.
    after_rise = 0.5 * jerk * ramp * ramp
    after_flat = after_rise + peak * plateau
    speed = 0.5 * jerk * rise * rise + peak * flat + fall * (peak - 0.5 * jerk * fall)
    position = (
        jerk * rise * rise * rise / 6.0
        + flat * (after_rise + 0.5 * peak * flat)
        + fall * (after_flat + fall * (0.5 * peak - jerk * fall / 6.0))
        + curve.velocity * cruise
    )
    return position, speed, jerk * (rise - fall)


@overload
def min_time_scurve(distance: float, limits: MotionLimits) -> SCurve[float]: ...
@overload
def min_time_scurve(distance: Floats, limits: MotionLimits) -> SCurve[Floats]: ...
def min_time_scurve(distance: float | Floats, limits: MotionLimits) -> SCurve[float] | SCurve[Floats]:
    """Return the minimum-time S-curve over ``distance`` (Hassan et al. 2022, Algorithm 1).

    Args:
        distance: stroke P >= 0 [m], one number or (N,).
        limits: largest speed, acceleration and jerk; limits given per throw make the result an (N,) batch.

    Raises:
        ValueError: if a distance is negative, NaN or infinite, or the batch sizes differ.
    """
    stroke, limits = numbers(distance, "distance"), of_kind(limits, MotionLimits, "limits")
    if stroke.ndim > 1:
        raise PlanningError(f"distance must be one number or have shape (N,), got shape {stroke.shape}")
    single = stroke.ndim == 0 and limits.count is None
    count = limits.count or 1 if stroke.ndim == 0 else stroke.shape[0]
    rows, way = limits.arrays(count), _distances(np.ascontiguousarray(np.broadcast_to(stroke, (count,))))
    strokes: Any = kernel.strokes(way, rows).view(np.recarray)
    ramp, plateau = strokes.ramp, strokes.plateau
    durations = np.stack([ramp, plateau, ramp, strokes.cruise, ramp, plateau, ramp], axis=-1)
    columns = way, strokes.speed, strokes.acceleration, rows.jerk, strokes.time
    if not single:
        return SCurve[Floats](*columns, durations)
    return SCurve[float](*(float(column[0]) for column in columns), durations=durations[0])


@overload
def speed_at(distance: float, limits: MotionLimits) -> float: ...
@overload
def speed_at(distance: Floats, limits: MotionLimits) -> Floats: ...
def speed_at(distance: float | Floats, limits: MotionLimits) -> float | Floats:
    """Return V_S(p), the speed [m/s] at ``distance`` p when the stroke is 2p (mid-stroke release, III-D).

    Raises:
        ValueError: as ``min_time_scurve``.
    """
    return min_time_scurve(2.0 * numbers(distance, "distance"), limits).velocity


def rest_to_rest(displacement: ArrayLike, limits: Limits) -> Segments:
    """Return the minimum-time move along ``displacement`` (N, 3) [m], seven segments."""
    way = finite_points(displacement, "displacement")
    return kernel.rest_to_rest(*in_order(way), limit_rows(limits, len(way)))


def accelerate(direction: ArrayLike, distance: ArrayLike, limits: Limits) -> Segments:
    """Return the first half of a stroke of 2 x ``distance`` (N,) [m]: four segments up to V_S(distance).

    This is the throw motion up to the release (section III-D): jerk up, plateau, jerk down, half the cruise.
    """
    way = _distances(distance)
    unit = rows_of_three(direction, "direction", len(way))
    return kernel.accelerate(*in_order(unit, way), limit_rows(limits, len(way)))


def coast(duration: ArrayLike) -> Segments:
    """Return one segment (N,) [s] without jerk: constant velocity after a block, a wait at rest."""
    times = column(duration, "duration")
    return Segments(times[:, None], np.zeros((len(times), 1, 3)))


def brake(direction: ArrayLike, speed: ArrayLike, limits: Limits) -> Segments:
    """Return the minimum-time stop from ``speed`` (N,) [m/s] along ``direction`` (N, 3): three segments."""
    start = _speeds(speed)
    unit = rows_of_three(direction, "direction", len(start))
    return kernel.brake(*in_order(unit, start), limit_rows(limits, len(start)))


def brake_distance(speed: ArrayLike, limits: Limits) -> Floats:
    """Return the distance (N,) [m] of the minimum-time stop from ``speed`` (N,) [m/s]: half speed times duration."""
    start = _speeds(speed)
    return kernel.brake_distance(start, limit_rows(limits, len(start)))


def _distances(distance: ArrayLike) -> Floats:
    """Distances (N,) [m], of which each is finite and none negative."""
    (way,) = in_order(column(distance, "distance"))
    good = np.isfinite(way) & (way >= 0.0)
    if not good.all():
        raise PlanningError(f"distance must be finite and not negative [m], got {way[~good][0]}")
    return way


def _speeds(speed: ArrayLike) -> Floats:
    """Speeds (N,) [m/s], of which none is negative; NaN stays NaN."""
    (start,) = in_order(column(speed, "speed"))
    if (start < 0.0).any():
        raise PlanningError(f"speed must not be negative [m/s], got {np.nanmin(start)}")
    return start
