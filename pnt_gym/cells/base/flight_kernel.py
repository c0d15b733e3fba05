"""Recorded flights of thrown objects, step by step in machine code; see `pnt_gym.compiled`."""

from __future__ import annotations

import math

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.compiled import compile_for, kernel_part
from pnt_gym.constants import GRAVITY


@compile_for("void(f8[:, :, :], f8[:, :, :], f8[:, :, :], i8[:], i8[:], f8, f8[:, :, ::1], b1[:, :, ::1])")
def join_flights(
    held: Floats, cup: Floats, alone: Floats, clear: Ints, steps: Ints, near: float, motion: Floats, touch: Bools
) -> None:
    """Join the records of N objects with the robot and without it, step by step.

    Args:
        held: position, velocity and contact, number and smallest distance, with the robot (N, K, 8); SI units.
        cup: contact with the cup (N, K, 2).
        alone: as `held`, without the robot, from its end on (N, L, 8).
        clear: step of each object from which on it is recorded without the robot (N,).
        steps: number of these steps (N,).
        near: smallest distance from which on a contact does not count [m].
        motion: written at the steps of each object, position and velocity (N, M, 6).
        touch: written to False, whether the cup and whether anything touches the object (2, N, M).
    """
    for n in range(len(clear)):
        for k in range(clear[n] + steps[n]):
            source, place = (held, k) if k < clear[n] else (alone, k - clear[n])
            for column in range(6):
                motion[n, k, column] = source[n, place, column]
            touch[1, n, k] = source[n, place, 6] > 0.0 and source[n, place, 7] < near
            touch[0, n, k] = k < clear[n] and cup[n, k, 0] > 0.0 and cup[n, k, 1] < near


@kernel_part
def _flight_time(height: float, rise: float) -> float:
    """Time until an object falls by a height [s] after it rises with a speed, as `ballistics.flight_time`."""
    square = rise * rise + 2.0 * GRAVITY * height
    root = math.sqrt(max(square, 0.0))
    time = 2.0 * height / (root - rise) if rise < 0.0 and square >= 0.0 else (rise + root) / GRAVITY
    return time if square >= 0.0 and time >= 0.0 else math.nan


@compile_for("void(f8[:, :, :], f8[:, :, :], b1[:, :], b1[:, :], i8[:], i8[:], f8[:], f8[:, ::1], b1[::1])")
def find_landings(
    position: Floats,
    velocity: Floats,
    hand_touch: Bools,
    any_touch: Bools,
    release: Ints,
    last: Ints,
    plane: Floats,
    landing: Floats,
    recontact: Bools,
) -> None:
    """Find where N free flights cross a plane, continued ballistically from the step before something is touched.

    Args:
        position: position of the object at the start of each step (N, M, 3) [m].
        velocity: velocity of the object (N, M, 3) [m/s].
        hand_touch: whether the hand touches the object (N, M).
        any_touch: whether anything touches the object (N, M).
        release: first step without grip (N,).
        last: last step that counts (N,).
        plane: height of the plane [m].
        landing: written, x, y (N, 2) [m]; the last position of an object that does not cross the plane.
        recontact: written, whether the hand touches the object after the release (N,).
    """
    for n in range(len(release)):
        event, recontact[n], is_open = last[n], False, True
        for k in range(release[n] + 1, last[n] + 1):
            recontact[n] |= hand_touch[n, k]
            comes_down = k > 0 and position[n, k, 2] - plane[n] < 0.0 and position[n, k - 1, 2] - plane[n] >= 0.0
            if is_open and (comes_down or (any_touch[n, k] and not hand_touch[n, k])):
                event, is_open = k, False
        before = max(event - 1, 0)
        time = _flight_time(position[n, before, 2] - plane[n], velocity[n, before, 2])
        for axis in range(2):
            landing[n, axis] = position[n, before, axis] + time * velocity[n, before, axis]
        if not math.isfinite(landing[n, 0]):
            # An object that is never above the plane after the release fell short; its last position counts.
            landing[n, 0], landing[n, 1] = position[n, last[n], 0], position[n, last[n], 1]


@compile_for("void(f8[:, :], f8[:, :], f8[:, :], f8[:, :], f8[:, ::1], b1[::1])")
def measure_landings(
    landing: Floats, target: Floats, opening: Floats, along: Floats, errors: Floats, in_opening: Bools
) -> None:
    """Measure landings by their targets.

    Args:
        landing: where the flights cross the rim planes (N, 2) [m].
        target: centres of the openings (N, 2+) [m].
        opening: inner sizes along x and y (N, 2), or (1, 2) for all [m].
        along: horizontal unit vectors of the throws (N, 2+).
        errors: written, landing relative to the target, along the throw and to its left (2, N) [m].
        in_opening: written, whether the landing lies inside the opening (N,).
    """
    for n in range(len(in_opening)):
        x, y = landing[n, 0] - target[n, 0], landing[n, 1] - target[n, 1]
        errors[0, n], errors[1, n] = x * along[n, 0] + y * along[n, 1], y * along[n, 0] - x * along[n, 1]
        size = opening[n % len(opening)]
        in_opening[n] = abs(x) <= size[0] / 2.0 and abs(y) <= size[1] / 2.0


@compile_for("void(f8[:, :], f8[:, :], f8[:, :], f8[:, :], f8[:], f8[:], f8, b1[::1])")
def find_lying(
    position: Floats,
    velocity: Floats,
    centre: Floats,
    opening: Floats,
    rim: Floats,
    bottom: Floats,
    sunk: float,
    lies: Bools,
) -> None:
    """Find the objects that lie in their bins, as `plant.Touchdown.lies_in`; `sunk` is the depth of soft contacts."""
    for n in range(len(lies)):
        middle, size = centre[n % len(centre)], opening[n % len(opening)]
        x, y = abs(position[n, 0] - middle[0]), abs(position[n, 1] - middle[1])
        inside = x <= size[0] / 2.0 and y <= size[1] / 2.0
        reach = position[n, 2] + velocity[n, 2] * velocity[n, 2] / (2.0 * GRAVITY)
        lies[n] = inside and reach < rim[n] and position[n, 2] > bottom[n] - sunk
