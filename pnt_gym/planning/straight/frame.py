"""Picks and targets of throws, checked, and each throw in its vertical plane."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats, Point, finite_points, finite_rows
from pnt_gym.errors import PlanningError, one_sentence


class Frame(NamedTuple):
    """N throws, each in its vertical plane.

    Attributes:
        picks: starts of the throws (N, 3) [m].
        cosine: cosine of the throws' azimuths (N,).
        sine: sine of the throws' azimuths (N,).
        reach: horizontal distance to the target, shortened by the tolerance (N,) [m]; may be negative.
        rise: height of the target above the pick (N,) [m].
    """

    picks: Floats
    cosine: Floats
    sine: Floats
    reach: Floats
    rise: Floats

    @classmethod
    def of(cls, picks: ArrayLike, targets: ArrayLike, tolerance: ArrayLike = 0.0) -> Frame:
        """Check picks, targets and tolerances, and return the throws in their vertical planes.

        Raises:
            ValueError: if an input is not finite, a tolerance is negative, or shapes disagree.
        """
        start, end, box = check_throws(picks, targets, tolerance)
        x, y = end[:, 0] - start[:, 0], end[:, 1] - start[:, 1]
        full = np.sqrt(x * x + y * y)
        has_direction = full > 0.0
        divisor = np.where(has_direction, full, 1.0)
        cosine, sine = np.where(has_direction, x / divisor, 1.0), y / divisor
        reach = full - box / np.maximum(np.abs(cosine), np.abs(sine))
        return cls(start, cosine, sine, reach, end[:, 2] - start[:, 2])


def check_throws(picks: ArrayLike, targets: ArrayLike, tolerance: ArrayLike) -> tuple[Floats, Floats, Floats]:
    """Check picks (N, 3), targets (N, 3) and tolerances (N,), and return the three as arrays.

    Raises:
        ValueError: if an input is not finite, a tolerance is negative, or shapes disagree.
    """
    start = finite_points(picks, "picks")
    end = finite_points(targets, "targets", len(start))
    box = finite_rows(tolerance, len(start), "tolerance")
    if (box < 0.0).any():
        raise PlanningError(f"tolerance must not be negative [m], got {box.min()}")
    return start, end, box


def point_of(values: Point, name: str) -> tuple[float, float, float]:
    """Return three coordinates as floats.

    Raises:
        ValueError: if there are not three coordinates, or a coordinate is not finite.
    """
    try:
        x, y, z = map(float, values)
    except (TypeError, ValueError, OverflowError):
        raise PlanningError(f"{name} must hold three coordinates, got {one_sentence(repr(values), 80)}") from None
    if not math.isfinite(x + y + z):
        raise PlanningError(f"{name} must be finite, got {(x, y, z)}")
    return x, y, z
