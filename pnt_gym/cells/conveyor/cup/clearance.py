"""Possible contacts between cups and released objects: by geometry, on the safe side.

The cup is an upright cylinder, because the platform is level. The cup cannot touch an object that is entirely below the
lip, or farther away sideways than the radii of both. Every other position counts as a possible touch, which the engine
then simulates.
"""

from __future__ import annotations

import math
from typing import Final, NamedTuple, Self, final

import numpy as np

from pnt_gym.arrays import Bools, Floats, in_order
from pnt_gym.cells.base.bodies import level_axes, up_axis, vertical
from pnt_gym.cells.base.items import BOX, CYLINDER
from pnt_gym.cells.conveyor.config import LIP_GAP
from pnt_gym.cells.conveyor.cup.hold import Parting
from pnt_gym.cells.conveyor.objects.records import Objects
from pnt_gym.compiled import kernel, kernel_part
from pnt_gym.constants import GRAVITY
from pnt_gym.rows import Bools2, Floats1, Floats2, Floats3, Ints1

MARGIN: Final = 0.001
"""Gap for the hand's tracking error: three times the largest one in the shipped levels [m]."""
FORESIGHT: Final = 0.006
"""Gap for the error of an object's predicted flight, which neglects air [m]."""
FLAT = 1e-9
"""Smallest cosine between the cup's axis and an object's face in a quotient."""
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
        return cls(o.shape, o.extents, o.cup_radius, o.com_depth - LIP_GAP)


@final
class Passage(NamedTuple):
    """Motion of N objects relative to their cups, at K moments each."""

    centre: Floats3
    """Centre of mass relative to the tip of the cup (N, K, 3) [m]."""
    drift: Floats3
    """Velocity of the centre of mass relative to the hand (N, K, 3) [m/s]."""
    up: Floats3
    """The vertical in the object's axes (N, K, 3)."""


@kernel_part
def components(vector: Floats) -> tuple[float, float, float]:
    """The components of a vector (3,)."""
    return vector[0], vector[1], vector[2]


@kernel_part
def extent_along(shape: int, extents: Floats, a: float, b: float, c: float) -> float:
    """Extent [m] of an object from its middle along a direction (a, b, c) in its axes: the support function."""
    x, y, z = abs(a) * (extents[0] / 2.0), abs(b) * (extents[1] / 2.0), abs(c) * (extents[2] / 2.0)
    if shape == BOX:
        return x + y + z
    if shape == CYLINDER:
        return x + math.sqrt(y * y + z * z)
    return math.sqrt(x * x + y * y + z * z)


@kernel
def predict_passage(
    parting: Parting,
    hand: Floats3,
    hand_velocity: Floats3,
    since: Floats1,
    cosine: Floats2,
    sine: Floats2,
) -> Passage:
    """Motions of released objects relative to their cups, under gravity alone and with constant spin.

    Args:
        parting: state of the N objects at the release.
        hand: positions of the tips (N, K, 3) [m], the first at the release.
        hand_velocity: velocities of the tips (N, K, 3) [m/s].
        since: time from the release (K,) [s].
        cosine: cosines of the angles by which the objects have turned (N, K).
        sine: sines of these angles (N, K).
    """
    centre, velocity = parting.centre, parting.velocity
    passage = Passage(np.empty(hand.shape), np.empty(hand.shape), np.empty(hand.shape))
    for row in range(len(centre)):
        first = up_axis(parting.attitude[row])
        a, b, c = components(parting.rate[row])
        turning = math.sqrt(a * a + b * b + c * c)
        turning = turning if turning > 0.0 else 1.0
        a, b, c = a / turning, b / turning, c / turning
        # Rodrigues' formula for the vertical, turned back.
        share = a * first[0] + b * first[1] + c * first[2]
        along = share * a, share * b, share * c
        across = b * first[2] - c * first[1], c * first[0] - a * first[2], a * first[1] - b * first[0]
        for k in range(len(since)):
            time = since[k]
            for axis in range(3):
                began = hand_velocity[row, 0, axis] + velocity[row, axis]
                fallen = began * time - (hand[row, k, axis] - hand[row, 0, axis])
                speed = began - hand_velocity[row, k, axis]
                if axis == 2:
                    fallen -= GRAVITY / 2.0 * (time * time)
                    speed -= GRAVITY * time
                passage.centre[row, k, axis] = centre[row, axis] + fallen
                passage.drift[row, k, axis] = speed
                turned = along[axis] + cosine[row, k] * (first[axis] - along[axis])
                passage.up[row, k, axis] = turned - sine[row, k] * across[axis]
    return passage


@kernel
def may_touch(objects: Bodies, passage: Passage, gap: float, margin: float, lip: float) -> Bools2:
    """Which moments (N, K) may have a touch within half the time between two moments before or after.

    Args:
        objects: the N objects and their cups.
        passage: motion of the objects relative to their cups.
        gap: time between two moments [s].
        margin: gap below which a touch is possible [m].
        lip: length of a compliant lip at the tip of the cup, which touches nothing [m].
    """
    count, moments, _ = passage.centre.shape
    near = np.empty((count, moments), np.bool_)
    for row in range(len(near)):
        length, width, height = components(objects.extents[row])
        centre, cup = objects.top[row] - height / 2.0, objects.radius[row]
        wide = cup + abs(centre) + math.sqrt(length * length + width * width + height * height) / 2.0
        for k in range(near.shape[1]):
            x, y, z = components(passage.drift[row, k])
            # The nearest moment is at most half a gap away, in which the object comes nearer by its relative speed.
            room = margin + 0.5 * gap * math.sqrt(x * x + y * y + z * z)
            x, y, z = components(passage.centre[row, k])
            sideways = math.sqrt(x * x + y * y)
            a, b, upright = components(passage.up[row, k])
            # Below the cup an object is lower than its highest point, and lower than the plane of its upper face.
            tilt = math.sqrt(max(1.0 - upright * upright, 0.0))
            far = sideways + abs(centre) * tilt + cup
            face = (height / 2.0 + tilt * far) / max(abs(upright), FLAT)
            reach = extent_along(objects.shape[row], objects.extents[row], a, b, upright)
            highest = z - lip + centre * upright + min(reach, face)
            near[row, k] = highest > -room and sideways < wide + room
    return near


def touches(objects: Objects, centre: Floats, attitude: Floats) -> Bools:
    """Whether a point of the cup's face is inside an object (N, K), at K moments.

    Args:
        objects: the N objects.
        centre: the objects' centres of mass relative to the tip of the cup (N, K, 3) [m].
        attitude: quaternions of the objects, w first (N, K, 4).
    """
    along, across = level_axes(attitude)
    half = objects.extents[:, None, None] / 2.0
    axes = [axis[..., None, :] for axis in (along, across, vertical(*in_order(attitude)))]
    face = objects.cup_radius[:, None, None, None] * _FACE
    # Points of the face in the axes of the objects, from the middles of their bodies.
    x, y, z = (face[..., k] - centre[..., None, k] for k in range(3))
    point = x[..., None] * axes[0] + y[..., None] * axes[1] + z[..., None] * axes[2]
    point[..., 2] -= (objects.com_depth - LIP_GAP)[:, None, None] - half[..., 2]
    a, b, c = (np.abs(point[..., k]) / half[..., k] for k in range(3))
    shape = objects.shape[:, None, None]
    box, lying = (a < 1.0) & (b < 1.0) & (c < 1.0), (a < 1.0) & (b * b + c * c < 1.0)
    inside = np.select([shape == BOX, shape == CYLINDER], [box, lying], a * a + b * b + c * c < 1.0)
    return np.asarray(inside.any(axis=2))
