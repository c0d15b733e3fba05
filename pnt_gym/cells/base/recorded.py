"""What a plant recorded of N throws: flights and landings of the objects, and loads of the motors.

The energy of the motors in a cycle is their positive mechanical work, torque times joint speed. Each motor counts
separately, and a braking motor returns nothing (no recuperation, no common link between the drives). Heat in the
windings, friction in the gears and holding torque at rest are left out: datasheets give those losses. A NaN stays one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Final, NamedTuple, final

import numpy as np

from pnt_gym.arrays import Bools, Floats
from pnt_gym.cells.base.plant import TOUCH_DISTANCE
from pnt_gym.cells.base.sorting import SortingReward
from pnt_gym.compiled import kernel, kernel_part
from pnt_gym.constants import GRAVITY
from pnt_gym.planning.motion.strokes import time_to_fall
from pnt_gym.rows import Bools1, Bools2, Floats1, Floats2, Floats3, Ints1

REWARD_TERMS: Final = ("landing", "success", "time")
"""Names of the reward terms of a throw into an opening."""
CONTACT_DEPTH = 0.003
"""Largest depth at which flat objects rest below a surface, because contacts are soft [m]."""


@dataclass(frozen=True)
class Landed:
    """Abstract: outcome of N throws into openings; every field has shape (N,) unless noted."""

    landing: Floats
    """Where the free flight crosses the rim plane, x, y (N, 2) [m]; see `touchdown`."""
    landing_along: Floats
    """Landing relative to the target, along the throw [m]."""
    landing_across: Floats
    """Landing relative to the target, to the left of the throw [m]."""
    landing_error: Floats
    """Distance of the landing from the target [m]."""
    in_opening: Bools
    """The landing lies inside the opening."""
    in_bin: Bools
    """At the end the object lies in its bin: inside the walls, below the rim, too slow to leave."""
    is_success: Bools
    """The landing lies in the opening and the object in the bin."""
    rim: Bools
    """The landing lies in the opening but the object not in the bin: it hangs on the rim or bounced out."""
    recontact: Bools
    """The hand touched the object after the release."""
    final: Floats
    """Position of the object at the end (N, 3) [m]."""
    cycle_time: Floats
    """Time from one throw to the next, as the robot's subclass defines it [s]."""
    peak_torque: Floats
    """Largest motor torque [N m]."""

    def rewards(self, weights: SortingReward) -> dict[str, Floats]:
        """The terms `REWARD_TERMS` by name, times their weights; before weighting every term lies in [0, 1]."""
        # A throw without a landing, of which the error is NaN, gets 0.
        landing = np.fmax(1.0 - self.landing_error / weights.landing_scale, 0.0)
        time = np.maximum(1.0 - self.cycle_time / weights.time_scale, 0.0)
        worth = weights.landing * landing, weights.success * self.is_success.astype(np.float64), weights.time * time
        return dict(zip(REWARD_TERMS, worth, strict=True))


@final
class ObjectFlight(NamedTuple):
    """Motion and contacts of N thrown objects, M steps each."""

    position: Floats3
    """Position of the object at the start of each step (N, M, 3) [m]."""
    velocity: Floats3
    """Velocity of the object at the start of each step (N, M, 3) [m/s]."""
    hand_touch: Bools2
    """Whether the hand touches the object (N, M)."""
    any_touch: Bools2
    """Whether any body touches the object (N, M)."""
    release_step: Ints1
    """First step without grip (N,)."""
    last_step: Ints1
    """Last step that counts (N,)."""


@final
class Touchdown(NamedTuple):
    """Landing and last state of N thrown objects."""

    landing: Floats2
    """Where the free flight crosses the rim plane, x, y (N, 2) [m]; see `touchdown`."""
    position: Floats2
    """Last position (N, 3) [m]."""
    velocity: Floats2
    """Last velocity (N, 3) [m/s]."""
    recontact: Bools1
    """The hand touched the object after the release (N,)."""

    def landing_fields(self, target: Floats, opening: Floats, depth: Floats, along: Floats) -> dict[str, Any]:
        """Fields of `Landed` that follow from the flights, by name: all except error, cycle time and torque.

        Args:
            target: centre of each opening (N, 3) [m].
            opening: inner size along x and y (N, 2), or (1, 2) for all [m].
            depth: depths of the bins below the openings (N,), or (1,) for all [m].
            along: horizontal unit vectors of the throws (N, 2+).
        """
        x, y = (self.landing - target[:, :2]).T
        in_opening = (np.abs(x) <= opening[:, 0] / 2.0) & (np.abs(y) <= opening[:, 1] / 2.0)
        in_bin = lies_in(self, target, opening, depth)
        return {
            "landing": self.landing,
            "landing_along": x * along[:, 0] + y * along[:, 1],
            "landing_across": y * along[:, 0] - x * along[:, 1],
            "in_opening": in_opening,
            "in_bin": in_bin,
            "is_success": in_opening & in_bin,
            "rim": in_opening & ~in_bin,
            "recontact": self.recontact,
            "final": self.position,
        }


@kernel
def touchdown(flight: ObjectFlight, target: Floats2) -> Touchdown:
    """Landings where N free flights cross the heights of openings (N, 3) [m], going down, and last states of objects.

    The flight of an object that first touches a rim, a wall or the belt is continued ballistically from the step
    before, so the landing measures the throw and not the bin. The landing of an object that does not cross the height
    is its last position.
    """
    count = len(target)
    landing, recontact = np.empty((count, 2)), np.empty(count, np.bool_)
    final_position, final_velocity = np.empty((count, 3)), np.empty((count, 3))
    for n in range(len(target)):
        position, velocity, hand_touch = flight.position[n], flight.velocity[n], flight.hand_touch[n]
        last, plane = flight.last_step[n], target[n, 2]
        final_position[n], final_velocity[n] = position[last], velocity[last]
        event, recontact[n], is_open = last, False, True
        for k in range(flight.release_step[n] + 1, last + 1):
            recontact[n] |= hand_touch[k]
            comes_down = k > 0 and position[k, 2] - plane < 0.0 and position[k - 1, 2] - plane >= 0.0
            if is_open and (comes_down or (flight.any_touch[n, k] and not hand_touch[k])):
                event, is_open = k, False
        before = max(event - 1, 0)
        time = time_to_fall(position[before, 2] - plane, velocity[before, 2])
        for axis in range(2):
            landing[n, axis] = position[before, axis] + time * velocity[before, axis]
        if not math.isfinite(landing[n, 0]):
            # An object that is never above the plane after the release fell short; its last position counts.
            landing[n, 0], landing[n, 1] = position[last, 0], position[last, 1]
    return Touchdown(landing, final_position, final_velocity, recontact)


@kernel_part
def _join_flights(held: Floats3, alone: Floats3, clear: Ints1, steps: Ints1, release: Ints1, cup: int) -> ObjectFlight:
    """Flights of N objects from their releases on, joined step by step; arguments as of `joined_touchdown`.

    Step 0 of a flight is the release. Nothing touches an object after its last step.
    """
    count, held_steps = len(clear), clear - release
    longest = (held_steps + steps).max()
    position, velocity = np.zeros((count, longest, 3)), np.zeros((count, longest, 3))
    hand_touch, any_touch = np.zeros((count, longest), np.bool_), np.zeros((count, longest), np.bool_)
    for n in range(len(clear)):
        for k in range(held_steps[n] + steps[n]):
            is_held = k < held_steps[n]
            record = held[n, release[n] + k] if is_held else alone[n, k - held_steps[n]]
            for axis in range(3):
                position[n, k, axis] = record[axis]
                velocity[n, k, axis] = record[3 + axis]
            any_touch[n, k] = record[6] > 0.0 and record[7] < TOUCH_DISTANCE
            hand_touch[n, k] = is_held and record[cup] > 0.0 and record[cup + 1] < TOUCH_DISTANCE
    first = np.zeros(count, np.int64)
    return ObjectFlight(position, velocity, hand_touch, any_touch, first, held_steps + steps - 1)


@kernel
def joined_touchdown(
    held: Floats3, alone: Floats3, clear: Ints1, steps: Ints1, release: Ints1, cup: int, target: Floats2
) -> Touchdown:
    """Landings and last states as of `touchdown`, from records with the robot and then without it.

    Args:
        held: position, velocity and contact, number and smallest distance, with the robot (N, K, 8+); SI units.
        alone: as `held`, without the robot, from its end on (N, L, 8).
        clear: step of each object from which on it is recorded without the robot (N,).
        steps: number of these steps (N,).
        release: first steps without grip (N,), not later than `clear`.
        cup: column of `held` at which the contact with the cup stands.
        target: centres of the openings (N, 3) [m].
    """
    return touchdown(_join_flights(held, alone, clear, steps, release, cup), target)


@kernel
def lies_in(down: Touchdown, target: Floats2, opening: Floats2, depth: Floats1) -> Bools1:
    """Whether N objects lie in their bins for good at the end (N,).

    An object inside the walls and below the rim stays if its upward speed does not lift the object to the rim. An
    object on the inner bottom may lie lower by up to `CONTACT_DEPTH`.

    Args:
        down: landings and last states of the objects.
        target: centres of the openings at the rims (N, 3) [m], or (1, 3) for all.
        opening: inner sizes (N, 2), or (1, 2) for all [m].
        depth: depths of the inner bottoms below the rims (N,), or (1,) for all [m].
    """
    lies = np.empty(len(down.position), np.bool_)
    for n in range(len(lies)):
        middle, size, position = target[n % len(target)], opening[n % len(opening)], down.position[n]
        x, y = abs(position[0] - middle[0]), abs(position[1] - middle[1])
        inside = x <= size[0] / 2.0 and y <= size[1] / 2.0
        reach = position[2] + down.velocity[n, 2] * down.velocity[n, 2] / (2.0 * GRAVITY)
        bottom = middle[2] - depth[n % len(depth)]
        lies[n] = inside and reach < middle[2] and position[2] > bottom - CONTACT_DEPTH
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


@final
class MotorRecord(NamedTuple):
    """What was recorded of J motors in N simulations, M steps each."""

    sensors: Floats3
    """What the sensors told in each step, torques among them (N, M, 1+) [N m]."""
    torques: Ints1
    """Columns of the motors' torques (J,)."""
    rates: Floats3
    """Speeds of all joints after the step (N, M, 1+) [rad/s]. The engine's steps are a leapfrog: a torque acts from
    the middle of the step before to the middle of its step, and the two speeds belong to those moments."""
    speeds: Ints1
    """Columns of the motors' speeds (J,)."""


@kernel
def loads_of_steps(record: MotorRecord, steps: Ints1, step: float) -> tuple[Floats1, Floats1]:
    """Largest torques (N,) [N m] and positive works (N,) [J] in simulated steps.

    Args:
        record: what was recorded of the motors.
        steps: number of steps that count, for each simulation (N,).
        step: length of a step [s].
    """
    largest, work = np.zeros(len(steps)), np.zeros(len(steps))
    torque, before, after = np.empty(len(record.torques)), np.empty(len(record.torques)), np.empty(len(record.torques))
    for row in range(len(work)):
        for k in range(min(steps[row], record.sensors.shape[1])):
            for motor in range(len(torque)):
                column = record.speeds[motor]
                torque[motor] = record.sensors[row, k, record.torques[motor]]
                before[motor], after[motor] = record.rates[row, max(k - 1, 0), column], record.rates[row, k, column]
            largest[row] = _larger(largest[row], torque)
            work[row] += _power(torque, before, after) * step
    return largest, work


@kernel
def loads_between(torque: Floats3, speed: Floats3, times: Floats2) -> tuple[Floats1, Floats1]:
    """Largest torques (N,) [N m] and positive works (N,) [J] of planned motions.

    Args:
        torque: of each motor at each moment (J, N, K) [N m].
        speed: of the motor's joint (J, N, K) [rad/s].
        times: the moments, which increase (N, K) [s].
    """
    largest, work = np.zeros(len(times)), np.zeros(len(times))
    for row in range(len(work)):
        before = 0.0
        for k in range(times.shape[1]):
            largest[row] = _larger(largest[row], torque[:, row, k])
            power = _power(torque[:, row, k], speed[:, row, k], speed[:, row, k])
            if k > 0:
                # Trapezoidal rule over power.
                work[row] += (power + before) / 2.0 * (times[row, k] - times[row, k - 1])
            before = power
    return largest, work
