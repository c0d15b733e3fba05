"""Compiled figures of recorded throws: flights and landings, loads of motors, and the holding of suction cups.

The energy of the motors in a cycle is their positive mechanical work, torque times joint speed. Each motor counts
separately, and a braking motor returns nothing (no recuperation, no common link between the drives). Heat in the
windings, friction in the gears and holding torque at rest are left out: datasheets give those losses. A NaN stays one.
"""

from __future__ import annotations

import math

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.flight import CONTACT_DEPTH, ObjectFlight, Touchdown
from pnt_gym.cells.base.grip import Hold
from pnt_gym.compiled import kernel, kernel_part
from pnt_gym.constants import GRAVITY
from pnt_gym.planning.motion.strokes import time_to_fall
from pnt_gym.rows import Bools1, Floats1, Floats2, Floats3, Ints1

# Smallest load in a quotient [N]; the load is negative where the hand falls faster than the object.
LIGHTEST = 1e-9


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
        time = time_to_fall(position[before, 2] - plane[n], velocity[before, 2])
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


@kernel_part
def _larger(largest: float, torques: Floats) -> float:
    """The largest torque so far and in a moment (J,) [N m]."""
    for torque in torques:
        if abs(torque) > largest or torque != torque:  # noqa: PLR0124 - a NaN
            largest = abs(torque)
    return largest


@kernel_part
def _power(torques: Floats, first: Floats, second: Floats) -> float:
    """Positive power [W] of motors (J,) at the mean of two speeds."""
    total = 0.0
    for motor in range(len(torques)):
        power = torques[motor] * ((first[motor] + second[motor]) / 2.0)
        if not power <= 0.0:
            total += power
    return total


@kernel
def loads_of_steps(torque: Floats3, speed: Floats3, steps: Ints1, step: float) -> tuple[Floats1, Floats1]:
    """Largest torques (N,) [N m] and positive works (N,) [J] in simulated steps.

    Args:
        torque: of each motor in each step (N, M, J) [N m].
        speed: of the motor's joint after the step (N, M, J) [rad/s]. The engine's steps are a leapfrog: a torque acts
            from the middle of the step before to the middle of its step, and the two speeds belong to those moments.
        steps: number of steps that count, for each simulation (N,).
        step: length of a step [s].
    """
    largest, work = np.empty(len(torque)), np.empty(len(torque))
    for row in range(len(work)):
        largest[row] = work[row] = 0.0
        for k in range(min(steps[row], torque.shape[1])):
            largest[row] = _larger(largest[row], torque[row, k])
            work[row] += _power(torque[row, k], speed[row, max(k - 1, 0)], speed[row, k]) * step
    return largest, work


@kernel
def loads_between(torque: Floats3, speed: Floats3, times: Floats2) -> tuple[Floats1, Floats1]:
    """Largest torques (N,) [N m] and positive works (N,) [J] of planned motions.

    Args:
        torque: of each motor at each moment (N, K, J) [N m].
        speed: of the motor's joint (N, K, J) [rad/s].
        times: the moments, which increase (N, K) [s].
    """
    largest, work = np.empty(len(torque)), np.empty(len(torque))
    for row in range(len(work)):
        largest[row] = work[row] = before = 0.0
        for k in range(torque.shape[1]):
            largest[row] = _larger(largest[row], torque[row, k])
            power = _power(torque[row, k], speed[row, k], speed[row, k])
            if k > 0:
                # Trapezoidal rule over power.
                work[row] += (power + before) / 2.0 * (times[row, k] - times[row, k - 1])
            before = power
    return largest, work


@kernel_part
def _load(hold: Hold, row: int, acceleration: Floats) -> float:
    """Holding force that the vacuum needs against slip and peel under an acceleration (3,) of the hand [N]."""
    mass, radius = hold.mass[row], hold.radius[row]
    x, y = acceleration[0], acceleration[1]
    sideways = mass * math.sqrt(x * x + y * y)
    down = mass * (GRAVITY + acceleration[2])
    slip = down + sideways / hold.friction[row]
    peel = sideways * hold.depth[row] / radius + down * (hold.offset[row] / radius + 1.0)
    return max(slip, peel, LIGHTEST)


@kernel
def smallest_margin(hold: Hold, accelerations: Floats3, counts: Ints1, scale: float) -> tuple[Floats1, Ints1]:
    """Smallest margins of N holds (N,), and where each is below 1 first (N,), as `Hold.smallest_margin` says."""
    margin, lost_at = np.empty(len(counts)), np.empty(len(counts), dtype=np.int64)
    for row in range(len(accelerations)):
        margin[row], lost_at[row] = math.inf, -1
        for k in range(counts[row]):
            value = hold.force[row] / _load(hold, row, accelerations[row, k]) / scale
            margin[row] = min(margin[row], value)
            if value < 1.0 and lost_at[row] < 0:
                lost_at[row] = k
    return margin, lost_at
