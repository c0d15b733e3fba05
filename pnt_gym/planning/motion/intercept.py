"""Place and time at which the hand meets an object that rides on a belt.

The hand moves from rest to rest to a point above the object's pick position, then straight down (Hassan et al.
2022, section III-C). With T(t) the duration of both moves to the object's place at time t, the object can be
picked at t when F(t) = T(t) - t <= 0; the first t inside the window with F(t) <= 0 is the meeting.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, NamedTuple, final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Bools, Floats, Ints, finite_points, finite_rows, length
from pnt_gym.errors import PlanningError
from pnt_gym.planning.motion.limits import LimitRows, Limits
from pnt_gym.planning.motion.scurve import stroke_time
from pnt_gym.planning.reasons import ReasonCode

HORIZON: Final = 30.0
"""Default of the latest meeting that is searched for [s]."""


@final
class InterceptReason(ReasonCode):
    """Why an object cannot be picked."""

    FEASIBLE = 0, "the object can be picked"
    PASSED = 1, "the object has left the window before it may be picked"
    NEVER_ENTERS = 2, "the object does not come into the window in time"
    TOO_LATE = 3, "the hand cannot reach the object before it leaves the window"


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


class _Chase(NamedTuple):
    """Objects relative to the hands' starts, raised by the clearance, belt velocities, descent times, hand limits."""

    offset: Floats
    belt: Floats
    descent: Floats
    limits: LimitRows

    def travel(self, time: Floats) -> Floats:
        """Duration (N,) [s] of the move to the point above the object's place at ``time`` (N,) [s]."""
        return stroke_time(length(self.offset + time[:, None] * self.belt), *self.limits)


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
    belt = finite_points(np.broadcast_to(np.asarray(belt_velocity), (count, 3)), "belt_velocity")
    lift = finite_rows(clearance, count, "clearance")
    if (lift < 0.0).any():
        raise PlanningError(f"clearance must not be negative [m], got {lift.min()}")
    if not 0.0 < horizon < np.inf:
        raise PlanningError(f"horizon must be positive and finite [s], got {horizon}")
    numbers = limits.arrays(count)
    offset = place - origin
    offset[:, 2] += lift
    chase = _Chase(offset, belt, stroke_time(lift, *numbers), numbers)
    enter, leave = _window_times(place[:, axis], belt[:, axis], window)
    first = np.maximum(enter, np.maximum(finite_rows(earliest, count, "earliest"), 0.0))
    last = np.minimum(leave, horizon)
    return _meet(chase, place, first, last, first <= horizon)


def _meet(chase: _Chase, place: Floats, first: Floats, last: Floats, enters: Bools) -> Intercept:
    open_ = first <= last
    first = np.where(open_, first, 0.0)
    last = np.where(open_, last, 0.0)
    time, reached = _earliest(chase, first, last)
    reason = np.where(reached, int(InterceptReason.FEASIBLE), int(InterceptReason.TOO_LATE))
    reason = np.where(open_, reason, int(InterceptReason.PASSED))
    reason = np.where(enters, reason, int(InterceptReason.NEVER_ENTERS))
    feasible = np.asarray(reason == InterceptReason.FEASIBLE, dtype=np.bool_)
    gap = np.where(feasible, 0.0, np.nan)
    travel = chase.travel(time)
    return Intercept(
        time=time + gap,
        position=place + (time + gap)[:, None] * chase.belt,
        wait=np.where(time > first, 0.0, np.maximum(time - travel - chase.descent, 0.0)) + gap,
        travel=travel + gap,
        descent=chase.descent + gap,
        feasible=feasible,
        reason=reason,
    )


def _window_times(place: Floats, speed: Floats, window: tuple[ArrayLike, ArrayLike]) -> tuple[Floats, Floats]:
    """Times (N,) at which each object enters and leaves the window; infinite for an object that never enters."""
    low = np.broadcast_to(np.asarray(window[0], dtype=np.float64), place.shape)
    high = np.broadcast_to(np.asarray(window[1], dtype=np.float64), place.shape)
    if not (low <= high).all():
        row = int(np.argmin(low <= high))
        raise PlanningError(f"window must run from least to greatest, got {low[row]}, {high[row]}")
    moving = speed != 0.0
    divisor = np.where(moving, speed, 1.0)
    low_time, high_time = (low - place) / divisor, (high - place) / divisor
    inside = (place >= low) & (place <= high)
    enter = np.where(moving, np.minimum(low_time, high_time), np.where(inside, -np.inf, np.inf))
    return enter, np.where(moving, np.maximum(low_time, high_time), np.inf)


def _earliest(chase: _Chase, first: Floats, last: Floats) -> tuple[Floats, Bools]:
    """First time in [first, last] with F <= 0 (N,) [s], and whether there is such a time (N,).

    F falls until the object is closest to the hand, so its sign at that time shows whether F crosses zero
    before. After that time F is sampled, most densely next to it.
    """
    from pnt_gym.planning.motion.chase import earliest  # noqa: PLC0415 - numba takes a while

    end = _latest_meeting(chase, length(chase.belt))
    columns = [*chase.offset.T, *chase.belt.T, chase.descent, *chase.limits, first, last, end]
    time, reached = np.empty(len(end)), np.empty(len(end), dtype=np.bool_)
    earliest(np.stack(columns, axis=-1), time, reached)
    return time, reached


def _latest_meeting(chase: _Chase, speed: Floats) -> Floats:
    """A time (N,) [s] by which the hand has caught an object that is slower than the hand; infinite otherwise.

    T(d) <= d / V + 2 (V / A + A / J) for every d, and the object is never farther away than |offset| + speed t.
    """
    velocity, acceleration, jerk = chase.limits
    peak = np.minimum(np.sqrt(jerk * velocity), acceleration)
    latest = length(chase.offset) / velocity + 2.0 * (velocity / peak + peak / jerk) + chase.descent
    slower = speed < velocity
    return np.where(slower, 1.001 * latest / np.where(slower, 1.0 - speed / velocity, 1.0), np.inf)
