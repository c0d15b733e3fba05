"""How far a motion stays from each of its limits (Miyashita et al. 2010, Eqs. 15-20 and 27).

Margins come as shares of natural units: N of the block's weight, both moments of the weight times the half length,
the angle of half its range, the speed and the torque of their limits. A margin is positive where its limit is kept.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.constants import GRAVITY
from pnt_gym.planning.one_joint.grasp import loads, torque_limit
from pnt_gym.planning.one_joint.motion import ArmMotion
from pnt_gym.planning.one_joint.parameters import Arm, Block

CHECK_RATE: Final = 1000.0
"""How often a finished motion is checked [Hz]."""
STATIC_ROOM: Final = 0.01
"""Share by which the block on the resting arm stays away from tipping, about half a degree."""


def margin_units(arm: Arm, block: Block) -> Floats:
    """Return the units (6,) of the margins [N, N m, N m, rad, rad/s, N m]; that of M_A is negative, like Delta M_A."""
    weight = block.mass * GRAVITY
    moment = weight * block.half_length
    half = 0.5 * (arm.angle[1] - arm.angle[0])
    return np.array([weight, -moment, moment, half, arm.speed, arm.torque])


def state_margins(
    angle: Floats, speed: Floats, acceleration: Floats, radius: Floats, arm: Arm, block: Block
) -> tuple[Floats, ...]:
    """Return the six margins at states of the arm in the order of Eq. 27, each in the arguments' common shape."""
    units = margin_units(arm, block)
    held, torque = loads(angle, speed, acceleration, radius, arm, block)
    return (
        held.normal / units[0],
        held.moment_a / units[1],
        held.moment_b / units[2],
        np.minimum(angle - arm.angle[0], arm.angle[1] - angle) / units[3],
        1.0 - np.abs(speed) / units[4],
        (torque_limit(speed, arm) - np.abs(torque)) / units[5],
    )


def motion_margins(motion: ArmMotion, radius: Floats, arm: Arm, block: Block, rate: float = CHECK_RATE) -> Floats:
    """Return the smallest margins (N, 6) of each motion from its start to its release.

    Args:
        motion: of the arm, N rows.
        radius: r of the block (N,) [m].
        arm: whose limits count.
        block: what is held.
        rate: how often the motion is looked at [Hz]; the release is always looked at too.
    """
    longest = np.nanmax(motion.duration, initial=0.0)
    every = np.arange(int(np.ceil(longest * rate)) + 1) / rate
    times = np.minimum(every, motion.duration[:, None])
    state = motion.sample(times)
    margins = state_margins(state.angle, state.speed, state.acceleration, radius[:, None], arm, block)
    return np.stack([margin.min(axis=1) for margin in margins], axis=1)
