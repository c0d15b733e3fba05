"""Energy of the motors in a cycle: their positive mechanical work, torque times joint speed.

Each motor counts separately, and a braking motor returns nothing (no recuperation, no common link between the drives).
Heat in the windings, friction in the gears and holding torque at rest are left out: datasheets give those losses.
"""

from __future__ import annotations

import numpy as np

from pnt_gym.arrays import Floats, Ints


def work_of_steps(torque: Floats, speed: Floats, steps: Ints, step: float) -> Floats:
    """Positive work in simulated steps (N,) [J].

    Args:
        torque: of each motor in each step (N, M, J) [N m].
        speed: of the motor's joint after the step (N, M, J) [rad/s]. The engine's steps are a leapfrog: a torque acts
            from the middle of the step before to the middle of its step, and the two speeds belong to those moments.
        steps: number of steps that count, for each simulation (N,).
        step: length of a step [s].
    """
    counts = np.arange(torque.shape[1], dtype=np.int64) < steps[:, None]
    before = np.concatenate([speed[:, :1], speed[:, :-1]], axis=1)
    power = np.maximum(torque * ((before + speed) / 2.0), 0.0).sum(axis=-1)
    return _total(np.where(counts, power, 0.0) * step)


def work_between(torque: Floats, speed: Floats, times: Floats) -> Floats:
    """Positive work of planned motions (N,) [J], from torque and speed (N, K, J) at increasing times (N, K) [s]."""
    # Trapezoidal rule over power.
    power = np.maximum(torque * speed, 0.0).sum(axis=-1)
    return _total((power[:, 1:] + power[:, :-1]) / 2.0 * np.diff(times, axis=1))


def _total(parts: Floats) -> Floats:
    """Sums (N,) of parts (N, M) from left to right, so that zeros at the end change no bit."""
    return np.cumsum(parts, axis=1)[:, -1] if parts.shape[1] > 0 else np.zeros(len(parts))
