"""Possible contacts between cups and released objects: by geometry, on the safe side.

The cup is an upright cylinder, because the platform is level. The cup cannot touch an object that is entirely below the
lip, or farther away sideways than the radii of both. Every other position counts as a possible touch, which the engine
then simulates.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.base.fluid import lying_size
from pnt_gym.cells.base.items import BOX, CYLINDER
from pnt_gym.cells.base.rotations import level_axes, vertical, vertical_of_spinning
from pnt_gym.cells.conveyor.config import LIP_GAP
from pnt_gym.cells.conveyor.cup.parting import Parting
from pnt_gym.cells.conveyor.objects.outline import reach
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.constants import GRAVITY

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
@dataclass(frozen=True)
class Passage:
    """Motion of N objects relative to their cups, at K moments each."""

    centre: Floats
    """Centre of mass relative to the tip of the cup (N, K, 3) [m]."""
    drift: Floats
    """Velocity of the centre of mass relative to the hand (N, K, 3) [m/s]."""
    up: Floats
    """The vertical in the object's axes (N, K, 3)."""

    def may_touch(self, objects: Objects, gap: float, margin: float = MARGIN) -> Bools:
        """Which moments (N, K) may have a touch within half the time between two moments before or after.

        Args:
            objects: the N objects.
            gap: time between two moments [s].
            margin: gap below which a touch is possible [m].
        """
        x, y, z = (self.drift[..., k] for k in range(3))
        radius = objects.cup_radius[:, None]
        # The nearest moment is at most half a gap away, in which the object comes nearer by its relative speed.
        room = margin + 0.5 * gap * np.sqrt(x * x + y * y + z * z)
        full = lying_size(objects.shape, objects.size)
        # Height of the body's middle above its centre of mass.
        centre = (objects.com_depth - LIP_GAP - full[:, 2] / 2.0)[:, None]
        upright = self.up[..., 2]
        length, width, height = (full[:, k, None] for k in range(3))
        wide = radius + np.abs(centre) + np.sqrt(length**2 + width**2 + height**2) / 2.0
        sideways = np.sqrt(self.centre[..., 0] ** 2 + self.centre[..., 1] ** 2)
        # Below the cup an object is lower than its highest point, and lower than the plane of its upper face.
        tilt = np.sqrt(np.maximum(1.0 - upright**2, 0.0))
        far = sideways + np.abs(centre) * tilt + radius
        face = (height / 2.0 + tilt * far) / np.maximum(np.abs(upright), 1e-9)
        top = self.centre[..., 2] + centre * upright + np.minimum(reach(objects, full / 2.0, self.up), face)
        return np.asarray((top > -room) & (sideways < wide + room))


def predict_passage(parting: Parting, hand: tuple[Floats, Floats], since: Floats) -> Passage:
    """Predicted motion of N released objects relative to their cups, under gravity alone and with constant spin.

    Args:
        parting: state of the objects at the release.
        hand: position and velocity of the hands (N, K, 3) [m, m/s], the first at the release.
        since: time from the release (K,) [s].
    """
    place, velocity = hand
    began = velocity[:, :1] + parting.velocity[:, None]
    fallen = began * since[:, None] - (place - place[:, :1])
    fallen[..., 2] -= GRAVITY / 2.0 * since**2
    drift = began - velocity
    drift[..., 2] -= GRAVITY * since
    return Passage(parting.centre[:, None] + fallen, drift, vertical_of_spinning(parting.attitude, parting.rate, since))


def touches(objects: Objects, centre: Floats, attitude: Floats) -> Bools:
    """Whether a point of the cup's face is inside an object (N, K), at K moments.

    Args:
        objects: the N objects.
        centre: the objects' centres of mass relative to the tip of the cup (N, K, 3) [m].
        attitude: quaternions of the objects, w first (N, K, 4).
    """
    along, across = level_axes(attitude)
    half = lying_size(objects.shape, objects.size)[:, None, None] / 2.0
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
