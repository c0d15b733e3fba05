"""Compiled loads of motors: largest torque and positive work, one row each; a NaN stays one."""

from __future__ import annotations

from pnt_gym.arrays import Floats, Ints
from pnt_gym.compiled import compile_for, kernel_part


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
