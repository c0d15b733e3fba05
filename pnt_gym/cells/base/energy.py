"""What motors spend on a cycle: their positive mechanical work, torque times joint speed.

Each motor counts for itself, and what it brakes it gives nothing back (no recuperation, no common link between the
drives). Heat in the windings, friction in the gears and what holding still takes are not in it: a datasheet has those.
"""

from __future__ import annotations

import numpy as np

from pnt_gym.arrays import Floats, Ints


def work_of_steps(torque: Floats, speed: Floats, steps: Ints, step: float) -> Floats:
    """Positive work in simulated steps (N,) [J].

    Args:
        torque: of each motor in each step (N, M, J) [N m].
        speed: of its joint after the step (N, M, J) [rad/s]. The engine's steps are a leapfrog: the torque acts from
            the middle of the step before to the middle of its own, to which the two speeds belong.
        steps: of each simulation that count (N,).
        step: length of one [s].
    """
    counts = np.arange(torque.shape[1], dtype=np.int64) < steps[:, None]
    before = np.concatenate([speed[:, :1], speed[:, :-1]], axis=1)
    power = np.maximum(torque * ((before + speed) / 2.0), 0.0).sum(axis=-1)
    return _total(np.where(counts, power, 0.0) * step)


def work_between(torque: Floats, speed: Floats, times: Floats) -> Floats:
    """Positive work of a planned motion (N,) [J], from torque and speed (N, K, J) at times (N, K) [s] that grow."""
    power = np.maximum(torque * speed, 0.0).sum(axis=-1)
    return _total((power[:, 1:] + power[:, :-1]) / 2.0 * np.diff(times, axis=1))


def _total(parts: Floats) -> Floats:
    """Sums (N,) of parts (N, M) from left to right, so that zeros at the end change no bit."""
    return np.cumsum(parts, axis=1)[:, -1] if parts.shape[1] > 0 else np.zeros(len(parts))
