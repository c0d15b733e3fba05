"""Strokes from rest to rest, stops and fadings of one motion, and falls: the formulas, for compiled functions.

`kernel` computes those of many motions by these functions.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from pnt_gym.compiled import kernel_part
from pnt_gym.constants import GRAVITY

MOST_SHARE: Final = 0.5
"""Largest share of the acceleration limit that the fading of a belt's speed may take."""
USUAL_SPEED: Final = 2.5
"""Release speed [m/s] whose run-up time sets the usual fading time: longer fadings would delay the throws."""


@kernel_part
def is_short(distance: float, velocity: float, acceleration: float, jerk: float) -> bool:
    """Whether a stroke is over before acceleration and speed reach their limits (Algorithm 1, lines 2-3)."""
    return jerk * jerk * distance <= 2.0 * acceleration * acceleration * acceleration and (
        jerk * distance * distance <= 4.0 * velocity * velocity * velocity
    )


@kernel_part
def long_peaks(distance: float, velocity: float, acceleration: float, jerk: float) -> tuple[float, float]:
    """Greatest speed and acceleration of a stroke that is not short, without branches, for vector instructions.

    Lines 4-5 and 8-9 of the algorithm are one case here: a stroke too long for lines 2-3 that never needs a plateau of
    acceleration has V = Vmax, A = sqrt(J Vmax); line 5 is only reached when A = sqrt(J Vmax) is allowed.
    """
    square = acceleration * acceleration
    never_flat = jerk * velocity <= square
    # Line 12, V = (sqrt(A^4 + 4 J^2 P A) - A^2) / (2 J), without the difference of two nearly equal numbers.
    root = math.sqrt(square * square + 4.0 * jerk * jerk * distance * acceleration)
    speed = 2.0 * jerk * distance * acceleration / (square + root)
    speed = speed if speed < velocity else velocity
    peak = math.sqrt(jerk * velocity)
    return (velocity if never_flat else speed), (peak if never_flat else acceleration)


@kernel_part
def peaks(distance: float, velocity: float, acceleration: float, jerk: float) -> tuple[float, float]:
    """Greatest speed V and acceleration A of a stroke (Hassan et al. 2022, Algorithm 1)."""
    if is_short(distance, velocity, acceleration, jerk):
        return np.cbrt(0.25 * jerk * distance * distance), np.cbrt(0.5 * jerk * jerk * distance)
    return long_peaks(distance, velocity, acceleration, jerk)


@kernel_part
def duration(distance: float, speed: float, peak: float, jerk: float) -> float:
    """Time T = P / V + V / A + A / J of a stroke with given greatest speed and acceleration (Eq. 4)."""
    return distance / speed + (speed / peak + peak / jerk)


@kernel_part
def stroke_time(distance: float, velocity: float, acceleration: float, jerk: float) -> float:
    """Minimum time over a distance [s]."""
    speed, peak = peaks(distance, velocity, acceleration, jerk)
    return duration(distance, speed, peak, jerk) if speed > 0.0 else 0.0


@kernel_part
def ramp_times(speed: float, peak: float, jerk: float) -> tuple[float, float]:
    """Durations of each jerk phase and of the plateau between two of them, from rest to a speed."""
    ramp = peak / jerk
    return ramp, 0.0 if peak <= 0.0 else max(speed / peak - ramp, 0.0)


@kernel_part
def stroke_phases(
    distance: float, velocity: float, acceleration: float, jerk: float
) -> tuple[float, float, float, float, float]:
    """Greatest speed and acceleration of a stroke, and durations of its ramps, plateaus and cruise (Eq. 2)."""
    speed, peak = peaks(distance, velocity, acceleration, jerk)
    ramp, plateau = ramp_times(speed, peak, jerk)
    cruise = max(distance / speed - 2.0 * ramp - plateau, 0.0) if speed > 0.0 else 0.0
    return speed, peak, ramp, plateau, cruise


@kernel_part
def greatest_acceleration(speed: float, acceleration: float, jerk: float) -> float:
    """Greatest acceleration on the way between rest and a speed."""
    return min(math.sqrt(jerk * speed), acceleration)


@kernel_part
def stop_phases(speed: float, acceleration: float, jerk: float) -> tuple[float, float]:
    """Durations of each jerk phase and of the plateau of the quickest stop from a speed."""
    return ramp_times(speed, greatest_acceleration(speed, acceleration, jerk), jerk)


@kernel_part
def ramp_distance(speed: float, acceleration: float, jerk: float) -> float:
    """P_S(V) [m], the shortest way between rest and a speed, without acceleration at both ends: the inverse of V_S.

    The way is half the speed times the duration. No branches, for vector instructions.
    """
    short, long = speed * math.sqrt(speed / jerk), 0.5 * speed * (speed / acceleration + acceleration / jerk)
    return short if jerk * speed <= acceleration * acceleration else long


@kernel_part
def least_fading(speed: float, acceleration: float) -> float:
    """Shortest fading of a belt's speed [s]: the peak 2 s / T equals `MOST_SHARE` of the acceleration limit."""
    return 2.0 * speed / (MOST_SHARE * acceleration)


@kernel_part
def fading_time(speed: float, velocity: float, acceleration: float, jerk: float) -> float:
    """Time in which a belt's speed fades from a hand whose speed limit stays as it is [s]; see `riding`."""
    longest = (velocity + speed) / acceleration + acceleration / jerk
    usual = (USUAL_SPEED + speed) / acceleration + acceleration / jerk
    return min(longest, max(usual, least_fading(speed, acceleration)))


@kernel_part
def limits_beside(time: float, speed: float, acceleration: float, jerk: float) -> tuple[float, float]:
    """Acceleration and jerk that a fading of a belt's speed leaves; placeholders where it is not possible."""
    peak, least = 2.0 * speed / time, 1.0 - MOST_SHARE
    return max(acceleration - peak, least * acceleration), max(jerk - 2.0 * peak / time, least * jerk)


@kernel_part
def time_to_fall(drop: float, rise: float) -> float:
    """Time until an object comes down by a height after its release with an upward speed [s] (Eq. 9); NaN for never."""
    square = rise * rise + 2.0 * GRAVITY * drop
    if not square >= 0.0:
        return math.nan
    root = math.sqrt(square)
    # For a downward release the printed sum cancels; the conjugate form does not.
    time = 2.0 * drop / (root - rise) if rise < 0.0 else (rise + root) / GRAVITY
    return time if time >= 0.0 else math.nan
