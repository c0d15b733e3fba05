"""Geometry of objects under their cups and beside them, moment by moment. Compiled; see `pnt_gym.compiled`.

Each function serves N objects, row by row. Attitudes are unit quaternions, w first; the vertical in an object's axes is
the third row of the rotation from the object's axes to the world's.
"""

from __future__ import annotations

import math

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.items import BOX, CYLINDER
from pnt_gym.cells.conveyor.cup.clearance import Bodies, Passage
from pnt_gym.cells.conveyor.cup.hold import Parting
from pnt_gym.cells.conveyor.cup.swing import Swing
from pnt_gym.compiled import kernel, kernel_part
from pnt_gym.constants import GRAVITY
from pnt_gym.rows import Bools1, Bools2, Floats1, Floats2, Floats3

TILT_COSINE = 0.5
"""Cosine of the tilt beyond which an object under its cup is simulated by the engine."""
FLAT = 1e-9
"""Smallest cosine between the cup's axis and an object's face in a quotient."""


@kernel_part
def _numbers(vector: Floats) -> tuple[float, float, float]:
    """The components of a vector (3,)."""
    return vector[0], vector[1], vector[2]


@kernel_part
def _vertical(attitude: Floats) -> tuple[float, float, float]:
    """The vertical in the axes of a body with an attitude (4,)."""
    w, x, y, z = attitude[0], attitude[1], attitude[2], attitude[3]
    return 2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)


@kernel_part
def _rotate(rotation: Floats, a: float, b: float, c: float) -> tuple[float, float, float]:
    """A vector (a, b, c) turned by a unit quaternion (4,)."""
    w, x, y, z = rotation[0], rotation[1], rotation[2], rotation[3]
    p, q, r = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    return a + w * p + (y * r - z * q), b + w * q + (z * p - x * r), c + w * r + (x * q - y * p)


@kernel_part
def _reach(shape: int, extents: Floats, a: float, b: float, c: float) -> float:
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
        first = _vertical(parting.attitude[row])
        a, b, c = _numbers(parting.rate[row])
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
    """Moments (N, K) at which cups may touch objects, as `clearance.Passage.may_touch` says."""
    count, moments, _ = passage.centre.shape
    near = np.empty((count, moments), np.bool_)
    for row in range(len(near)):
        length, width, height = _numbers(objects.extents[row])
        centre, cup = objects.top[row] - height / 2.0, objects.radius[row]
        wide = cup + abs(centre) + math.sqrt(length * length + width * width + height * height) / 2.0
        for k in range(near.shape[1]):
            x, y, z = _numbers(passage.drift[row, k])
            # The nearest moment is at most half a gap away, in which the object comes nearer by its relative speed.
            room = margin + 0.5 * gap * math.sqrt(x * x + y * y + z * z)
            x, y, z = _numbers(passage.centre[row, k])
            sideways = math.sqrt(x * x + y * y)
            a, b, upright = _numbers(passage.up[row, k])
            # Below the cup an object is lower than its highest point, and lower than the plane of its upper face.
            tilt = math.sqrt(max(1.0 - upright * upright, 0.0))
            far = sideways + abs(centre) * tilt + cup
            face = (height / 2.0 + tilt * far) / max(abs(upright), FLAT)
            reach = _reach(objects.shape[row], objects.extents[row], a, b, upright)
            highest = z - lip + centre * upright + min(reach, face)
            near[row, k] = highest > -room and sideways < wide + room
    return near


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
        a, b, c = _numbers(arm[row])
        x, y, z = _rotate(turn, a, b, c)
        centre[0], centre[1], centre[2] = cos * x - sin * y, cos * y + sin * x, z
        p, q, r = _numbers(state[row, 10:])
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
            a, b, upright = _vertical(swing.attitude[row, k])
            below = arm[row, 0] * a + arm[row, 1] * b + (arm[row, 2] + middle[row]) * upright
            tip = swing.hand[row, min(k * swing.stride, swing.steps[row]), 2]
            low = tip + below - _reach(objects.shape[row], objects.extents[row], a, b, upright)
            tilt = math.sqrt(max(1.0 - upright * upright, 0.0))
            steep = objects.radius[row] * tilt > lip or upright < TILT_COSINE
            touched[row] = touched[row] or steep or low < floor
    return touched
