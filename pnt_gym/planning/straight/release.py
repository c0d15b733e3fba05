"""The quickest throw from a pick to a target: the exact optimum, one throw at a time or N together.

Hassan et al. 2022, section III, solved by closed forms and one-dimensional root finding instead of a
nonlinear programme. The hand leaves the pick at rest, moves on a straight line along the first half of a
minimum-time S-curve and releases at its middle; the object then flies without drag. The least release
distance is also the least time, with bounds or without. A plan is exact or it is infeasible, never clipped.

The formulas stand twice: for N rows in `crossing`, `optimum` and `bounded`, for one throw in `scalar` and `single`. A
batch of one row takes 0.4 to 2 ms because every numpy call has its price, the plain numbers of `plan_release` take 15
to 19 us; tests hold the two to the same values.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Bools, Floats, Ints, finite_points, finite_rows, length, same_count, take
from pnt_gym.errors import PlanningError
from pnt_gym.planning.motion.ballistics import flight_time
from pnt_gym.planning.motion.limits import Limits
from pnt_gym.planning.motion.scurve import scurves
from pnt_gym.planning.motion.workspace import EllipticWorkspace
from pnt_gym.planning.straight.bounded import Bounds, bounded_slope
from pnt_gym.planning.straight.crossing import ThrowPlane, crossing
from pnt_gym.planning.straight.frame import Frame, LineMotion, assemble
from pnt_gym.planning.straight.optimum import best_slope
from pnt_gym.planning.straight.plan import CONTACT, MIN_REACH, Reason, ReleaseBatch
from pnt_gym.planning.straight.single import plan_release

__all__ = ["plan_release", "plan_release_batch", "release_at_elevation", "release_at_point"]

# Rows planned together; few enough for the working arrays to stay in cache.
CHUNK = 4096


def plan_release_batch(
    picks: ArrayLike,
    targets: ArrayLike,
    limits: Limits,
    ceiling: ArrayLike | None = None,
    tolerance: ArrayLike = 0.0,
    workspace: EllipticWorkspace | None = None,
) -> ReleaseBatch:
    """Return the quickest throws from ``picks`` (N, 3) to ``targets`` (N, 3) [m]; see ``plan_release``.

    ``ceiling`` and ``tolerance`` may be one number or (N,), and so may the fields of ``limits``. Rows without
    a throw are NaN with ``feasible`` False and a ``reason``. A row's result does not depend on the other
    rows.

    Raises:
        ValueError: if an input is NaN or infinite, a tolerance is negative, or shapes disagree.
    """
    frame = Frame.of(picks, targets, limits, tolerance)
    roof = None if ceiling is None else finite_rows(ceiling, frame.size, "ceiling")
    slope = np.full(frame.size, np.nan)
    moved = np.zeros(frame.size, dtype=np.bool_)
    reason = np.full(frame.size, Reason.NO_REACH, dtype=np.int64)
    rows = np.flatnonzero(frame.plane.reach > MIN_REACH)
    for first in range(0, rows.size, CHUNK):
        part = rows[first : first + CHUNK]
        slope[part], moved[part], reason[part] = _plan_rows(frame, part, roof, workspace)
    motion = _motion(frame, slope, reason)
    height = frame.picks[:, 2] + motion.distance * motion.direction[:, 2]
    roofed = moved if roof is None or workspace is None else moved & (height >= roof - CONTACT)
    roofed = roofed & (roof is not None)
    return assemble(frame.picks, motion, frame.limits, roofed, moved & ~roofed)


def release_at_elevation(picks: ArrayLike, targets: ArrayLike, limits: Limits, elevation: ArrayLike) -> ReleaseBatch:
    """Return the throws from ``picks`` (N, 3) to ``targets`` (N, 3) along lines of given elevation.

    Args:
        picks: starts of the hand at rest (N, 3) [m].
        targets: points the objects must pass through (N, 3) [m].
        limits: largest speed, acceleration and jerk of the hand.
        elevation: angle of the line above the horizontal in (-pi/2, pi/2) [rad], one number or (N,).

    Returns:
        The plans; a row is infeasible where the line does not pass above the target.

    Raises:
        ValueError: if an input is NaN or infinite, an elevation is out of range, or shapes disagree.
    """
    frame = Frame.of(picks, targets, limits, 0.0)
    angle = finite_rows(elevation, frame.size, "elevation")
    if (np.abs(angle) >= 0.5 * np.pi).any():
        raise PlanningError(f"elevation must lie in (-pi/2, pi/2) rad, got {angle[np.argmax(np.abs(angle))]}")
    slope = np.tan(angle)
    reason = np.where(frame.plane.line(slope)[1] > 0.0, int(Reason.FEASIBLE), int(Reason.ELEVATION))
    reason = np.where(frame.plane.reach > MIN_REACH, reason, int(Reason.NO_REACH))
    motion = _motion(frame, np.where(reason == Reason.FEASIBLE, slope, np.nan), reason)
    return assemble(frame.picks, motion._replace(angle=angle), frame.limits)


def release_at_point(
    picks: ArrayLike, points: ArrayLike, limits: Limits, plane_z: ArrayLike | None = None
) -> ReleaseBatch:
    """Return the throws that release at ``points`` (N, 3) with all the speed the S-curve gives there.

    Args:
        picks: starts of the hand at rest (N, 3) [m].
        points: release points (N, 3) [m]; the object leaves along pick to point.
        limits: largest speed, acceleration and jerk of the hand.
        plane_z: height of the plane the object is to come down through [m], one number or (N,); without it
            ``flight_time`` is NaN.

    Returns:
        The plans; a row is infeasible where point and pick coincide or the plane is never reached.

    Raises:
        ValueError: if an input is NaN or infinite, or shapes disagree.
    """
    start, end = finite_points(picks, "picks"), finite_points(points, "points")
    count = start.shape[0]
    same_count("picks", count, "points", end.shape[0])
    way = end - start
    distance = length(way)
    apart = distance > MIN_REACH
    direction = way / np.where(apart, distance, 1.0)[:, None]
    rows = limits.arrays(count)
    speed = scurves(2.0 * distance, rows).velocity
    reason = np.where(apart, int(Reason.FEASIBLE), int(Reason.SAME_POINT))
    flight = np.full(count, np.nan)
    if plane_z is not None:
        plane = finite_rows(plane_z, count, "plane_z")
        flight = flight_time(end, speed[:, None] * direction, plane)
        reason = np.where(apart & np.isnan(flight), int(Reason.PLANE), reason)
    flat = np.sqrt(way[:, 0] * way[:, 0] + way[:, 1] * way[:, 1])
    angle, azimuth = np.arctan2(way[:, 2], flat), np.arctan2(way[:, 1], way[:, 0])
    motion = LineMotion(direction, angle, azimuth, distance, speed, flight, reason)
    return assemble(start, motion, rows)


def _plan_rows(
    frame: Frame, rows: Ints, roof: Floats | None, workspace: EllipticWorkspace | None
) -> tuple[Floats, Bools, Ints]:
    """Slope, whether a bound moved it, and reason of the rows given."""
    plane = take(frame.plane, rows)
    best = best_slope(plane)
    if roof is None and workspace is None:
        return best, np.zeros(best.shape, dtype=np.bool_), np.full(best.shape, int(Reason.FEASIBLE))
    picks = frame.picks[rows]
    ceiling = None if roof is None else roof[rows] - picks[:, 2]
    bounds = _bounds(picks, frame.cosine[rows], frame.sine[rows], ceiling, workspace)
    slope = bounded_slope(plane, bounds, best, upward=workspace is not None)
    lost = np.isnan(slope)
    reason = np.where(lost, _blame(plane, best, lost, ceiling), int(Reason.FEASIBLE))
    return slope, slope != best, reason


def _bounds(
    picks: Floats, cosine: Floats, sine: Floats, ceiling: Floats | None, workspace: EllipticWorkspace | None
) -> Bounds:
    high = np.full(picks.shape[0], np.inf) if ceiling is None else ceiling
    if workspace is None:
        zero = np.zeros_like(high)
        return Bounds(zero, zero + np.inf, zero - np.inf, high)
    near, far, low, top = workspace.line_bounds(picks, cosine, sine)
    return Bounds(near, far, low, np.minimum(top, high))


def _blame(plane: ThrowPlane, best: Floats, lost: Bools, ceiling: Floats | None) -> Ints:
    """The ceiling where it alone rules the throw out, else the workspace."""
    reason = np.full(lost.shape, int(Reason.WORKSPACE))
    if ceiling is None or not lost.any():
        return reason
    zero = np.zeros_like(ceiling)[lost]
    bounds = Bounds(zero, zero + np.inf, zero - np.inf, ceiling[lost])
    alone = bounded_slope(take(plane, lost), bounds, best[lost], upward=False)
    reason[lost] = np.where(np.isnan(alone), int(Reason.CEILING), int(Reason.WORKSPACE))
    return reason


def _motion(frame: Frame, slope: Floats, reason: Ints) -> LineMotion:
    """Solve the crossing at ``slope``; rows with NaN stay NaN."""
    gone = np.isnan(slope)
    reachable = np.where(gone, np.abs(frame.plane.reach) + 1.0, frame.plane.reach)
    plane = frame.plane._replace(reach=reachable)
    level = np.where(gone, np.maximum(plane.rise, 0.0) / plane.reach + 1.0, slope)
    distance, speed = crossing(plane, level)
    gap = np.where(gone, np.nan, 0.0)
    return LineMotion(
        frame.directions(level),
        np.arctan(level),
        np.arctan2(frame.sine, frame.cosine),
        distance + gap,
        speed,
        plane.line(level)[1],
        reason,
    )
