"""Recorded flights of thrown objects, step by step in machine code; see `pnt_gym.compiled`."""

from __future__ import annotations

import math

from pnt_gym.cells.base.flight import CONTACT_DEPTH, ObjectFlight, Touchdown
from pnt_gym.compiled import kernel, kernel_part
from pnt_gym.constants import GRAVITY
from pnt_gym.rows import Bools1, Floats1, Floats2, Floats3, Ints1


@kernel
def join_flights(
    held: Floats3, alone: Floats3, clear: Ints1, steps: Ints1, cup: int, near: float, flight: ObjectFlight
) -> None:
    """Join the records of N objects with the robot and without it, step by step.

    Args:
        held: position, velocity and contact, number and smallest distance, with the robot (N, K, 8+); SI units.
        alone: as `held`, without the robot, from its end on (N, L, 8).
        clear: step of each object from which on it is recorded without the robot (N,).
        steps: number of these steps (N,).
        cup: column of `held` at which the contact with the cup stands.
        near: smallest distance from which on a contact does not count [m].
        flight: written at the steps of each object; nothing touches it at the other steps.
    """
    for n in range(len(clear)):
        for k in range(clear[n] + steps[n]):
            record = held[n, k] if k < clear[n] else alone[n, k - clear[n]]
            for axis in range(3):
                flight.position[n, k, axis] = record[axis]
                flight.velocity[n, k, axis] = record[3 + axis]
            flight.any_touch[n, k] = record[6] > 0.0 and record[7] < near
            flight.hand_touch[n, k] = k < clear[n] and record[cup] > 0.0 and record[cup + 1] < near


@kernel_part
def _flight_time(height: float, rise: float) -> float:
    """Time until an object falls by a height [s] after it rises with a speed, as `ballistics.flight_time`."""
    square = rise * rise + 2.0 * GRAVITY * height
    root = math.sqrt(max(square, 0.0))
    time = 2.0 * height / (root - rise) if rise < 0.0 and square >= 0.0 else (rise + root) / GRAVITY
    return time if square >= 0.0 and time >= 0.0 else math.nan


@kernel
def find_landings(flight: ObjectFlight, plane: Floats1, landing: Floats2, recontact: Bools1) -> None:
    """Find where N free flights cross a plane, continued ballistically from the step before something is touched.

    Args:
        flight: the flights.
        plane: heights of the planes (N,) [m].
        landing: written, x, y (N, 2) [m]; the last position of an object that does not cross the plane.
        recontact: written, whether the hand touches the object after the release (N,).
    """
    for n in range(len(plane)):
        position, velocity, hand_touch, last = (
            flight.position[n],
            flight.velocity[n],
            flight.hand_touch[n],
            flight.last_step[n],
        )
        event, recontact[n], is_open = last, False, True
        for k in range(flight.release_step[n] + 1, last + 1):
            recontact[n] |= hand_touch[k]
            comes_down = k > 0 and position[k, 2] - plane[n] < 0.0 and position[k - 1, 2] - plane[n] >= 0.0
            if is_open and (comes_down or (flight.any_touch[n, k] and not hand_touch[k])):
                event, is_open = k, False
        before = max(event - 1, 0)
        time = _flight_time(position[before, 2] - plane[n], velocity[before, 2])
        for axis in range(2):
            landing[n, axis] = position[before, axis] + time * velocity[before, axis]
        if not math.isfinite(landing[n, 0]):
            # An object that is never above the plane after the release fell short; its last position counts.
            landing[n, 0], landing[n, 1] = position[last, 0], position[last, 1]


@kernel
def measure_landings(
    landing: Floats2, target: Floats2, opening: Floats2, along: Floats2, errors: Floats2, in_opening: Bools1
) -> None:
    """Measure landings (N, 2) as `flight.Touchdown.landing_fields`: errors along and across (2, N) [m]."""
    for n in range(len(in_opening)):
        x, y = landing[n, 0] - target[n, 0], landing[n, 1] - target[n, 1]
        errors[0, n], errors[1, n] = x * along[n, 0] + y * along[n, 1], y * along[n, 0] - x * along[n, 1]
        size = opening[n % len(opening)]
        in_opening[n] = abs(x) <= size[0] / 2.0 and abs(y) <= size[1] / 2.0


@kernel
def find_lying(down: Touchdown, centre: Floats2, opening: Floats2, rim: Floats1, bottom: Floats1, lies: Bools1) -> None:
    """Find the objects that lie in their bins (N,), as `flight.Touchdown.lies_in`."""
    for n in range(len(lies)):
        middle, size, position = centre[n % len(centre)], opening[n % len(opening)], down.position[n]
        x, y = abs(position[0] - middle[0]), abs(position[1] - middle[1])
        inside = x <= size[0] / 2.0 and y <= size[1] / 2.0
        reach = position[2] + down.velocity[n, 2] * down.velocity[n, 2] / (2.0 * GRAVITY)
        lies[n] = inside and reach < rim[n] and position[2] > bottom[n] - CONTACT_DEPTH
