"""The quickest throw from a pick to a target: the exact optimum, one throw at a time or N together.

Hassan et al. 2022, section III, solved by closed forms and one-dimensional root finding instead of a
nonlinear programme. The hand leaves the pick at rest, moves on a straight line along the first half of a
minimum-time S-curve and releases at its middle; the object then flies without drag. The least release
distance is also the least time, with bounds or without. A plan is exact or it is infeasible, never clipped.

The formulas stand twice: for N rows in `optimum`, for one throw in `scalar` and `single`. A
batch of one row takes 0.4 to 2 ms because every numpy call has its price, the plain numbers of `plan_release` take 15
to 19 us; tests hold the two to the same values.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Bools, Floats, Ints, finite_points, finite_rows, length, take
from pnt_gym.errors import PlanningError
from pnt_gym.planning.motion.ballistics import flight_time
from pnt_gym.planning.motion.limits import EllipticWorkspace, LimitRows, Limits, LineBounds
from pnt_gym.planning.motion.scurve import scurves
from pnt_gym.planning.straight.optimum import ThrowPlane, best_slope, bounded_slope, crossing
from pnt_gym.planning.straight.plan import CONTACT, MIN_REACH, Reason, ReleaseBatch
from pnt_gym.planning.straight.single import plan_release

__all__ = ["plan_release", "plan_release_batch", "release_at_elevation", "release_at_point"]

# Rows planned together; few enough for the working arrays to stay in cache.
CHUNK = 4096


class Frame(NamedTuple):
    """Picks (N, 3), azimuths as cosine and sine (N,), and the throws in their planes."""

    picks: Floats
    cosine: Floats
    sine: Floats
    plane: ThrowPlane

    @classmethod
    def of(cls, picks: ArrayLike, targets: ArrayLike, limits: Limits, tolerance: ArrayLike) -> Frame:
        """Check the inputs and lay the throws out; reach is shortened by the tolerance and may be negative.

        Raises:
            ValueError: if an input is not finite, a tolerance is negative, or shapes disagree.
        """
        start = finite_points(picks, "picks")
        count = len(start)
        end = finite_points(targets, "targets", count)
        box = finite_rows(tolerance, count, "tolerance")
        if (box < 0.0).any():
            raise PlanningError(f"tolerance must not be negative [m], got {box.min()}")
        x, y = end[:, 0] - start[:, 0], end[:, 1] - start[:, 1]
        full = np.sqrt(x * x + y * y)
        known = full > 0.0
        divisor = np.where(known, full, 1.0)
        cosine, sine = np.where(known, x / divisor, 1.0), y / divisor
        reach = full - box / np.maximum(np.abs(cosine), np.abs(sine))
        return cls(start, cosine, sine, ThrowPlane(reach, end[:, 2] - start[:, 2], *limits.arrays(count)))


class LineMotion(NamedTuple):
    """What the planners find for each row; numbers in rows without a plan are ignored."""

    direction: Floats
    angle: Floats
    azimuth: Floats
    distance: Floats
    speed: Floats
    flight_time: Floats
    reason: Ints


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
    count = len(frame.picks)
    roof = None if ceiling is None else finite_rows(ceiling, count, "ceiling")
    slope = np.full(count, np.nan)
    moved = np.zeros(count, dtype=np.bool_)
    reason = np.full(count, Reason.NO_REACH, dtype=np.int64)
    rows = np.flatnonzero(frame.plane.reach > MIN_REACH)
    for first in range(0, rows.size, CHUNK):
        part = rows[first : first + CHUNK]
        slope[part], moved[part], reason[part] = _plan_rows(frame, part, roof, workspace)
    motion = _motion(frame, slope, reason)
    height = frame.picks[:, 2] + motion.distance * motion.direction[:, 2]
    roofed = moved if roof is None or workspace is None else moved & (height >= roof - CONTACT)
    roofed = roofed & (roof is not None)
    return _assembled(frame.picks, motion, frame.plane, roofed, moved & ~roofed)


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
    angle = finite_rows(elevation, len(frame.picks), "elevation")
    if (np.abs(angle) >= 0.5 * np.pi).any():
        raise PlanningError(f"elevation must lie in (-pi/2, pi/2) rad, got {angle[np.argmax(np.abs(angle))]}")
    slope = np.tan(angle)
    reason = np.where(frame.plane.line(slope)[1] > 0.0, int(Reason.FEASIBLE), int(Reason.ELEVATION))
    reason = np.where(frame.plane.reach > MIN_REACH, reason, int(Reason.NO_REACH))
    motion = _motion(frame, np.where(reason == Reason.FEASIBLE, slope, np.nan), reason)
    return _assembled(frame.picks, motion._replace(angle=angle), frame.plane)


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
    start = finite_points(picks, "picks")
    count = len(start)
    end = finite_points(points, "points", count)
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
    return _assembled(start, motion, rows)


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
    bounds = LineBounds.below(np.full(len(picks), np.inf) if ceiling is None else ceiling)
    if workspace is not None:
        inside = workspace.line_bounds(picks, frame.cosine[rows], frame.sine[rows])
        bounds = inside._replace(high=np.minimum(inside.high, bounds.high))
    slope = bounded_slope(plane, bounds, best, upward=workspace is not None)
    lost = np.isnan(slope)
    reason = np.full(best.shape, int(Reason.FEASIBLE))
    if lost.any():
        ceiling = None if ceiling is None else ceiling[lost]
        reason[lost] = _blame(take(plane, lost), best[lost], ceiling)
    return slope, slope != best, reason


def _blame(plane: ThrowPlane, best: Floats, ceiling: Floats | None) -> Ints:
    """Of throws without a plan: the ceiling where it alone rules the throw out, else the workspace."""
    if ceiling is None:
        return np.full(best.shape, int(Reason.WORKSPACE))
    alone = bounded_slope(plane, LineBounds.below(ceiling), best, upward=False)
    return np.where(np.isnan(alone), int(Reason.CEILING), int(Reason.WORKSPACE))


def _motion(frame: Frame, slope: Floats, reason: Ints) -> LineMotion:
    """Solve the crossing at ``slope``; rows with NaN stay NaN."""
    gone = np.isnan(slope)
    reachable = np.where(gone, np.abs(frame.plane.reach) + 1.0, frame.plane.reach)
    plane = frame.plane._replace(reach=reachable)
    level = np.where(gone, np.maximum(plane.rise, 0.0) / plane.reach + 1.0, slope)
    distance, speed = crossing(plane, level)
    gap = np.where(gone, np.nan, 0.0)
    cosine = 1.0 / np.sqrt(1.0 + level * level)
    return LineMotion(
        np.stack([cosine * frame.cosine, cosine * frame.sine, cosine * level], axis=1),
        np.arctan(level),
        np.arctan2(frame.sine, frame.cosine),
        distance + gap,
        speed,
        plane.line(level)[1],
        reason,
    )


def _assembled(
    picks: Floats,
    motion: LineMotion,
    limits: LimitRows | ThrowPlane,
    ceiling_active: Bools | None = None,
    workspace_active: Bools | None = None,
) -> ReleaseBatch:
    """Return the batch of plans, NaN in rows whose reason is not FEASIBLE."""
    feasible = motion.reason == Reason.FEASIBLE
    gap = np.where(feasible, 0.0, np.nan)
    distance, speed = motion.distance + gap, motion.speed + gap
    jerk = limits.jerk
    peak = np.minimum(np.sqrt(jerk * speed), limits.acceleration)
    direction = motion.direction + gap[:, None]
    never = np.zeros(feasible.shape, dtype=np.bool_)
    return ReleaseBatch(
        position=picks + distance[:, None] * direction,
        velocity=speed[:, None] * direction,
        direction=direction,
        speed=speed,
        acceleration=peak,
        angle=motion.angle + gap,
        azimuth=motion.azimuth + gap,
        distance=distance,
        # Half of Eq. 4 over the stroke 2 P_r, which is Eq. 12.
        time=distance / speed + 0.5 * (speed / peak + peak / jerk),
        flight_time=motion.flight_time + gap,
        ceiling_active=never if ceiling_active is None else ceiling_active & feasible,
        workspace_active=never if workspace_active is None else workspace_active & feasible,
        feasible=feasible,
        reason=motion.reason,
        straight=~never,
    )
