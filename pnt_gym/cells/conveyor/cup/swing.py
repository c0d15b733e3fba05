"""Swing of N objects under compliant cups: the lip as a spring, and the swing along the planned path of the hand."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final, NamedTuple, final

import numpy as np

from pnt_gym.arrays import Floats, Ints, in_order
from pnt_gym.cells.base import freefall
from pnt_gym.cells.base.airborne import STATE, Body, Hanging, Pivot
from pnt_gym.cells.base.items import CYLINDER
from pnt_gym.cells.base.rotations import turn_back
from pnt_gym.cells.conveyor.config import LIP_GAP, LIP_LENGTH, ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.cup import kernel as cup_kernel
from pnt_gym.cells.conveyor.cup.clearance import Bodies
from pnt_gym.cells.conveyor.cup.hold import Parting
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.planning.motion.trajectory import Samples
from pnt_gym.rows import Floats3, Ints1, Rows1

LARGEST_PHASE: Final = 0.5
"""Largest phase of a swing in a step [rad]; the stiffness of a lip is limited to that of this phase.

Then h^2 k + 2 h c < 1.4 about each axis; the steps are stable below 4, which coupling of the axes by an object's offset
brings down to 4 / 3 at the utmost, and not near it."""
TWIST_RATIO: Final = 0.5
"""Damping ratio about the vertical axis, about which the lip is stiff."""
CONTACT_DEPTH: Final = 0.001
"""Depth in the belt beyond which an object under its cup has touched the belt [m]."""


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
    """
    motion, o = hand(np.arange(max(release.tolist()) + 1, dtype=np.int64)), context.objects
    count, steps, _ = motion.velocity.shape
    cosine, sine = o.turn
    against_air = motion.velocity.copy()
    against_air[..., :2] -= context.drift.draught[:, None]
    # Accelerations and velocities in the axes in which the objects hang at rest.
    moves = np.concatenate([motion.acceleration, against_air], axis=1)
    moves = turn_back(moves, cosine[:, None], sine[:, None]).reshape(count, 2, steps, 3)
    state, attitudes = np.zeros((count, STATE)), np.empty((count, (steps - 1) // stride + 2, 4))
    state[:, 3] = 1.0
    pivot = Pivot.zeros(count, arm=context.arm, stiffness=spring.stiffness, damping=spring.damping)
    lips = Hanging(body_constants(context), pivot, config.mismatch)
    freefall.swing_down(
        state, lips, np.concatenate([moves[:, 0], moves[:, 1]], axis=2), release, config.timestep, stride, attitudes
    )
    swing, floor = Swing(*in_order(attitudes, motion.position, release), stride), config.belt.height - CONTACT_DEPTH
    arm, middle = in_order(context.arm, _middle(o))
    unsure = cup_kernel.find_solid(Bodies.of(o), arm, middle, swing, LIP_LENGTH, floor)
    return cup_kernel.part_objects(state, arm, Parting(*in_order(*hanging)), *in_order(cosine, sine), unsure)


def _middle(objects: Objects) -> Floats:
    """Heights of the bodies' middles above the centres of mass of objects that hang at rest (N,) [m]."""
    return objects.com_depth - LIP_GAP - objects.size[:, 2] / 2.0


def body_constants(context: Context) -> Rows1[Body]:
    """The objects of N picks as bodies in the air."""
    o, body = context.objects, Body.empty(len(context.pick))
    body["mass"], body["inertia"], body["height"] = o.mass, o.inertia, _middle(o)
    # The semi-axes of a cylinder along its geom's axes: its radius twice, and half its length.
    size, lies = o.placement.size, (o.shape == CYLINDER)[:, None]
    body["attitude"], body["semi_axes"] = o.placement.quat, np.where(lies, size[:, [0, 0, 1]], size)
    for name, column in zip(("interacts", "blunt", "slender", "angular", "kutta", "magnus"), o.fluid.T, strict=False):
        body[name] = column
    body["virtual_mass"], body["virtual_inertia"] = o.fluid[:, 6:9], o.fluid[:, 9:]
    return body
