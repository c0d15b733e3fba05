"""Suction: how much later than commanded the cup lets go."""

from __future__ import annotations

import numpy as np

from pnt_gym.config import Suction
from pnt_gym.planning.arrays import Floats
from pnt_gym.planning.ballistics import GRAVITY


def release_delay(seal: Floats, mass: Floats, suction: Suction) -> Floats:
    """Mean delay between the valve command and the moment the object is free [s].

    The vacuum decays exponentially and holds until its force drops below the weight. A porous seal (low F0) vents
    through its leak too, which shortens the time constant.

    Args:
        seal: vacuum force before the release F0 [N], any shape.
        mass: mass of the object [kg], same shape.
        suction: valve delay, time constant and leak.

    Returns:
        valve + tau_e ln(F0 / (m g)) [s], never below 0.
    """
    leak = np.where(seal < suction.leak_reference, suction.leak_reference / seal - 1.0, 0.0)
    tau = suction.tau / (1.0 + suction.leak * leak)
    return np.maximum(suction.valve + tau * np.log(seal / (mass * GRAVITY)), 0.0)
