"""Compiled loads along motions: torques and energy of motors, where a NaN stays one, and the holding of suction cups.

The energy of the motors in a cycle is their positive mechanical work, torque times joint speed. Each motor counts
separately, and a braking motor returns nothing (no recuperation, no common link between the drives). Heat in the
windings, friction in the gears and holding torque at rest are left out: datasheets give those losses.
"""

from __future__ import annotations

import math

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.grip import Hold
from pnt_gym.compiled import kernel, kernel_part
from pnt_gym.constants import GRAVITY
from pnt_gym.rows import Floats1, Floats2, Floats3, Ints1

# Smallest load in a quotient [N]; the load is negative where the hand falls faster than the object.
LIGHTEST = 1e-9


@kernel_part
def _larger(largest: float, torques: Floats) -> float:
    """The largest torque so far and in a moment (J,) [N m]."""
    for torque in torques:
        if abs(torque) > largest or torque != torque:  # noqa: PLR0124 - a NaN
            largest = abs(torque)
    return largest


@kernel_part
def _power(torques: Floats, first: Floats, second: Floats) -> float:
    """Positive power [W] of motors (J,) at the mean of two speeds."""
    total = 0.0
    for motor in range(len(torques)):
        power = torques[motor] * ((first[motor] + second[motor]) / 2.0)
        if not power <= 0.0:
            total += power
    return total


@kernel
def loads_of_steps(torque: Floats3, speed: Floats3, steps: Ints1, step: float) -> tuple[Floats1, Floats1]:
    """Largest torques (N,) [N m] and positive works (N,) [J] in simulated steps.

    Args:
        torque: of each motor in each step (N, M, J) [N m].
        speed: of the motor's joint after the step (N, M, J) [rad/s]. The engine's steps are a leapfrog: a torque acts
            from the middle of the step before to the middle of its step, and the two speeds belong to those moments.
        steps: number of steps that count, for each simulation (N,).
        step: length of a step [s].
    """
    largest, work = np.empty(len(torque)), np.empty(len(torque))
    for row in range(len(work)):
        largest[row] = work[row] = 0.0
        for k in range(min(steps[row], torque.shape[1])):
            largest[row] = _larger(largest[row], torque[row, k])
            work[row] += _power(torque[row, k], speed[row, max(k - 1, 0)], speed[row, k]) * step
    return largest, work


@kernel
def loads_between(torque: Floats3, speed: Floats3, times: Floats2) -> tuple[Floats1, Floats1]:
    """Largest torques (N,) [N m] and positive works (N,) [J] of planned motions.

    Args:
        torque: of each motor at each moment (N, K, J) [N m].
        speed: of the motor's joint (N, K, J) [rad/s].
        times: the moments, which increase (N, K) [s].
    """
    largest, work = np.empty(len(torque)), np.empty(len(torque))
    for row in range(len(work)):
        largest[row] = work[row] = before = 0.0
        for k in range(torque.shape[1]):
            largest[row] = _larger(largest[row], torque[row, k])
            power = _power(torque[row, k], speed[row, k], speed[row, k])
            if k > 0:
                # Trapezoidal rule over power.
                work[row] += (power + before) / 2.0 * (times[row, k] - times[row, k - 1])
            before = power
    return largest, work


@kernel_part
def _load(hold: Hold, row: int, acceleration: Floats) -> float:
    """Holding force that the vacuum needs against slip and peel under an acceleration (3,) of the hand [N]."""
    mass, radius = hold.mass[row], hold.radius[row]
    x, y = acceleration[0], acceleration[1]
    sideways = mass * math.sqrt(x * x + y * y)
    down = mass * (GRAVITY + acceleration[2])
    slip = down + sideways / hold.friction[row]
    peel = sideways * hold.depth[row] / radius + down * (hold.offset[row] / radius + 1.0)
    return max(slip, peel, LIGHTEST)


@kernel
def smallest_margin(hold: Hold, accelerations: Floats3, counts: Ints1, scale: float) -> tuple[Floats1, Ints1]:
    """Smallest margins of N holds (N,), and where each is below 1 first (N,), as `Hold.smallest_margin` says."""
    margin, lost_at = np.empty(len(counts)), np.empty(len(counts), dtype=np.int64)
    for row in range(len(accelerations)):
        margin[row], lost_at[row] = math.inf, -1
        for k in range(counts[row]):
            value = hold.force[row] / _load(hold, row, accelerations[row, k]) / scale
            margin[row] = min(margin[row], value)
            if value < 1.0 and lost_at[row] < 0:
                lost_at[row] = k
    return margin, lost_at
