"""N throws laid into their vertical planes, and plans put back into space."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Bools, Floats, Ints, finite_points, finite_rows, same_count
from pnt_gym.errors import PlanningError
from pnt_gym.planning.motion.limits import LimitRows, Limits
from pnt_gym.planning.straight.crossing import ThrowPlane
from pnt_gym.planning.straight.plan import Reason, ReleaseBatch


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
        start, end = finite_points(picks, "picks"), finite_points(targets, "targets")
        count = start.shape[0]
        same_count("picks", count, "targets", end.shape[0])
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

    @property
    def size(self) -> int:
        """Number of throws."""
        return int(self.picks.shape[0])

    @property
    def limits(self) -> LimitRows:
        """Limits of the throws."""
        return LimitRows(self.plane.velocity, self.plane.acceleration, self.plane.jerk)

    def directions(self, slope: Floats) -> Floats:
        """Return the unit vectors (N, 3) at the tangents ``slope`` of the elevation."""
        level = 1.0 / np.sqrt(1.0 + slope * slope)
        return np.stack([level * self.cosine, level * self.sine, level * slope], axis=1)


class LineMotion(NamedTuple):
    """What the planners find for each row; numbers in rows without a plan are ignored."""

    direction: Floats
    angle: Floats
    azimuth: Floats
    distance: Floats
    speed: Floats
    flight_time: Floats
    reason: Ints


def assemble(
    picks: Floats,
    motion: LineMotion,
    limits: LimitRows,
    ceiling_active: Bools | None = None,
    workspace_active: Bools | None = None,
) -> ReleaseBatch:
    """Return the batch of plans, NaN in rows whose reason is not FEASIBLE."""
    feasible = motion.reason == Reason.FEASIBLE
    gap = np.where(feasible, 0.0, np.nan)
    distance, speed = motion.distance + gap, motion.speed + gap
    _, acceleration_max, jerk = limits
    peak = np.minimum(np.sqrt(jerk * speed), acceleration_max)
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
