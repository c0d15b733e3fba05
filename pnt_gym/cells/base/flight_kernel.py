"""Recorded flights of thrown objects, step by step in machine code; see `pnt_gym.compiled`."""

from __future__ import annotations

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.compiled import compile_for


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


@compile_for("void(f8[:, :, :], b1[:, :], b1[:, :], i8[:], i8[:], f8[:], i8[::1], b1[::1])")
def find_events(
    position: Floats,
    hand_touch: Bools,
    any_touch: Bools,
    release: Ints,
    last: Ints,
    plane: Floats,
    event: Ints,
    recontact: Bools,
) -> None:
    """Find the step in which each of N free flights touches something or comes down through a plane.

    Args:
        position: position of the object at the start of each step (N, M, 3) [m].
        hand_touch: whether the hand touches the object (N, M).
        any_touch: whether anything touches the object (N, M).
        release: first step without grip (N,).
        last: last step that counts (N,).
        plane: height of the plane [m].
        event: written, the last step where nothing happens before (N,).
        recontact: written, whether the hand touches the object after the release (N,).
    """
    for n in range(len(release)):
        event[n], recontact[n], is_open = last[n], False, True
        for k in range(release[n] + 1, last[n] + 1):
            recontact[n] |= hand_touch[n, k]
            comes_down = k > 0 and position[n, k, 2] - plane[n] < 0.0 and position[n, k - 1, 2] - plane[n] >= 0.0
            if is_open and (comes_down or (any_touch[n, k] and not hand_touch[n, k])):
                event[n], is_open = k, False
