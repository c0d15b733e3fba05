"""Place and time at which the hand meets an object that rides on a belt.

The hand moves from rest to rest to a point above the object's pick position, then straight down (Hassan et al.
2022, section III-C). With T(t) the duration of both moves to the object's place at time t, the object can be
picked at t when F(t) = T(t) - t <= 0; the first t inside the window with F(t) <= 0 is the meeting.
"""

from __future__ import annotations

from typing import Any, Final, cast

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats, finite_points, finite_rows, number, numbers
from pnt_gym.errors import PlanningError, one_sentence
from pnt_gym.planning.motion import hunt
from pnt_gym.planning.motion.limits import Limits, limit_rows
from pnt_gym.planning.motion.rows import Hunt, Intercept

HORIZON: Final = 30.0
"""Default of the latest meeting that is searched for [s]."""


def plan_intercept(
    start: ArrayLike,
    positions: ArrayLike,
    belt_velocity: ArrayLike,
    limits: Limits,
    *,
    clearance: ArrayLike,
    window: tuple[ArrayLike, ArrayLike] = (-np.inf, np.inf),
    times: tuple[ArrayLike, float] = (0.0, HORIZON),
    axis: int = 0,
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
        times: time before which an object may not be picked [s], one number or (N,), and latest time that is searched
            [s]; a later meeting counts as none.
        axis: coordinate that the window bounds: 0, 1 or 2 for x, y or z.

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
    low, high = _two(window, "window", "borders")
    earliest, horizon = _two(times, "times", "times")
    if not 0.0 < number(horizon, "times[1]") < np.inf:
        raise PlanningError(f"times[1] must be positive and finite [s], got {horizon}")
    low, high = _spread(low, (count,), "window"), _spread(high, (count,), "window")
    if not (low <= high).all():
        row = int(np.argmin(low <= high))
        raise PlanningError(f"window must run from least to greatest, got {low[row]}, {high[row]}")
    begin = finite_rows(earliest, count, "times[0]")
    hunts = Hunt.zeros(
        count, hand=origin, place=place, belt=belt, clearance=lift, low=low, high=high, earliest=begin,
        **limit_rows(limits, count)._asdict(),
    )  # fmt: skip
    return Intercept(hunt.meet(hunts, axis, horizon))


def _two(values: object, name: str, parts: str) -> tuple[Any, Any]:
    """Two values, of a pair that a user gives."""
    try:
        first, second = cast("tuple[Any, Any]", values)
    except (TypeError, ValueError):
        raise PlanningError(f"{name} must be two {parts}, got {one_sentence(repr(values), 80)}") from None
    return first, second


def _spread(values: ArrayLike, shape: tuple[int, ...], name: str) -> Floats:
    """Numbers of a shape to which the given numbers broadcast."""
    array = numbers(values, name)
    if array.shape not in (shape, shape[1:]):
        raise PlanningError(f"{name} must have shape {shape[1:]} or {shape}, got {array.shape}")
    return np.broadcast_to(array, shape)
