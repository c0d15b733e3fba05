"""Where the hand may be: an upright cylinder of elliptic section."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import NamedTuple, final

import numpy as np

from pnt_gym.arrays import Bools, Floats
from pnt_gym.errors import PlanningError


class LineBounds(NamedTuple):
    """Bounds of a release point in the vertical plane of a throw, from the pick [m], each (N,)."""

    near: Floats
    far: Floats
    low: Floats
    high: Floats


@final
@dataclass(frozen=True)
class EllipticWorkspace:
    """Workspace that is an ellipse in top view (Hassan et al. 2022, section IV-A), centred on the z axis.

    Attributes:
        semi_x: semi-axis along x [m].
        semi_y: semi-axis along y [m].
        z_min: lowest height [m].
        z_max: greatest height [m].

    Raises:
        ValueError: if a semi-axis is not positive and finite, a height is NaN, or z_min is not below z_max.
    """

    semi_x: float = 0.45
    semi_y: float = 0.80
    z_min: float = -math.inf
    z_max: float = math.inf

    def __post_init__(self) -> None:
        for item in fields(self)[:2]:
            value = getattr(self, item.name)
            if not (math.isfinite(value) and value > 0.0):
                raise PlanningError(f"{item.name} must be positive and finite [m], got {value}")
        if not self.z_min < self.z_max:
            raise PlanningError(f"z_min must lie below z_max [m], got {self.z_min} and {self.z_max}")

    def contains(self, points: Floats) -> Bools:
        """Return which points (..., 3) [m] lie inside or on the border, shape (...,)."""
        return self.margin(points) >= 0.0

    def margin(self, points: Floats) -> Floats:
        """Return how far inside the border points (..., 3) lie [m], shape (...,); negative outside.

        The horizontal part, (1 - |q|) min(semi-axes) with q the point in units of the semi-axes, is a lower
        bound of the distance to the ellipse for points inside it; its sign is exact everywhere.
        """
        x, y, z = points[..., 0] / self.semi_x, points[..., 1] / self.semi_y, points[..., 2]
        sideways = (1.0 - np.sqrt(x * x + y * y)) * min(self.semi_x, self.semi_y)
        return np.minimum(sideways, np.minimum(z - self.z_min, self.z_max - z))

    def line_bounds(self, points: Floats, cosine: Floats, sine: Floats) -> LineBounds:
        """Return the part inside of the vertical half-plane from ``points`` (N, 3) at azimuth (cosine, sine).

        Distances are horizontal from the point, heights relative to it. Where the half-plane misses the
        workspace, near is greater than far.
        """
        x, y = points[:, 0] / self.semi_x, points[:, 1] / self.semi_y
        dx, dy = cosine / self.semi_x, sine / self.semi_y
        square, half = dx * dx + dy * dy, x * dx + y * dy
        discriminant = half * half - square * (x * x + y * y - 1.0)
        root = np.sqrt(np.maximum(discriminant, 0.0))
        hit = discriminant >= 0.0
        near = np.where(hit, np.maximum((-half - root) / square, 0.0), 1.0)
        far = np.where(hit, (-half + root) / square, -1.0)
        return LineBounds(near, far, self.z_min - points[:, 2], self.z_max - points[:, 2])
