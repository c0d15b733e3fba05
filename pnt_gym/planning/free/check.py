"""Check of limits and rules for motions of constant-jerk pieces, at the extremes instead of at fine samples.

Jerk is constant in a piece and acceleration linear; speed is bounded by its Bernstein coefficients; heights, and the
gap between hand and falling object, are cubics with closed-form stationary points. Only the time at which the hand
comes clear of the object sideways is read from samples, on the cautious side.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from pnt_gym.arrays import Bools, Floats, length
from pnt_gym.constants import GRAVITY
from pnt_gym.planning.free.rules import TOLERANCE, HandRules
from pnt_gym.planning.motion.limits import Limits
from pnt_gym.planning.motion.trajectory import JerkTrajectory

SINK: Final = 0.002
"""Distance that the hand may sink below a floor between two borders of pieces [m]."""
POINTS: Final = 8
"""Samples per piece of the hand's horizontal place."""


def keeps_rules(
    path: JerkTrajectory,
    release_time: Floats,
    limits: Limits,
    roof: Floats,
    rules: HandRules,
    floor: tuple[Floats, Floats],
) -> Bools:
    """Return whether motions (N,) keep limits and rules.

    Args:
        path: N motions.
        release_time: time of the release (N,) [s], at a border of two pieces.
        limits: limits of the norms.
        roof: greatest height of the hand (N,) [m].
        rules: rules of the hand.
        floor: least height before and after the release, (N,) each [m].
    """
    height = _extremes(*_cubic(path, 2), path.durations)
    after = path.knot_times[:, :-1] >= release_time[:, None] - 1e-12
    low = np.where(after, floor[1][:, None], floor[0][:, None]) - SINK
    velocity, acceleration, jerk = limits.arrays(len(path.start))
    knots = path.knots
    # Velocity is quadratic in a segment, so its size is at most that of its three Bezier points.
    middle = knots.velocity[:, :-1] + 0.5 * path.durations[..., None] * knots.acceleration[:, :-1]
    fastest = np.maximum(length(knots.velocity).max(axis=1), length(middle).max(axis=1))
    hardest = length(knots.acceleration).max(axis=1)
    sharpest = np.where(path.durations > 0.0, length(path.jerks), 0.0).max(axis=1)
    worst = np.maximum(np.maximum(fastest / velocity, hardest / acceleration), sharpest / jerk)
    good = np.asarray(worst <= 1.0 + TOLERANCE) & (height[1].max(axis=1) <= roof + TOLERANCE)
    good &= (height[0] >= low).all(axis=1) & _stays_above_object(path, release_time, rules, after)
    if rules.workspace is not None:
        good &= rules.workspace.contains(_positions(path)).all(axis=(1, 2))
    return good


def _stays_above_object(path: JerkTrajectory, release_time: Floats, rules: HandRules, after: Bools) -> Bools:
    """Whether each hand stays above its object by the margin until the hand is clear of the object sideways (N,)."""
    release = path.sample(release_time[:, None])
    start, velocity = release.position[:, 0], release.velocity[:, 0]
    since = path.knot_times[:, :-1] - release_time[:, None]
    fall = (1.0 - rules.margin) * GRAVITY
    c0, c1, c2, c3 = _cubic(path, 2)
    gap = (
        c0 - start[:, 2:] - since * velocity[:, 2:] + 0.5 * fall * since**2,
        c1 - velocity[:, 2:] + fall * since,
        c2 + 0.5 * fall,
        c3,
    )
    # A piece is checked unless the hand was clear at a sample of an earlier piece.
    times = since[..., None] + path.durations[..., None] * np.linspace(0.0, 1.0, POINTS)
    away = _positions(path)[..., :2] - start[:, None, None, :2] - times[..., None] * velocity[:, None, None, :2]
    clear = (away[..., 0] ** 2 + away[..., 1] ** 2 >= rules.clear_distance**2) & after[..., None]
    was_clear = np.logical_or.accumulate(clear.any(axis=2), axis=1)
    near = after & ~np.concatenate([np.zeros_like(was_clear[:, :1]), was_clear[:, :-1]], axis=1)
    # The piece in which the hand comes clear is checked up to that sample.
    first = np.where(clear.any(axis=2), clear.argmax(axis=2), POINTS - 1) / (POINTS - 1.0)
    least = _extremes(*gap, path.durations * first)[0]
    return np.asarray(np.where(near, least, 0.0).min(axis=1) >= -TOLERANCE)


def _cubic(path: JerkTrajectory, axis: int) -> tuple[Floats, Floats, Floats, Floats]:
    """Coefficients (N, K) of a coordinate's cubic over the time in each piece, constant first."""
    knots = path.knots
    return (
        knots.position[:, :-1, axis],
        knots.velocity[:, :-1, axis],
        knots.acceleration[:, :-1, axis] / 2.0,
        path.jerks[..., axis] / 6.0,
    )


def _extremes(c0: Floats, c1: Floats, c2: Floats, c3: Floats, duration: Floats) -> tuple[Floats, Floats]:
    """Least and greatest value (N, K) of cubics c0 + c1 t + c2 t^2 + c3 t^3 on [0, duration]."""
    # Roots of c1 + 2 c2 t + 3 c3 t^2 in the form that does not cancel.
    root = np.sqrt(np.maximum(c2 * c2 - 3.0 * c1 * c3, 0.0))
    q = -(c2 + np.where(c2 >= 0.0, root, -root))
    with np.errstate(divide="ignore", invalid="ignore"):
        times = np.stack([q / (3.0 * c3), c1 / q, duration, 0.0 * duration])
    times = np.clip(np.nan_to_num(times, nan=0.0, posinf=0.0, neginf=0.0), 0.0, duration)
    values = c0 + times * (c1 + times * (c2 + times * c3))
    return values.min(axis=0), values.max(axis=0)


def _positions(path: JerkTrajectory) -> Floats:
    """Positions (N, K, M, 3) [m] at M points of every piece, both ends included."""
    t = (path.durations[:, :, None] * np.linspace(0.0, 1.0, POINTS))[..., None]
    position, velocity, acceleration = (part[:, :-1, None] for part in path.knots)
    return position + t * (velocity + 0.5 * t * (acceleration + t * path.jerks[:, :, None] / 3.0))
