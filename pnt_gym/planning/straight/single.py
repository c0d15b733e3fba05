"""``plan_release``: one throw in plain floats."""

from __future__ import annotations

import math

import numpy as np

from pnt_gym.arrays import Point
from pnt_gym.constants import GRAVITY
from pnt_gym.errors import PlanningError
from pnt_gym.planning.motion.limits import EllipticWorkspace, MotionLimits
from pnt_gym.planning.straight.plan import CONTACT, MIN_REACH, InfeasibleThrow, Reason, Release
from pnt_gym.planning.straight.scalar import Box, PlaneThrow, best_slope, bounded_slope, crossing

_Triple = tuple[float, float, float]


def plan_release(
    pick: Point,
    target: Point,
    limits: MotionLimits,
    ceiling: float | None = None,
    tolerance: float = 0.0,
    workspace: EllipticWorkspace | None = None,
) -> Release:
    """Return the quickest throw from ``pick`` to ``target``.

    Args:
        pick: start of the hand at rest (3,) [m].
        target: point the object must pass through on its way down (3,) [m].
        limits: largest speed, acceleration and jerk of the hand.
        ceiling: greatest height z of the release point [m]; None for no bound.
        tolerance: half width of the square box around the target that counts as hit [m]; the throw is
            shortened to the near side of the box along the line of throw (Hassan et al. 2022, Eqs. 16-17).
        workspace: where the release point must lie; None for no bound.

    Raises:
        InfeasibleThrow: if no throw exists; a target straight above or below the pick has none.
        ValueError: if an input is NaN or infinite, or the tolerance is negative.
    """
    start, end = point_of(pick, "pick"), point_of(target, "target")
    _check(ceiling, tolerance)
    x, y = end[0] - start[0], end[1] - start[1]
    full = math.sqrt(x * x + y * y)
    cosine, sine = (x / full, y / full) if full > 0.0 else (1.0, 0.0)
    reach = full - tolerance / max(abs(cosine), abs(sine))
    if reach <= MIN_REACH:
        raise InfeasibleThrow(Reason.NO_REACH, f" (pick {start}, target {end})")
    throw = PlaneThrow(reach, end[2] - start[2], *limits.numbers())
    slope = best = best_slope(throw)
    high = math.inf if ceiling is None else ceiling - start[2]
    if ceiling is not None or workspace is not None:
        box = _box(start, (cosine, sine), high, workspace)
        found = bounded_slope(throw, box, best, upward=workspace is not None)
        if found is None:
            raise _infeasible(throw, best, high, ceiling, workspace)
        slope = found
    level = 1.0 / math.sqrt(1.0 + slope * slope)
    direction = (level * cosine, level * sine, level * slope)
    distance, speed = crossing(throw, slope)
    roofed = slope != best and distance * direction[2] >= high - CONTACT
    active = (roofed, slope != best and not roofed)
    return _release(start, direction, (throw, slope), (distance, speed), active)


def _release(
    start: _Triple,
    direction: _Triple,
    line: tuple[PlaneThrow, float],
    motion: tuple[float, float],
    active: tuple[bool, bool],
) -> Release:
    throw, slope = line
    distance, speed = motion
    peak = min(math.sqrt(throw.jerk * speed), throw.acceleration)
    unit = np.array(direction)
    return Release(
        position=np.array(start) + distance * unit,
        velocity=speed * unit,
        direction=unit,
        speed=speed,
        acceleration=peak,
        angle=math.atan(slope),
        azimuth=math.atan2(direction[1], direction[0]),
        distance=distance,
        time=distance / speed + 0.5 * (speed / peak + peak / throw.jerk),
        flight_time=math.sqrt(2.0 * (throw.reach * slope - throw.rise) / GRAVITY),
        ceiling_active=active[0],
        workspace_active=active[1],
    )


def _box(start: _Triple, azimuth: tuple[float, float], high: float, workspace: EllipticWorkspace | None) -> Box:
    if workspace is None:
        return Box(0.0, math.inf, -math.inf, high)
    cosine, sine = (np.array([value]) for value in azimuth)
    near, far, low, top = (float(bound[0]) for bound in workspace.line_bounds(np.array([start]), cosine, sine))
    return Box(near, far, low, min(top, high))


def _infeasible(
    throw: PlaneThrow, best: float, high: float, ceiling: float | None, workspace: EllipticWorkspace | None
) -> InfeasibleThrow:
    """Blame the ceiling where it alone rules the throw out, else the workspace."""
    if ceiling is not None:
        alone = bounded_slope(throw, Box(0.0, math.inf, -math.inf, high), best, upward=False)
        if alone is None:
            return InfeasibleThrow(Reason.CEILING, f" z = {ceiling} m")
    return InfeasibleThrow(Reason.WORKSPACE, f" {workspace}")


def point_of(values: Point, name: str) -> _Triple:
    """Three coordinates as floats; a ValueError that names them where there are not three."""
    if len(values) != 3:
        raise PlanningError(f"{name} must hold three coordinates, got {len(values)}")
    x, y, z = float(values[0]), float(values[1]), float(values[2])
    if not math.isfinite(x + y + z):
        raise PlanningError(f"{name} must be finite, got {(x, y, z)}")
    return x, y, z


def _check(ceiling: float | None, tolerance: float) -> None:
    if ceiling is not None and not math.isfinite(ceiling):
        raise PlanningError(f"ceiling must be finite, or None for no bound, got {ceiling}")
    if not (math.isfinite(tolerance) and tolerance >= 0.0):
        raise PlanningError(f"tolerance must be finite and not negative [m], got {tolerance}")
