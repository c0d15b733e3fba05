"""Swing of N objects under compliant cups: the lip as a spring, and the swing along the planned path of the hand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Final, NamedTuple, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, dot
from pnt_gym.cells.base.fluid import fluid_coefficients, geom_placement, lying_size, solid_shell_inertia
from pnt_gym.cells.base.items import CYLINDER
from pnt_gym.cells.base.rotations import quaternion_product, rotate, to_body_axes, vertical
from pnt_gym.cells.conveyor.config import LIP_GAP, LIP_LENGTH, ConveyorConfig
from pnt_gym.cells.conveyor.context import Context
from pnt_gym.cells.conveyor.cup.parting import Parting
from pnt_gym.cells.conveyor.objects.outline import reach
from pnt_gym.planning.motion.trajectory import Samples

LARGEST_PHASE: Final = 0.5
"""Largest phase of a swing in a step [rad]; the stiffness of a lip is limited to that of this phase.

Then h^2 k + 2 h c < 1.4 about each axis; the steps are stable below 4, which coupling of the axes by an object's offset
brings down to 4 / 3 at the utmost, and not near it."""
TWIST_RATIO: Final = 0.5
"""Damping ratio about the vertical axis, about which the lip is stiff."""
TILT_COSINE: Final = 0.5
"""Cosine of the tilt beyond which an object under its cup is simulated by the engine."""
CONTACT_DEPTH: Final = 0.001
"""Depth in the belt beyond which an object under its cup has touched the belt [m]."""


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
    cup, step, inertia = config.cup, config.timestep, effective_inertia(context)
    stiffness = (cup.stiffness or np.inf) / config.mismatch
    turn = np.minimum(step * np.sqrt(stiffness / inertia), LARGEST_PHASE)
    turn[:, 2] = LARGEST_PHASE
    ratio = np.array([cup.damping, cup.damping, TWIST_RATIO])
    decay, wave = np.exp(-ratio * turn), np.cos(turn * np.sqrt(1.0 - ratio**2))
    return Spring(
        stiffness=inertia * (1.0 + decay * decay - 2.0 * decay * wave) / step**2,
        damping=inertia * (1.0 - decay * decay) / step,
    )


def effective_inertia(context: Context) -> Floats:
    """Effective inertia of N objects, free to turn about the lip, against a moment about each body axis (N, 3) [kg m2].

    The effective inertia 1 / (I^-1)_kk is less than the moment of inertia I_kk where an offset couples the axes.
    """
    o = context.objects
    arm = to_body_axes(np.concatenate([context.grasp, -o.com_depth[:, None]], axis=1), o.yaw)
    inertia = -o.mass[:, None, None] * arm[:, :, None] * arm[:, None, :]
    diagonal = solid_shell_inertia(o.mass, lying_size(o.shape, o.size), o.shape)
    # Parallel axes about the lip: I + m (|r|^2 - r r^T).
    inertia[:, range(3), range(3)] += diagonal + (o.mass * dot(arm, arm))[:, None]
    return np.asarray(1.0 / np.linalg.inv(inertia)[:, range(3), range(3)], dtype=np.float64)


def swing_objects(
    context: Context,
    hanging: Parting,
    hand: Callable[[Ints], Samples],
    release: Ints,
    stride: int,
    config: ConveyorConfig,
) -> Parting:
    """State at the release of objects that swing under their cups during the throw.

    Args:
        context: the N picks.
        hanging: state at the release of objects under rigid cups.
        hand: the planned motion of the cup's tip at the beginning of steps (K,).
        release: steps of the releases (N,).
        stride: steps between two records of the swing.
        config: the cell.
    """
    from pnt_gym.cells.base.freefall import STATE, swing_down  # noqa: PLC0415 - compiles, where nothing is kept

    yaw, count, last = context.objects.yaw, len(release), int(release.max())
    motion = hand(np.arange(last, dtype=np.int64))
    against_air = motion.velocity - np.concatenate([context.drift.draught, np.zeros((count, 1))], axis=1)[:, None]
    # In the objects' axes at rest, in which their inertia is diagonal.
    moves = np.concatenate([to_body_axes(way, yaw[:, None]) for way in (motion.acceleration, against_air)], axis=2)
    arm = to_body_axes(hanging.centre, yaw)
    state, attitudes = np.zeros((count, STATE)), np.zeros((count, last // stride + 2, 4))
    state[:, 3] = 1.0
    pivot = np.concatenate([arm, *springs(context, config)], axis=1)
    swing_down(
        state, body_constants(context), pivot, config.mismatch, config.timestep, moves, release, stride, attitudes
    )
    rotation, rate = state[:, 3:7], state[:, 10:13]
    looks = np.minimum(np.arange(attitudes.shape[1], dtype=np.int64) * stride, release[:, None])
    return replace(
        hanging,
        centre=to_body_axes(rotate(rotation, arm), -yaw),
        velocity=hanging.velocity + to_body_axes(rotate(rotation, np.cross(rate, arm)), -yaw),
        attitude=quaternion_product(hanging.attitude, rotation),
        rate=hanging.rate + rate,
        unsure=_touches_solid(context, arm, attitudes, hand(looks).position[..., 2], config),
    )


def body_constants(context: Context) -> Floats:
    """Constants of the objects' bodies (N, BODY), see `freefall.BODY`."""
    o = context.objects
    full = lying_size(o.shape, o.size)
    placed = geom_placement(o.shape, full)
    inertia, fluid = solid_shell_inertia(o.mass, full, o.shape), fluid_coefficients(o.shape, full, o.drag)
    lies = (o.shape == CYLINDER)[:, None]
    semi = np.where(lies, placed.size[:, [0, 0, 1]], placed.size)
    up = o.com_depth - LIP_GAP - o.size[:, 2] / 2
    return np.ascontiguousarray(
        np.concatenate([o.mass[:, None], inertia, up[:, None], placed.quat, semi, fluid], axis=1)
    )


def _touches_solid(context: Context, arm: Floats, attitudes: Floats, tip: Floats, config: ConveyorConfig) -> Bools:
    """Whether swinging objects touched the belt or the solid part of their cups (N,).

    Args:
        context: the N picks.
        arm: centre of mass relative to the tip, in the objects' axes at rest (N, 3) [m].
        attitudes: attitudes of the objects (N, K, 4).
        tip: height of the tip (N, K) [m].
        config: the cell.
    """
    o, up = context.objects, vertical(attitudes)
    full = lying_size(o.shape, o.size)
    middle = arm + np.stack([np.zeros_like(o.yaw)] * 2 + [o.com_depth - LIP_GAP - o.size[:, 2] / 2.0], axis=1)
    low = tip + dot(middle[:, None], up) - reach(o, full / 2.0, up)
    tilt = np.sqrt(np.maximum(1.0 - up[..., 2] ** 2, 0.0))
    # A tilt sinks one edge of the cup by radius x tilt; beyond the lip's length the solid part touches.
    steep = (o.cup_radius[:, None] * tilt > LIP_LENGTH) | (up[..., 2] < TILT_COSINE)
    return np.asarray((steep | (low < config.belt.height - CONTACT_DEPTH)).any(axis=1))
