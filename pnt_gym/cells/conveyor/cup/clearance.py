"""Possible contacts between cups and released objects: by geometry, on the safe side.

The cup is an upright cylinder, because the platform is level. The cup cannot touch an object that is entirely below the
lip, or farther away sideways than the radii of both. Every other position counts as a possible touch, which the engine
then simulates.
"""

from __future__ import annotations

from typing import Final, NamedTuple, Self, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, in_order, length
from pnt_gym.cells.base.items import BOX, CYLINDER
from pnt_gym.cells.base.rotations import level_axes, vertical
from pnt_gym.cells.conveyor.config import LIP_GAP
from pnt_gym.cells.conveyor.cup import kernel
from pnt_gym.cells.conveyor.cup.hold import Parting
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.rows import Floats1, Floats2, Floats3, Ints1

MARGIN: Final = 0.001
"""Gap for the hand's tracking error: three times the largest one in the shipped levels [m]."""
FORESIGHT: Final = 0.006
"""Gap for the error of an object's predicted flight, which neglects air [m]."""
_FACE: Final = np.array(
    [[0.0, 0.0, 0.0]]
    + [
        [radius * np.cos(turn), radius * np.sin(turn), 0.0]
        for radius, count in ((1.0 / 2.0, 8), (1.0, 16))
        for turn in np.arange(count) * 2.0 * np.pi / count
    ]
)
"""Points on the cup's face relative to the face's middle, in radii."""


@final
class Bodies(NamedTuple):
    """N objects and their cups."""

    shape: Ints1
    """Indices in `items.SHAPES` (N,)."""
    extents: Floats2
    """Extents of the bodies (N, 3) [m]."""
    radius: Floats1
    """Radii of the cups (N,) [m]."""
    top: Floats1
    """Heights of the upper faces above the centres of mass, at rest (N,) [m]."""

    @classmethod
    def of(cls, objects: Objects) -> Self:
        """Bodies of objects that hang at rest."""
        o = objects
        return cls(*in_order(o.shape, o.extents, o.cup_radius, o.com_depth - LIP_GAP))


@final
class Passage(NamedTuple):
    """Motion of N objects relative to their cups, at K moments each."""

    centre: Floats3
    """Centre of mass relative to the tip of the cup (N, K, 3) [m]."""
    drift: Floats3
    """Velocity of the centre of mass relative to the hand (N, K, 3) [m/s]."""
    up: Floats3
    """The vertical in the object's axes (N, K, 3)."""

    def may_touch(self, objects: Objects, gap: float, margin: float = MARGIN, lip: float = 0.0) -> Bools:
        """Which moments (N, K) may have a touch within half the time between two moments before or after.

        Args:
            objects: the N objects.
            gap: time between two moments [s].
            margin: gap below which a touch is possible [m].
            lip: length of a compliant lip at the tip of the cup, which touches nothing [m].
        """
        return kernel.may_touch(Bodies.of(objects), Passage(*in_order(*self)), gap, margin, lip)


def predict_passage(parting: Parting, hand: tuple[Floats, Floats], since: Floats) -> Passage:
    """Predicted motion of N released objects relative to their cups, under gravity alone and with constant spin.

    Args:
        parting: state of the objects at the release.
        hand: position and velocity of the hands (N, K, 3) [m, m/s], the first at the release.
        since: time from the release (K,) [s].
    """
    turned = length(parting.rate)[:, None] * since
    return kernel.predict_passage(Parting(*in_order(*parting)), *in_order(*hand, since, np.cos(turned), np.sin(turned)))


def follow_passage(motion: tuple[Floats, Floats, Floats], hand: tuple[Floats, Floats]) -> Passage:
    """Motion of N simulated objects relative to their cups.

    Args:
        motion: positions [m], velocities [m/s] (N, K, 3) and attitudes (N, K, 4) of the objects.
        hand: position and velocity of the hands (N, K, 3) [m, m/s].
    """
    position, velocity, attitude = motion
    return Passage(position - hand[0], velocity - hand[1], vertical(attitude))


def touches(objects: Objects, centre: Floats, attitude: Floats) -> Bools:
    """Whether a point of the cup's face is inside an object (N, K), at K moments.

    Args:
        objects: the N objects.
        centre: the objects' centres of mass relative to the tip of the cup (N, K, 3) [m].
        attitude: quaternions of the objects, w first (N, K, 4).
    """
    along, across = level_axes(attitude)
    half = objects.extents[:, None, None] / 2.0
    axes = [axis[..., None, :] for axis in (along, across, vertical(attitude))]
    face = objects.cup_radius[:, None, None, None] * _FACE
    x, y, z = (face[..., k] - centre[..., None, k] for k in range(3))
    point = x[..., None] * axes[0] + y[..., None] * axes[1] + z[..., None] * axes[2]
    point[..., 2] -= (objects.com_depth - LIP_GAP)[:, None, None] - half[..., 2]
    a, b, c = (np.abs(point[..., k]) / half[..., k] for k in range(3))
    shape = objects.shape[:, None, None]
    box, lying = (a < 1.0) & (b < 1.0) & (c < 1.0), (a < 1.0) & (b * b + c * c < 1.0)
    inside = np.select([shape == BOX, shape == CYLINDER], [box, lying], a * a + b * b + c * c < 1.0)
    return np.asarray(inside.any(axis=2))
