"""Strokes from rest to rest and stops of one motion, for compiled functions; `scurve` has the same for many motions.

Operation by operation as `scurve`, except for cube roots: NumPy rounds these in its own way, the C library in another.
A function that needs NumPy's bits gets the roots handed in.
"""

from __future__ import annotations

import math

import numpy as np

from pnt_gym.compiled import kernel_part


@kernel_part
def is_short(distance: float, velocity: float, acceleration: float, jerk: float) -> bool:
    """Whether a stroke is over before acceleration and speed reach their limits."""
    return jerk * jerk * distance <= 2.0 * acceleration * acceleration * acceleration and (
        jerk * distance * distance <= 4.0 * velocity * velocity * velocity
    )


@kernel_part
def long_peaks(distance: float, velocity: float, acceleration: float, jerk: float) -> tuple[float, float]:
    """Greatest speed and acceleration of a stroke that is not short, as `scurve.peaks`."""
    square = acceleration * acceleration
    if jerk * velocity <= square:
        return velocity, math.sqrt(jerk * velocity)
    root = math.sqrt(square * square + 4.0 * jerk * jerk * distance * acceleration)
    return min(2.0 * jerk * distance * acceleration / (square + root), velocity), acceleration


@kernel_part
def stroke_time(distance: float, velocity: float, acceleration: float, jerk: float) -> float:
    """Minimum time over a distance, as `scurve.stroke_time` but for the cube roots of the C library."""
    if is_short(distance, velocity, acceleration, jerk):
        speed, peak = np.cbrt(0.25 * jerk * distance * distance), np.cbrt(0.5 * jerk * jerk * distance)
    else:
        speed, peak = long_peaks(distance, velocity, acceleration, jerk)
    if not speed > 0.0:
        return 0.0
    return distance / speed + (speed / peak + peak / jerk)


@kernel_part
def ramp_times(velocity: float, acceleration: float, jerk: float) -> tuple[float, float]:
    """Durations of each jerk phase and of the plateau between two of them, as `scurve._ramp_times`."""
    ramp = acceleration / jerk
    return ramp, 0.0 if acceleration <= 0.0 else max(velocity / acceleration - ramp, 0.0)


@kernel_part
def stop_times(speed: float, acceleration: float, jerk: float) -> tuple[float, float]:
    """Durations of each jerk phase and of the plateau of the quickest stop from a speed."""
    return ramp_times(speed, min(math.sqrt(jerk * speed), acceleration), jerk)


@kernel_part
def brake_distance(speed: float, acceleration: float, jerk: float) -> float:
    """Way of the quickest stop [m], as `scurve.brake_distance`."""
    ramp, plateau = stop_times(speed, acceleration, jerk)
    return 0.5 * speed * (2.0 * ramp + plateau)
