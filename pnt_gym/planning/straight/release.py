"""The quickest throw from a pick to a target: the exact optimum, one throw at a time or N together.

Hassan et al. 2022, section III, solved by closed forms and one-dimensional root finding instead of a
nonlinear programme. The hand leaves the pick at rest, moves on a straight line along the first half of a
minimum-time S-curve and releases at its middle; the object then flies without drag. The least release
distance is also the least time, with bounds or without. A plan is exact or infeasible, never clipped.

`kernel` holds the formulas, compiled; a single throw is a batch of one row there, so that a throw and a batch give the
same bits.
"""

from __future__ import annotations

import math
from typing import Any, Final, cast

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats, Point, finite_points, finite_rows, number, of_kind
from pnt_gym.errors import PlanningError
from pnt_gym.planning.motion.ballistics import flight_time
from pnt_gym.planning.motion.limits import EllipticWorkspace, LimitRows, Limits, LineBounds, MotionLimits, limit_rows
from pnt_gym.planning.straight import kernel
from pnt_gym.planning.straight.frame import Frame, check_throws, point_of
from pnt_gym.planning.straight.plan import InfeasibleThrow, Reason, Release, ReleaseBatch
from pnt_gym.planning.straight.rows import Throw, ThrowLine
from pnt_gym.rows import Rows

__all__ = [
    "plan_release",
    "plan_release_batch",
    "release_at_elevation",
    "release_at_point",
]


PIECE: Final = 20_000
"""Throws per call of machine code: a tenth of a second, during which Ctrl-C has no effect."""
OPEN: Final = Throw.zeros(1, ceiling=math.inf, far=math.inf, low=-math.inf, high=math.inf)
"""A throw without bounds."""
NO_BOUNDS: Final = LineBounds(*[OPEN[name] for name in LineBounds._fields])
"""Bounds of the line of such a throw."""


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
        tolerance: half width of the square box around the target in which a landing counts as a hit [m]; the throw
            is shortened to the near side of the box along the line of throw (Hassan et al. 2022, Eqs. 16-17).
        workspace: region that must contain the release point; None for no bound.

    Raises:
        InfeasibleThrow: if no throw exists; for a target straight above or below the pick none exists.
        ValueError: if an input is NaN or infinite, or the tolerance is negative.
    """
    start, end = point_of(pick, "pick"), point_of(target, "target")
    check_bounds(ceiling, tolerance)
    bounds = NO_BOUNDS if workspace is None else _line_bounds([start], [end], workspace)
    roof, numbers = math.inf if ceiling is None else ceiling, of_kind(limits, MotionLimits, "limits").numbers()
    throw = start, end, *numbers, tolerance, roof, *[bound.item() for bound in bounds]
    plans = _plan_throws(cast("Rows[Throw]", np.array([throw], Throw.dtype)), has_workspace=workspace is not None)
    reason = Reason(plans["reason"].item())
    if reason != Reason.FEASIBLE:
        details = {Reason.NO_REACH: f" (pick {start}, target {end})", Reason.CEILING: f" z = {ceiling} m"}
        raise InfeasibleThrow(reason, details.get(reason, f" {workspace}"))
    return ReleaseBatch(plans).row(0)


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
    start, end, box = check_throws(picks, targets, tolerance)
    rows = limit_rows(limits, len(start))
    roof = math.inf if ceiling is None else finite_rows(ceiling, len(start), "ceiling")
    bounds = {} if workspace is None else _line_bounds(start, end, workspace)._asdict()
    throws = _lay_out(start, end, rows, tolerance=box, ceiling=roof, **bounds)
    return ReleaseBatch(_plan_throws(throws, has_workspace=workspace is not None))


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
    start, end, zero = check_throws(picks, targets, 0.0)
    angle = finite_rows(elevation, len(start), "elevation")
    if (np.abs(angle) >= 0.5 * np.pi).any():
        raise PlanningError(f"elevation must lie in (-pi/2, pi/2) rad, got {angle[np.argmax(np.abs(angle))]}")
    return aim_lines(start, end, limit_rows(limits, len(zero)), angle)


def aim_lines(picks: Floats, targets: Floats, limits: LimitRows, elevation: Floats) -> ReleaseBatch:
    """Return the throws as `release_at_elevation`, for arrays that need no check."""
    lines = ThrowLine.zeros(len(picks), slope=np.tan(elevation))
    plans = kernel.release_rows(_lay_out(picks, targets, limits), False, True, lines)
    plans["angle"] = np.where(plans["feasible"], elevation, np.nan)
    return ReleaseBatch(plans)


def lower_elevation(picks: Floats, targets: Floats, limits: LimitRows, elevation: Floats, top: Floats) -> Floats:
    """Return the largest elevations (N,) [rad] below given ones at which throws release at most at heights (N,) [m]."""
    return kernel.lower_angles(_lay_out(picks, targets, limits), elevation, top)


def release_at_point(
    picks: ArrayLike, points: ArrayLike, limits: Limits, plane_z: ArrayLike | None = None
) -> ReleaseBatch:
    """Return the throws that release at ``points`` (N, 3) with all the speed the S-curve gives there.

    Args:
        picks: starts of the hand at rest (N, 3) [m].
        points: release points (N, 3) [m]; the object leaves along pick to point.
        limits: largest speed, acceleration and jerk of the hand.
        plane_z: height of the plane through which the object comes down [m], one number or (N,); if None,
            ``flight_time`` is NaN.

    Returns:
        The plans; a row is infeasible where point and pick coincide or the plane is never reached.

    Raises:
        ValueError: if an input is NaN or infinite, or shapes disagree.
    """
    start = finite_points(picks, "picks")
    end = finite_points(points, "points", len(start))
    rows = kernel.release_at_points(_lay_out(start, end, limit_rows(limits, len(start))))
    if plane_z is not None:
        rows["flight_time"] = flight_time(end, rows["velocity"], finite_rows(plane_z, len(start), "plane_z"))
        lost = rows["feasible"] & np.isnan(rows["flight_time"])
        rows[lost] = kernel.release_at_points(OPEN)  # which plans nothing
        rows["reason"][lost] = Reason.PLANE
    return ReleaseBatch(rows)


def check_bounds(ceiling: float | None, tolerance: float) -> None:
    """Make sure that a ceiling is finite or None, and a tolerance finite and not negative.

    Raises:
        ValueError: one of them is not.
    """
    if ceiling is not None and not math.isfinite(number(ceiling, "ceiling")):
        raise PlanningError(f"ceiling must be finite, or None for no bound, got {ceiling}")
    if not 0.0 <= number(tolerance, "tolerance") < math.inf:
        raise PlanningError(f"tolerance must be finite and not negative [m], got {tolerance}")


def _line_bounds(picks: ArrayLike, targets: ArrayLike, workspace: EllipticWorkspace) -> LineBounds:
    frame = Frame.of(picks, targets)
    return of_kind(workspace, EllipticWorkspace, "workspace").line_bounds(frame.picks, frame.cosine, frame.sine)


def _lay_out(picks: Any, targets: Any, limits: tuple[Any, Any, Any], **bounds: Any) -> Rows[Throw]:
    """Throws with limits (velocity, acceleration, jerk), and with bounds by the names of the fields of `Throw`."""
    velocity, acceleration, jerk = limits
    throws = cast("Rows[Throw]", OPEN.repeat(len(picks)))
    motion = {"pick": picks, "target": targets, "velocity": velocity, "acceleration": acceleration, "jerk": jerk}
    for name, values in (motion | bounds).items():
        throws[name] = values
    return throws


def _plan_throws(throws: Rows[Throw], *, has_workspace: bool) -> Rows[ReleaseBatch]:
    """Plan the throws along the quickest lines."""
    begins = range(0, max(len(throws), 1), PIECE)
    pieces = [kernel.choose_slopes(throws[begin : begin + PIECE], has_workspace) for begin in begins]
    lines: Any = pieces[0] if len(pieces) == 1 else np.concatenate(pieces)
    return kernel.release_rows(throws, has_workspace, True, lines)
