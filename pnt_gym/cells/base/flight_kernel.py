"""Recorded flights of thrown objects, step by step in machine code; see `pnt_gym.compiled`."""

from __future__ import annotations

import math

import numpy as np

from pnt_gym.cells.base.flight import CONTACT_DEPTH, ObjectFlight, Touchdown
from pnt_gym.compiled import kernel
from pnt_gym.constants import GRAVITY
from pnt_gym.rows import Bools1, Floats1, Floats2, Floats3, Ints1


@kernel
def join_flights(
    held: Floats3, alone: Floats3, clear: Ints1, steps: Ints1, release: Ints1, cup: int, near: float
) -> ObjectFlight:
    """Flights of N objects, joined from records with the robot and without it, step by step.

    Nothing touches an object after its last step.

    Args:
        held: position, velocity and contact, number and smallest distance, with the robot (N, K, 8+); SI units.
        alone: as `held`, without the robot, from its end on (N, L, 8).
        clear: step of each object from which on it is recorded without the robot (N,).
        steps: number of these steps (N,).
        release: first steps without grip (N,).
        cup: column of `held` at which the contact with the cup stands.
        near: smallest distance from which on a contact does not count [m].
    """
    count, longest = len(clear), (clear + steps).max()
    position, velocity = np.zeros((count, longest, 3)), np.zeros((count, longest, 3))
    hand_touch, any_touch = np.zeros((count, longest), np.bool_), np.zeros((count, longest), np.bool_)
    for n in range(len(clear)):
        for k in range(clear[n] + steps[n]):
            record = held[n, k] if k < clear[n] else alone[n, k - clear[n]]
            for axis in range(3):
                position[n, k, axis] = record[axis]
                velocity[n, k, axis] = record[3 + axis]
            any_touch[n, k] = record[6] > 0.0 and record[7] < near
            hand_touch[n, k] = k < clear[n] and record[cup] > 0.0 and record[cup + 1] < near
    return ObjectFlight(position, velocity, hand_touch, any_touch, release, clear + steps - 1)


@kernel
def touchdown(flight: ObjectFlight, plane: Floats1) -> Touchdown:
    """Where N free flights cross planes (N,) [m], continued ballistically from the step before something is touched.

    The landing of an object that does not cross the plane is its last position.
    """
    count = len(plane)
    landing, recontact = np.empty((count, 2)), np.empty(count, np.bool_)
    final_position, final_velocity = np.empty((count, 3)), np.empty((count, 3))
    for n in range(len(plane)):
        position, velocity, hand_touch, last = (
            flight.position[n],
            flight.velocity[n],
            flight.hand_touch[n],
            flight.last_step[n],
        )
        final_position[n], final_velocity[n] = position[last], velocity[last]
        event, recontact[n], is_open = last, False, True
        for k in range(flight.release_step[n] + 1, last + 1):
            recontact[n] |= hand_touch[k]
            comes_down = k > 0 and position[k, 2] - plane[n] < 0.0 and position[k - 1, 2] - plane[n] >= 0.0
            if is_open and (comes_down or (flight.any_touch[n, k] and not hand_touch[k])):
                event, is_open = k, False
        before = max(event - 1, 0)
        # Time until an object falls by a height [s] after it rises with a speed, as `ballistics.flight_time`.
        height = position[before, 2] - plane[n]
        rise = velocity[before, 2]
        square = rise * rise + 2.0 * GRAVITY * height
        root = math.sqrt(max(square, 0.0))
        time = 2.0 * height / (root - rise) if rise < 0.0 and square >= 0.0 else (rise + root) / GRAVITY
        time = time if square >= 0.0 and time >= 0.0 else math.nan
        for axis in range(2):
            landing[n, axis] = position[before, axis] + time * velocity[before, axis]
        if not math.isfinite(landing[n, 0]):
            # An object that is never above the plane after the release fell short; its last position counts.
            landing[n, 0], landing[n, 1] = position[last, 0], position[last, 1]
    return Touchdown(landing, final_position, final_velocity, recontact)


@kernel
def lies_in(down: Touchdown, centre: Floats2, opening: Floats2, rim: Floats1, bottom: Floats1) -> Bools1:
    """Which objects lie in their bins (N,), as `flight.Touchdown.lies_in` says."""
    lies = np.empty(len(rim), np.bool_)
    for n in range(len(lies)):
        middle, size, position = centre[n % len(centre)], opening[n % len(opening)], down.position[n]
        x, y = abs(position[0] - middle[0]), abs(position[1] - middle[1])
        inside = x <= size[0] / 2.0 and y <= size[1] / 2.0
        reach = position[2] + down.velocity[n, 2] * down.velocity[n, 2] / (2.0 * GRAVITY)
        lies[n] = inside and reach < rim[n] and position[2] > bottom[n] - CONTACT_DEPTH
    return lies
