"""Swing of N objects under compliant cups: the lip as a spring, and the swing along the planned path of the hand."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final, NamedTuple, final

import numpy as np

from pnt_gym.arrays import Floats, Ints
from pnt_gym.cells.base import freefall
from pnt_gym.cells.base.airborne import STATE, Carrying, Hanging, Pivot
from pnt_gym.cells.base.bodies import up_axis
from pnt_gym.cells.base.parallel import write_in_parts
from pnt_gym.cells.conveyor.config import LIP_LENGTH, ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.cup.clearance import Bodies, components, extent_along
from pnt_gym.cells.conveyor.cup.hold import Parting
from pnt_gym.compiled import kernel, kernel_part
from pnt_gym.planning.motion.trajectory import Samples
from pnt_gym.rows import Bools1, Floats1, Floats2, Floats3, Ints1

LARGEST_PHASE: Final = 0.5
"""Largest phase of a swing in a step [rad]; the stiffness of a lip is limited to that of this phase.

Then h^2 k + 2 h c < 1.4 about each axis; the steps are stable below 4, which coupling of the axes by an object's offset
brings down to 4 / 3 at the utmost, and not near it."""
TWIST_RATIO: Final = 0.5
"""Damping ratio about the vertical axis, about which the lip is stiff."""
CONTACT_DEPTH: Final = 0.001
"""Depth in the belt beyond which an object under its cup has touched the belt [m]."""
TILT_COSINE = 0.5
"""Cosine of the tilt beyond which an object under its cup is simulated by the engine."""


@final
class Swing(NamedTuple):
    """A swing of N objects under their hands."""

    attitude: Floats3
    """Attitudes in the axes in which the objects hang at rest, every `stride` steps (N, L, 4)."""
    hand: Floats3
    """Positions of the tips at every step (N, K, 3) [m]."""
    steps: Ints1
    """Numbers of steps until the objects' release (N,); later attitudes are those of the release."""
    stride: int
    """Steps between two attitudes."""


@final
class Spring(NamedTuple):
    """Lips of N cups as springs about three axes of the hand: the object's two horizontal axes, and the vertical."""

    stiffness: Floats
    """Stiffness about each axis (N, 3) [N m/rad]."""
    damping: Floats
    """Damping about each axis (N, 3) [N m s/rad]."""


def springs(context: Context, config: ConveyorConfig) -> Spring:
    """The lips as springs for Euler's steps.

    At any step length the swing has the frequency and decay of the lip's stiffness and damping ratio. A step
    x' = x + h v', v' = v - h (k x + c v) has the eigenvalues exp(-zeta w h +- i w h sqrt(1 - zeta^2)) if
    1 - h c = exp(-2 zeta w h) and h^2 k = 1 + exp(-2 zeta w h) - 2 exp(-zeta w h) cos(w h sqrt(1 - zeta^2)). Under a
    constant load a lip bends more than load over stiffness, by the share zeta w h. About the vertical axis the lip is
    as stiff as a step allows.
    """
    damping, step, inertia = config.cup.damping, config.timestep, context.lip_inertia
    stiffness = context.objects.stiffness[:, None] / config.mismatch
    turn = np.minimum(step * np.sqrt(stiffness / inertia), LARGEST_PHASE)
    turn[:, 2] = LARGEST_PHASE
    ratio = np.array([damping, damping, TWIST_RATIO])
    decay, wave = np.exp(-ratio * turn), np.cos(turn * np.sqrt(1.0 - ratio**2))
    return Spring(
        stiffness=inertia * (1.0 + decay * decay - 2.0 * decay * wave) / step**2,
        damping=inertia * (1.0 - decay * decay) / step,
    )


def swing_objects(
    context: Context,
    spring: Spring,
    hanging: Parting,
    hand: Callable[[Ints], Samples],
    release: Ints,
    stride: int,
    config: ConveyorConfig,
    threads: int,
) -> Parting:
    """State at the release of objects that swing under their cups during the throw.

    Args:
        context: the N picks.
        spring: the lips of the cups.
        hanging: state at the release of objects under rigid cups.
        hand: the planned motion of the cup's tip at the beginning of steps (K,).
        release: steps of the releases (N,).
        stride: steps between two records of the swing.
        config: the cell.
        threads: number of threads; results do not depend on it.
    """
    motion, o = hand(np.arange(max(release.tolist()) + 1, dtype=np.int64)), context.objects
    count, steps, _ = motion.velocity.shape
    hands = Carrying(motion.acceleration, motion.velocity, context.drift.draught, *o.turn)
    state, attitudes = np.zeros((count, STATE)), np.empty((count, (steps - 1) // stride + 2, 4))
    state[:, 3] = 1.0
    pivot = Pivot.zeros(count, arm=context.arm, stiffness=spring.stiffness, damping=spring.damping)
    lips = Hanging(o.body, pivot, config.mismatch)
    swings = state, lips, hands, release, config.timestep, stride, attitudes
    if threads > 1:
        write_in_parts(freefall.swing_down, swings, count, threads)
    else:
        freefall.swing_down(*swings)
    swing, floor = Swing(attitudes, motion.position, release, stride), config.belt.height - CONTACT_DEPTH
    unsure = find_solid(Bodies.of(o), context.arm, o.middle, swing, LIP_LENGTH, floor)
    return part_objects(state, context.arm, hanging, *o.turn, unsure)


@kernel_part
def _rotate(rotation: Floats, a: float, b: float, c: float) -> tuple[float, float, float]:
    """A vector (a, b, c) turned by a unit quaternion (4,)."""
    w, x, y, z = rotation[0], rotation[1], rotation[2], rotation[3]
    # v + w t + u x t with t = 2 u x v, where u is the vector part of the quaternion and w the scalar part.
    p, q, r = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    return a + w * p + (y * r - z * q), b + w * q + (z * p - x * r), c + w * r + (x * q - y * p)


@kernel
def part_objects(
    state: Floats2, arm: Floats2, hanging: Parting, cosine: Floats1, sine: Floats1, unsure: Bools1
) -> Parting:
    """Releases of objects that have swung under their cups.

    Args:
        state: states in the axes in which the objects hang at rest (N, STATE).
        arm: centres of mass relative to the tips, in the objects' axes at rest (N, 3) [m].
        hanging: releases of the objects at rest, to whose velocities those of the swing are added.
        cosine: cosines of the objects' yaw (N,).
        sine: sines of the objects' yaw (N,).
        unsure: which objects touched something solid (N,).
    """
    velocities, rates = hanging.velocity.copy(), hanging.rate + state[:, 10:13]
    centres, attitudes = np.empty(velocities.shape), np.empty(hanging.attitude.shape)
    for row in range(len(state)):
        turn, cos, sin = state[row, 3:7], cosine[row], sine[row]
        centre, velocity, attitude, rest = centres[row], velocities[row], attitudes[row], hanging.attitude[row]
        a, b, c = components(arm[row])
        x, y, z = _rotate(turn, a, b, c)
        centre[0], centre[1], centre[2] = cos * x - sin * y, cos * y + sin * x, z
        p, q, r = components(state[row, 10:])
        # The velocity of the centre of mass about the tip, omega x r, in the world's axes.
        x, y, z = _rotate(turn, q * c - r * b, r * a - p * c, p * b - q * a)
        velocity[0] += cos * x - sin * y
        velocity[1] += cos * y + sin * x
        velocity[2] += z
        # Hamilton's product of the attitude at rest and the turn.
        w, a, b, c = rest[0], rest[1], rest[2], rest[3]
        v, x, y, z = turn[0], turn[1], turn[2], turn[3]
        attitude[0] = w * v - (a * x + b * y + c * z)
        attitude[1] = w * x + v * a + (b * z - c * y)
        attitude[2] = w * y + v * b + (c * x - a * z)
        attitude[3] = w * z + v * c + (a * y - b * x)
    return Parting(centres, velocities, attitudes, rates, hanging.push, unsure)


@kernel
def find_solid(objects: Bodies, arm: Floats2, middle: Floats1, swing: Swing, lip: float, floor: float) -> Bools1:
    """Which swinging objects touch the belt or the solid part of their cups before their release (N,).

    Args:
        objects: the N objects.
        arm: centres of mass relative to the tips, in the objects' axes at rest (N, 3) [m].
        middle: heights of the bodies' middles above the centres of mass, at rest (N,) [m].
        swing: the swing.
        lip: length of the cups' lips [m].
        floor: height below which an object touches the belt [m].
    """
    touched = np.zeros(len(arm), np.bool_)
    for row in range(len(touched)):
        for k in range(swing.attitude.shape[1]):
            a, b, upright = up_axis(swing.attitude[row, k])
            below = arm[row, 0] * a + arm[row, 1] * b + (arm[row, 2] + middle[row]) * upright
            tip = swing.hand[row, min(k * swing.stride, swing.steps[row]), 2]
            low = tip + below - extent_along(objects.shape[row], objects.extents[row], a, b, upright)
            tilt = math.sqrt(max(1.0 - upright * upright, 0.0))
            steep = objects.radius[row] * tilt > lip or upright < TILT_COSINE
            touched[row] = touched[row] or steep or low < floor
    return touched
