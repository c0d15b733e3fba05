"""The spin that objects get when they are let go: as it is assumed, or as lip and blown air give it."""

from __future__ import annotations

from typing import Final

import numpy as np

from pnt_gym.arrays import Floats, Ints
from pnt_gym.cells.base.fluid import lying_size, solid_shell_inertia
from pnt_gym.cells.base.rotations import in_body_axes

HALF_LIP: Final = 4.0 / (3.0 * np.pi)
"""Centroid of half a disc from its middle, in radii."""


def peel_impulse(weight: Floats, grasp: Floats, radius: Floats, tau: Floats) -> Floats:
    """Angular impulse that a lip gives which peels off at one side, about x and y, S + (2,) [N m s].

    An object is free when the vacuum has decayed to its weight. The lip opens first where the object is heavier, on the
    side of its centre of mass. What is left of the vacuum, m g exp(-t / tau), is taken to hold the other half of the
    lip, whose centroid is 4 r / (3 pi) from the middle: with the grasp offset e that is its arm about the centre of
    mass, and the impulse is m g tau (e + 4 r / (3 pi)). The side that opened goes down. That half a lip holds until
    the vacuum is gone is an upper bound.

    Args:
        weight: of the object, S [N].
        grasp: centre of mass from the cup's axis along x, y, S + (2,) [m].
        radius: of the lip, S [m].
        tau: time constant of the vacuum, S [s].
    """
    offset = np.sqrt(grasp[..., 0] ** 2 + grasp[..., 1] ** 2)
    side = grasp / np.maximum(offset, 1e-12)[..., None]
    size = weight * tau * (offset + HALF_LIP * radius)
    return size[..., None] * np.stack([-side[..., 1], side[..., 0]], axis=-1)


def blow_impulse(mass: Floats, grasp: Floats, speed: float) -> Floats:
    """Angular impulse about x and y of air that blows objects down along the cup's axis, S + (2,) [N m s].

    Args:
        mass: S [kg].
        grasp: centre of mass from the cup's axis along x, y, S + (2,) [m].
        speed: that the air gives the centre of mass [m/s].
    """
    return (mass * speed)[..., None] * np.stack([grasp[..., 1], -grasp[..., 0]], axis=-1)


def gained(impulse: Floats, mass: Floats, size: Floats, shape: Ints, yaw: Floats) -> Floats:
    """Spin about x, y, z that angular impulses about x and y, S + (2,) [N m s], give to free objects, S + (3,) [rad/s].

    Args:
        impulse: in the world.
        mass: S [kg].
        size: full extents, S + (3,) [m].
        shape: index in `items.SHAPES`, S.
        yaw: of the objects, S [rad].
    """
    index = shape.reshape(-1)
    inertia = solid_shell_inertia(mass.reshape(-1), lying_size(index, size.reshape(-1, 3)), index)
    level = np.concatenate([impulse, np.zeros_like(impulse[..., :1])], axis=-1)
    return in_body_axes(in_body_axes(level, yaw) / inertia.reshape(size.shape), -yaw)


def assumed(random: Floats, offset: Floats) -> Floats:
    """Spin at release S + (3,): a random part (a third of it about z), and one from the off-centre grip S + (2,)."""
    spin = random.copy()
    spin[..., 2] /= 3.0
    spin[..., 0] += offset[..., 1]
    spin[..., 1] -= offset[..., 0]
    return spin
