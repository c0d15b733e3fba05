"""The best motion of a family for each of N releases."""

from __future__ import annotations

from typing import Final, Literal, NamedTuple

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, concatenate_records, replace_rows, take
from pnt_gym.planning.one_joint.grasp import acceleration_window, braking_acceleration
from pnt_gym.planning.one_joint.margins import STATIC_ROOM, motion_margins, state_margins
from pnt_gym.planning.one_joint.motion import ArmMotion
from pnt_gym.planning.one_joint.parameters import Arm, Block
from pnt_gym.planning.one_joint.shapes import BACKSWINGS, INTERVALS, RISES, Family
from pnt_gym.planning.one_joint.weights import WEIGHTS

Objective = Literal["squares", "max_min"]
"""Criterion of the choice of motions: Eq. 28 ("squares"), or the smallest margin of grasp and torque ("max_min")."""

DURATIONS: Final = 6
"""Durations tried for each shape."""
REFINEMENTS: Final = 9
"""Durations tried around the best one."""
FINE: Final = 3
"""Samples per interval during the refinement; the first choice has one sample, the final check runs at 1 kHz."""
CHUNK: Final = 16
"""Rows computed together, so that their arrays stay in the cache."""
SAFE: Final = 1e-6
"""Smallest margin at which a limit counts as kept."""
QUICKEST_SWING: Final = 0.5
"""Shortest duration of a motion that swings back, as a share of the longest one."""
START_ROUNDING: Final = 1e-9
"""Tolerance of the start angle outside the angles at which the block rests [rad]."""
FORCED: Final = (0, 1, 2, 5)
"""Indices of the margins that the motion determines and the release does not: grasp and torque."""


class Task(NamedTuple):
    """N releases, with arm, block and the criterion for motions to the releases."""

    u: Floats
    radius: Floats
    arm: Arm
    block: Block
    objective: Objective = "max_min"
    weights: tuple[float, ...] = WEIGHTS["balanced"]
    static_start: bool = True


class _Choice(NamedTuple):
    """A shape of the family and a duration for each row (N,)."""

    shape: Ints
    duration: Floats


class _Course(NamedTuple):
    """Factor of the lift in each motion (...,) [rad/s2], and the start angle (...,) [rad]."""

    peak: Floats
    start: Floats


def best_motions(task: Task, family: Family = RISES) -> tuple[ArmMotion, Floats]:
    """Return the best motion of a family for each release and its margins at 1 kHz (N, 6).

    Where no motion rises within every limit, the arm swings back first. A row without a motion that keeps every limit
    gets a motion that breaks some limit, with margins below `SAFE`.
    """
    chunks = range(0, max(task.radius.size, 1), CHUNK)
    shape, duration = concatenate_records([_choose(take(task, slice(k, k + CHUNK)), family) for k in chunks])
    course = _course(task, family, shape, duration)
    accelerations = course.peak[:, None] * family.lift.values[shape]
    if family.base is not None:
        accelerations = accelerations + family.base.values[shape]
    brake = braking_acceleration(task.u[:, 1], task.arm)
    motion = ArmMotion.of(course.start, duration / INTERVALS, accelerations, brake)
    margins = motion_margins(motion, task.radius, task.arm, task.block)
    missing = np.nonzero(~keeps_limits(margins))[0]
    if missing.size and family is RISES:
        swings, swing_margins = best_motions(take(task, missing), BACKSWINGS)
        motion, margins = replace_rows(motion, missing, swings), replace_rows(margins, missing, swing_margins)
    return motion, margins


def keeps_limits(margins: Floats) -> Bools:
    """Return whether a row's six margins (N, 6) are all kept (N,)."""
    return margins.min(axis=1, initial=np.inf) >= SAFE


def _choose(task: Task, family: Family) -> _Choice:
    low, high = _duration_range(task, family)
    share = (np.arange(DURATIONS) + 0.5) / DURATIONS
    duration = low[..., None] * (high / low)[..., None] ** share
    shapes = np.broadcast_to(np.arange(family.size, dtype=np.int64)[:, None], duration.shape)
    score = _score(task, family, shapes, duration)
    rows: Ints = np.arange(low.shape[0], dtype=np.int64)
    best = score.reshape(rows.size, family.size * DURATIONS).argmax(axis=1)
    shape = (best // DURATIONS).astype(np.int64)
    low, high = low[rows, shape][:, None], high[rows, shape][:, None]
    around = np.linspace(-1.0, 1.0, REFINEMENTS) / DURATIONS
    duration = duration.reshape(rows.size, -1)[rows, best][:, None] if rows.size else np.zeros((0, 1))
    duration = np.clip(duration * (high / low) ** around, low, high)
    score = _score(task, family.with_samples(FINE), np.broadcast_to(shape[:, None], duration.shape), duration)
    return _Choice(shape, duration[rows, score.argmax(axis=1)])


def _duration_range(task: Task, family: Family) -> tuple[Floats, Floats]:
    """Shortest and longest durations (N, K) worth trying."""
    longest = task.arm.time_step * INTERVALS
    if family.base is not None:
        high = np.full((task.radius.size, family.size), longest)
        return QUICKEST_SWING * high, high
    angle, speed = task.u[:, 0, None], task.u[:, 1, None]
    window = acceleration_window(task.u[:, 0], task.u[:, 1], task.radius, task.arm, task.block)
    # At the release the acceleration is speed * last / (gain * duration).
    rate = speed * family.lift.last / family.lift.gain
    low = rate / np.maximum(window.high, 1e-3)[:, None]
    high = np.minimum(rate / np.maximum(window.low, 1e-3)[:, None], longest)
    turn = speed * family.lift.way / family.lift.gain
    room = np.maximum(angle - _start_range(task)[0], 0.0)
    high = np.maximum(np.minimum(high, room / turn), 1e-3)
    return np.minimum(low, high), high


def _start_range(task: Task) -> tuple[float, float]:
    """Least and greatest start angle of the arm [rad]."""
    low, high = task.arm.angle
    if not task.static_start:
        return low, high
    block = task.block
    tip = np.arctan2(block.half_length, block.half_height) if block.half_height > 0.0 else 0.5 * np.pi
    # cos(t) - h sin(t) = STATIC_ROOM, solved for t.
    scale = np.hypot(1.0, block.half_height / block.half_length)
    limit = float(tip - np.arcsin(STATIC_ROOM / scale))
    return max(low, -limit), min(high, limit)


def _course(task: Task, family: Family, shape: Ints, duration: Floats) -> _Course:
    """Lift factors and start angles of the motions with given shapes and durations (N, ...) that end in the release.

    With duration T, base gain g0 and way w0, lift gain g1 and way w1, the factor is p = (omega_t / T - g0) / g1 and the
    start angle theta_t - T^2 (w0 + p w1).
    """
    index = (slice(None),) + (None,) * (duration.ndim - 1)
    angle, speed = task.u[:, 0][index], task.u[:, 1][index]
    missing, base_way = speed / duration, 0.0
    if family.base is not None:
        missing, base_way = missing - family.base.gain[shape], family.base.way[shape]
    peak = missing / family.lift.gain[shape]
    return _Course(peak, angle - duration * duration * (base_way + peak * family.lift.way[shape]))


def _score(task: Task, family: Family, shape: Ints, duration: Floats) -> Floats:
    """Score of the motions with given shapes and durations (N, ...); negative where a limit is not kept."""
    course = _course(task, family, shape, duration)
    peak, time = course.peak[..., None], duration[..., None]
    lift, base = family.lift, family.base
    rate, speed, way = (peak * table[shape] for table in (lift.accelerations, lift.speeds, lift.angles))
    if base is not None:
        rate, speed, way = rate + base.accelerations[shape], speed + base.speeds[shape], way + base.angles[shape]
    radius = task.radius[(slice(None),) + (None,) * duration.ndim]
    margins = state_margins(
        course.start[..., None] + time * time * way, time * speed, rate, radius, task.arm, task.block
    )
    least = [margin.min(axis=-1) for margin in margins]
    worst = np.minimum.reduce(least)
    if task.objective == "max_min":
        worth = np.minimum.reduce([least[k] for k in FORCED])
    else:
        worth = sum((w * m * m for w, m in zip(task.weights, least, strict=True)), np.zeros_like(worst))
    first, last = _start_range(task)
    outside = np.maximum(first - course.start, course.start - last)
    # A motion that breaks a limit scores below 0, the lower the more it breaks the limit.
    worth = np.where(worst < SAFE, worst - SAFE, worth)
    return np.where(outside > START_ROUNDING, np.minimum(worth, 0.0) - 1.0 - outside, worth)
