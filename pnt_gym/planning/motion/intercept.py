"""Place and time at which the hand meets an object that rides on a belt.

The hand moves from rest to rest to a point above the object's pick position, then straight down (Hassan et al.
2022, section III-C). With T(t) the duration of both moves to the object's place at time t, the object can be
picked at t when F(t) = T(t) - t <= 0; the first t inside the window with F(t) <= 0 is the meeting.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Bools, Floats, Ints, finite_points, finite_rows, number, numbers
from pnt_gym.errors import PlanningError, one_sentence
from pnt_gym.planning.motion import hunt
from pnt_gym.planning.motion.limits import LimitRows, Limits, limit_rows
from pnt_gym.planning.reasons import InterceptReason

HORIZON: Final = 30.0
"""Default of the latest meeting that is searched for [s]."""
FEASIBLE: Final = int(InterceptReason.FEASIBLE)


@final
@dataclass(frozen=True, eq=False)
class Intercept:
    """N meetings of hand and object; NaN in rows without a meeting.

    Attributes:
        time: time at which the hand touches the object (N,) [s].
        position: TCP at that time (N, 3) [m].
        wait: time the hand waits above the object's path because the object may not be picked yet (N,) [s].
        travel: time of the move to the point above (N,) [s]; travel + wait + descent = time.
        descent: time of the move down (N,) [s].
        feasible: whether the object can be picked (N,).
        reason: ``InterceptReason`` codes (N,), 0 where feasible.
    """

    time: Floats
    position: Floats
    wait: Floats
    travel: Floats
    descent: Floats
    feasible: Bools
    reason: Ints


def plan_intercept(
    start: ArrayLike,
    positions: ArrayLike,
    belt_velocity: ArrayLike,
    limits: Limits,
    *,
    clearance: ArrayLike,
    window: tuple[ArrayLike, ArrayLike] = (-np.inf, np.inf),
    earliest: ArrayLike = 0.0,
    axis: int = 0,
    horizon: float = HORIZON,
) -> Intercept:
    """Return the earliest meetings of N hands with N moving objects.

    Args:
        start: TCPs of the resting hands at time 0 (N, 3) [m].
        positions: TCPs that would pick the objects at time 0 (N, 3) [m].
        belt_velocity: velocity of the objects, (3,) or (N, 3) [m/s].
        limits: largest speed, acceleration and jerk of the hand.
        clearance: height above the pick at which the vertical descent starts, >= 0 [m], one number or (N,).
        window: least and greatest coordinate along ``axis`` at which an object may be picked [m], each one
            number or (N,).
        earliest: time before which an object may not be picked [s], one number or (N,).
        axis: coordinate that the window bounds: 0, 1 or 2 for x, y or z.
        horizon: latest time that is searched [s]; a later meeting counts as none.

    Returns:
        The meetings. A row's result does not depend on the other rows.

    Raises:
        ValueError: if an input is NaN, a coordinate infinite, the clearance negative, the window empty, the
            horizon not positive, or shapes disagree.
    """
    origin = finite_points(start, "start")
    count = len(origin)
    place = finite_points(positions, "positions", count)
    belt = finite_points(_spread(belt_velocity, (count, 3), "belt_velocity"), "belt_velocity")
    lift = finite_rows(clearance, count, "clearance")
    if (lift < 0.0).any():
        raise PlanningError(f"clearance must not be negative [m], got {lift.min()}")
    if axis not in (0, 1, 2):
        raise PlanningError(f"axis must be 0, 1 or 2, got {axis!r}")
    if not 0.0 < number(horizon, "horizon") < np.inf:
        raise PlanningError(f"horizon must be positive and finite [s], got {horizon}")
    try:
        low, high = window
    except (TypeError, ValueError):
        raise PlanningError(f"window must be two borders, got {one_sentence(repr(window), 80)}") from None
    low, high = _spread(low, (count,), "window"), _spread(high, (count,), "window")
    if not (low <= high).all():
        row = int(np.argmin(low <= high))
        raise PlanningError(f"window must run from least to greatest, got {low[row]}, {high[row]}")
    begin = finite_rows(earliest, count, "earliest")
    hunts = np.array([*origin.T, *place.T, *belt.T, lift, *limit_rows(limits, count), low, high, begin])
    return find_meetings(hunts, axis, horizon)


def _spread(values: ArrayLike, shape: tuple[int, ...], name: str) -> Floats:
    """Numbers of a shape to which the given numbers broadcast."""
    array = numbers(values, name)
    if array.shape not in (shape, shape[1:]):
        raise PlanningError(f"{name} must have shape {shape[1:]} or {shape}, got {array.shape}")
    return np.broadcast_to(array, shape)


def meet_on_belt(
    start: Floats, place: Floats, speed: float, limits: LimitRows, clearance: float, window: tuple[float, float]
) -> Intercept:
    """Return the earliest meetings as `plan_intercept`, with objects on a belt that moves along x, unchecked."""
    hunts = np.zeros((16, len(start)))
    hunts[0:3], hunts[3:6], hunts[6], hunts[9] = start.T, place.T, speed, clearance
    hunts[10], hunts[11], hunts[12] = limits
    hunts[13], hunts[14] = window
    return find_meetings(hunts, 0, HORIZON)


def find_meetings(hunts: Floats, axis: int, horizon: float) -> Intercept:
    """Return the earliest meetings of hunts (16, N), by the rows of `planning.motion.hunt`."""
    count = hunts.shape[1]
    numbers, reason = np.empty((7, count)), np.empty(count, dtype=np.int64)
    hunt.meet(hunts, axis, horizon, numbers, reason)
    return Intercept(
        time=numbers[0],
        position=np.ascontiguousarray(numbers[1:4].T),
        wait=numbers[4],
        travel=numbers[5],
        descent=numbers[6],
        feasible=reason == FEASIBLE,
        reason=reason,
    )
