"""The vertical planes that throws lie in."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats, finite_points, finite_rows
from pnt_gym.errors import PlanningError


class Frame(NamedTuple):
    """N throws in their planes.

    Attributes:
        picks: where they start (N, 3) [m].
        cosine: of their azimuths (N,).
        sine: of their azimuths (N,).
        reach: horizontal way to the target, shortened by the tolerance (N,) [m]; it may be negative.
        rise: height of the target above the pick (N,) [m].
    """

    picks: Floats
    cosine: Floats
    sine: Floats
    reach: Floats
    rise: Floats

    @classmethod
    def of(cls, picks: ArrayLike, targets: ArrayLike, tolerance: ArrayLike = 0.0) -> Frame:
        """Check the inputs and lay the throws out.

        Raises:
            ValueError: if an input is not finite, a tolerance is negative, or shapes disagree.
        """
        start, end, box = checked(picks, targets, tolerance)
        x, y = end[:, 0] - start[:, 0], end[:, 1] - start[:, 1]
        full = np.sqrt(x * x + y * y)
        known = full > 0.0
        divisor = np.where(known, full, 1.0)
        cosine, sine = np.where(known, x / divisor, 1.0), y / divisor
        reach = full - box / np.maximum(np.abs(cosine), np.abs(sine))
        return cls(start, cosine, sine, reach, end[:, 2] - start[:, 2])


def checked(picks: ArrayLike, targets: ArrayLike, tolerance: ArrayLike) -> tuple[Floats, Floats, Floats]:
    """Picks (N, 3), targets (N, 3) and tolerances (N,) as arrays.

    Raises:
        ValueError: if an input is not finite, a tolerance is negative, or shapes disagree.
    """
    start = finite_points(picks, "picks")
    end = finite_points(targets, "targets", len(start))
    box = finite_rows(tolerance, len(start), "tolerance")
    if (box < 0.0).any():
        raise PlanningError(f"tolerance must not be negative [m], got {box.min()}")
    return start, end, box
