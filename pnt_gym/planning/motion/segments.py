"""Building blocks of a throw: pieces of straight-line motion to join with ``JerkTrajectory.concatenate``.

Every block is minimum-time (Hassan et al. 2022, Algorithm 1) and starts and ends with zero acceleration.
"""

from __future__ import annotations

import numpy as np

from pnt_gym.arrays import Floats, length
from pnt_gym.errors import PlanningError
from pnt_gym.planning.motion.limits import LimitRows, Limits
from pnt_gym.planning.motion.scurve import scurves
from pnt_gym.planning.motion.trajectory import Segments

_REST_TO_REST = np.array([1.0, 0.0, -1.0, 0.0, -1.0, 0.0, 1.0])


def line_segments(direction: Floats, durations: Floats, jerks: Floats) -> Segments:
    """Return segments along unit vectors ``direction`` (N, 3) with signed jerks (N, K) [m/s3]."""
    return Segments(durations, jerks[:, :, None] * direction[:, None, :])


def rest_to_rest(displacement: Floats, limits: Limits) -> Segments:
    """Return the minimum-time move along ``displacement`` (N, 3) [m], seven segments."""
    distance = length(displacement)
    curve = scurves(distance, limits.arrays(len(distance)))
    direction = displacement / np.where(distance > 0.0, distance, 1.0)[:, None]
    return line_segments(direction, curve.durations, curve.jerk[:, None] * _REST_TO_REST)


def accelerate(direction: Floats, distance: Floats, limits: Limits) -> Segments:
    """Return the first half of a stroke of 2 x ``distance`` (N,) [m]: four segments up to V_S(distance).

    This is the throw motion up to the release (section III-D): jerk up, plateau, jerk down, half the cruise.
    """
    curve = scurves(2.0 * distance, limits.arrays(len(distance)))
    durations = curve.durations[:, :4] * np.array([1.0, 1.0, 1.0, 0.5])
    return line_segments(direction, durations, curve.jerk[:, None] * _REST_TO_REST[:4])


def coast(duration: Floats) -> Segments:
    """Return one segment (N,) [s] without jerk: constant velocity after a block, a wait at rest."""
    return Segments(duration[:, None], np.zeros((duration.shape[0], 1, 3)))


def brake(direction: Floats, speed: Floats, limits: Limits) -> Segments:
    """Return the quickest stop from ``speed`` (N,) [m/s] along ``direction`` (N, 3): three segments."""
    _check(speed)
    rows = limits.arrays(len(speed))
    ramp, plateau = _stop_times(speed, rows)
    durations = np.stack([ramp, plateau, ramp], axis=1)
    return line_segments(direction, durations, rows.jerk[:, None] * _REST_TO_REST[4:])


def brake_distance(speed: Floats, limits: Limits) -> Floats:
    """Return the way (N,) [m] of the quickest stop from ``speed`` (N,) [m/s]: half speed times duration."""
    _check(speed)
    return stop_distance(speed, limits.arrays(len(speed)))


def stop_distance(speed: Floats, limits: LimitRows) -> Floats:
    """Return the way (N,) [m] as `brake_distance`, without a look at the speeds."""
    ramp, plateau = _stop_times(speed, limits)
    return 0.5 * speed * (2.0 * ramp + plateau)


def _stop_times(speed: Floats, limits: LimitRows) -> tuple[Floats, Floats]:
    """Durations of a jerk phase and of the plateau between the two (N,) [s]."""
    peak = np.minimum(np.sqrt(limits.jerk * speed), limits.acceleration)
    ramp = peak / limits.jerk
    plateau = np.where(peak > 0.0, speed / np.where(peak > 0.0, peak, 1.0) - ramp, 0.0)
    return ramp, np.maximum(plateau, 0.0)


def _check(speed: Floats) -> None:
    bad = ~(np.isfinite(speed) & (speed >= 0.0))
    if bad.any():
        raise PlanningError(f"speed must be finite and not negative [m/s], got {speed[bad][0]}")
