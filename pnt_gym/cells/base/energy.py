"""Energy of the motors in a cycle: their positive mechanical work, torque times joint speed.

Each motor counts separately, and a braking motor returns nothing (no recuperation, no common link between the drives).
Heat in the windings, friction in the gears and holding torque at rest are left out: datasheets give those losses.
"""

from __future__ import annotations

import numpy as np

from pnt_gym.arrays import Floats, Ints, in_order
from pnt_gym.cells.base import load_kernel


def loads_of_steps(torque: Floats, speed: Floats, steps: Ints, step: float) -> tuple[Floats, Floats]:
    """Largest torques (N,) [N m] and positive works (N,) [J] in simulated steps.

    Args:
        torque: of each motor in each step (N, M, J) [N m].
        speed: of the motor's joint after the step (N, M, J) [rad/s]. The engine's steps are a leapfrog: a torque acts
            from the middle of the step before to the middle of its step, and the two speeds belong to those moments.
        steps: number of steps that count, for each simulation (N,).
        step: length of a step [s].
    """
    largest, work = np.empty(len(torque)), np.empty(len(torque))
    load_kernel.fill_loads_of_steps(*in_order(torque, speed, steps), step, largest, work)
    return largest, work


def loads_between(torque: Floats, speed: Floats, times: Floats) -> tuple[Floats, Floats]:
    """Largest torques (N,) [N m] and positive works (N,) [J] of planned motions.

    Args:
        torque: of each motor at each moment (N, K, J) [N m].
        speed: of the motor's joint (N, K, J) [rad/s].
        times: the moments, which increase (N, K) [s].
    """
    largest, work = np.empty(len(torque)), np.empty(len(torque))
    load_kernel.fill_loads_between(*in_order(torque, speed, times), largest, work)
    return largest, work
