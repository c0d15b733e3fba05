"""Margins of a motion to each of its limits (Miyashita et al., Eqs. 15-20 and 27).

Margins are shares of natural units: the margin of N of the block's weight, the margins of both moments of weight times
half length, the margin of the angle of half its range, the margins of speed and torque of their limits. A margin is
positive where its limit is kept.
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
"""Rate at which a finished motion is checked [Hz]."""
STATIC_ROOM: Final = 0.01
"""Margin against tipping of the block on the resting arm, as a share; about half a degree."""


def margin_units(arm: Arm, block: Block) -> Floats:
    """Return the units (6,) of the margins [N, N m, N m, rad, rad/s, N m]; M_A's unit is negative, as Delta M_A is."""
    weight = block.mass * GRAVITY
    moment = weight * block.half_length
    half = 0.5 * (arm.angle[1] - arm.angle[0])
    return np.array([weight, -moment, moment, half, arm.speed, arm.torque])


def state_margins(
    angle: Floats, speed: Floats, acceleration: Floats, radius: Floats, arm: Arm, block: Block
) -> tuple[Floats, ...]:
    """Return the six margins at states of the arm in the order of Eq. 27, each in the arguments' common shape."""
    units = margin_units(arm, block)
    reactions, torque = loads(angle, speed, acceleration, radius, arm, block)
    return (
        reactions.normal / units[0],
        reactions.moment_a / units[1],
        reactions.moment_b / units[2],
        np.minimum(angle - arm.angle[0], arm.angle[1] - angle) / units[3],
        1.0 - np.abs(speed) / units[4],
        (torque_limit(speed, arm) - np.abs(torque)) / units[5],
    )


def motion_margins(motion: ArmMotion, radius: Floats, arm: Arm, block: Block, rate: float = CHECK_RATE) -> Floats:
    """Return the smallest margins (N, 6) of each motion from its start to its release.

    Args:
        motion: motion of the arm, N rows.
        radius: r of the block (N,) [m].
        arm: the arm, with its limits.
        block: the block on the arm.
        rate: rate of the check [Hz]; the release is always checked too.
    """
    longest = np.nanmax(motion.duration, initial=0.0)
    every = np.arange(int(np.ceil(longest * rate)) + 1) / rate
    times = np.minimum(every, motion.duration[:, None])
    state = motion.sample(times)
    margins = state_margins(state.angle, state.speed, state.acceleration, radius[:, None], arm, block)
    return np.stack([margin.min(axis=1) for margin in margins], axis=1)
