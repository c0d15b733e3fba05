"""Compiled loads along motions: those of motors, where a NaN stays one, and those of suction cups; one row each."""

from __future__ import annotations

import math

from pnt_gym.arrays import Floats, Ints
from pnt_gym.compiled import compile_for, kernel_part
from pnt_gym.constants import GRAVITY

# Smallest load in a quotient [N]; the load is negative where the hand falls faster than the object.
LIGHTEST = 1e-9
# Rows of `holds` (6, N), as the fields of `grip.Hold`.
FORCE, MASS, FRICTION, DEPTH, OFFSET, RADIUS = range(6)


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


@compile_for("void(f8[:, :, :], f8[:, :, :], i8[:], f8, f8[::1], f8[::1])")
def fill_loads_of_steps(torque: Floats, speed: Floats, steps: Ints, step: float, largest: Floats, work: Floats) -> None:
    """Write largest torques and works (N,) as `energy.loads_of_steps`."""
    for row in range(len(work)):
        largest[row] = work[row] = 0.0
        for k in range(min(steps[row], torque.shape[1])):
            largest[row] = _larger(largest[row], torque[row, k])
            work[row] += _power(torque[row, k], speed[row, max(k - 1, 0)], speed[row, k]) * step


@compile_for("void(f8[:, :, :], f8[:, :, :], f8[:, :], f8[::1], f8[::1])")
def fill_loads_between(torque: Floats, speed: Floats, times: Floats, largest: Floats, work: Floats) -> None:
    """Write largest torques and works (N,) as `energy.loads_between`."""
    for row in range(len(work)):
        largest[row] = work[row] = before = 0.0
        for k in range(torque.shape[1]):
            largest[row] = _larger(largest[row], torque[row, k])
            power = _power(torque[row, k], speed[row, k], speed[row, k])
            if k > 0:
                # Trapezoidal rule over power.
                work[row] += (power + before) / 2.0 * (times[row, k] - times[row, k - 1])
            before = power


@kernel_part
def _load(holds: Floats, row: int, acceleration: Floats) -> float:
    """Holding force that the vacuum needs against slip and peel under an acceleration (3,) of the hand [N]."""
    mass, radius = holds[MASS, row], holds[RADIUS, row]
    x, y = acceleration[0], acceleration[1]
    sideways = mass * math.sqrt(x * x + y * y)
    down = mass * (GRAVITY + acceleration[2])
    slip = down + sideways / holds[FRICTION, row]
    peel = sideways * holds[DEPTH, row] / radius + down * (holds[OFFSET, row] / radius + 1.0)
    return max(slip, peel, LIGHTEST)


@compile_for("void(f8[:, ::1], f8[:, :, ::1], i8[::1], f8, f8[::1], i8[::1])")
def find_smallest_margins(
    holds: Floats, accelerations: Floats, counts: Ints, scale: float, margin: Floats, lost_at: Ints
) -> None:
    """Find the smallest margins of N holds, and where a margin is below 1 for the first time.

    Args:
        holds: the holds (6, N), by the rows above.
        accelerations: accelerations of the hands (N, K, 3) [m/s2].
        counts: numbers of accelerations that count, from the first (N,).
        scale: factor of the load.
        margin: overwritten by the smallest margins, inf where no acceleration counts (N,).
        lost_at: overwritten by the first acceleration whose margin is below 1, -1 for none (N,).
    """
    for row in range(len(accelerations)):
        margin[row], lost_at[row] = math.inf, -1
        for k in range(counts[row]):
            value = holds[FORCE, row] / _load(holds, row, accelerations[row, k]) / scale
            margin[row] = min(margin[row], value)
            if value < 1.0 and lost_at[row] < 0:
                lost_at[row] = k
