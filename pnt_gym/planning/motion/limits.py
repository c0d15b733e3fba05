"""Limits of the hand: speed, acceleration and jerk along a line, and the workspace."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import NamedTuple, Self, TypeAlias, cast, final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Bools, Floats, in_order, number, numbers, tuples
from pnt_gym.errors import PlanningError, one_sentence
from pnt_gym.planning.motion import kernel
from pnt_gym.rows import Floats1

# Full performance of the T3KR robot (Hassan et al. 2022, section IV); the paper's 12 G count 1 G as 10 m/s2.
T3KR_VELOCITY = 6.0
T3KR_ACCELERATION = 120.0
T3KR_JERK = 3000.0

_UNITS = {"velocity": "m/s", "acceleration": "m/s2", "jerk": "m/s3"}


class LimitRows(NamedTuple):
    """Limits of N motions as arrays (N,), broadcast once for code that needs the limits often."""

    velocity: Floats1
    acceleration: Floats1
    jerk: Floats1

    @classmethod
    def t3kr(cls, percent: Floats) -> LimitRows:
        """Return the T3KR limits with V, A and J scaled together (Hassan et al. 2022, IV-B3).

        Args:
            percent: shares of the full performance (N,), each in (0, 100].
        """
        return cls(T3KR_VELOCITY * percent / 100.0, T3KR_ACCELERATION * percent / 100.0, T3KR_JERK * percent / 100.0)

    def arrays(self, count: int) -> LimitRows:
        """Return these limits.

        Raises:
            ValueError: if the number of limits is not ``count``.
        """
        if len(self.velocity) != count:
            raise PlanningError(f"the limits hold {len(self.velocity)} throws but {count} are planned")
        return self


@final
@dataclass(frozen=True, eq=False)
class MotionLimits:
    """Largest speed [m/s], acceleration [m/s2] and jerk [m/s3], as norms along the path.

    Each field is one number, or an (N,) array with one value per throw; numbers and arrays may be mixed.

    Raises:
        ValueError: if a value is not positive and finite, or the arrays differ in length.
    """

    velocity: float | Floats
    acceleration: float | Floats
    jerk: float | Floats

    def __post_init__(self) -> None:
        counts: set[int] = set()
        for name in _UNITS:
            value = _check_limit(name, cast(ArrayLike, getattr(self, name)))
            object.__setattr__(self, name, value)
            if isinstance(value, np.ndarray):
                counts.add(value.shape[0])
        if len(counts) > 1:
            raise PlanningError(f"limits given per throw must have one length, got {sorted(counts)}")

    @classmethod
    def t3kr(cls, percent: ArrayLike = 100.0) -> MotionLimits:
        """Return the T3KR limits as `LimitRows.t3kr`, for one throw or many.

        Args:
            percent: share of the full performance in (0, 100], one number or (N,).

        Raises:
            ValueError: if a percentage lies outside (0, 100].
        """
        share = numbers(percent, "percent")
        inside = (share > 0.0) & (share <= 100.0)
        if not inside.all():
            raise PlanningError(f"percent must lie in (0, 100], got {share[~inside].flat[0]}")
        return cls(*LimitRows.t3kr(share))

    @property
    def count(self) -> int | None:
        """Number of throws that the limits are given for, or None when every field is one number."""
        for value in (self.velocity, self.acceleration, self.jerk):
            if isinstance(value, np.ndarray):
                return int(value.shape[0])
        return None

    def arrays(self, count: int) -> LimitRows:
        """Return velocity, acceleration and jerk as arrays (count,) of their own.

        Raises:
            ValueError: if the limits are given per throw and their number is not ``count``.
        """
        if self.count not in (None, count):
            raise PlanningError(f"the limits hold {self.count} throws but {count} are planned")
        fields = (self.velocity, self.acceleration, self.jerk)
        return LimitRows(*(np.full(count, field) for field in fields))

    def numbers(self) -> tuple[float, float, float]:
        """Return velocity, acceleration and jerk as plain numbers.

        Raises:
            ValueError: if the limits are given per throw.
        """
        velocity, acceleration, jerk = self.velocity, self.acceleration, self.jerk
        if isinstance(velocity, float) and isinstance(acceleration, float) and isinstance(jerk, float):
            return velocity, acceleration, jerk
        raise PlanningError(f"one plan needs one set of limits, got limits for {self.count} throws; take a row first")

    def with_scale(self, factor: float) -> MotionLimits:
        """Return the limits with all three fields multiplied by ``factor`` > 0."""
        share = number(factor, "factor")
        return MotionLimits(self.velocity * share, self.acceleration * share, self.jerk * share)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, MotionLimits):
            return NotImplemented
        return all(np.array_equal(getattr(self, name), getattr(other, name)) for name in _UNITS)

    def __hash__(self) -> int:
        return hash(tuple(np.asarray(getattr(self, name)).tobytes() for name in _UNITS))


Limits: TypeAlias = MotionLimits | LimitRows


def limit_rows(limits: object, count: int) -> LimitRows:
    """Return the limits of ``count`` motions as arrays.

    Raises:
        ValueError: if these are no `Limits`, or the limits of another number of motions.
    """
    if not isinstance(limits, MotionLimits | LimitRows):
        raise PlanningError(f"limits must be MotionLimits, got {one_sentence(repr(limits), 80)}")
    return limits.arrays(count)


def _check_limit(name: str, value: ArrayLike) -> float | Floats:
    array = numbers(value, name).copy()
    if array.ndim > 1:
        raise PlanningError(f"{name} must be one number or have shape (N,), got shape {array.shape}")
    good = np.isfinite(array) & (array > 0.0)
    if not good.all():
        raise PlanningError(f"{name} must be positive and finite [{_UNITS[name]}], got {array[~good].flat[0]}")
    if array.ndim == 0:
        return float(array)
    array.flags.writeable = False
    return array


class Space(NamedTuple):
    """A workspace for compiled functions [m]; see `EllipticWorkspace`."""

    semi_x: float
    semi_y: float
    z_min: float
    z_max: float
    x: float
    y: float
    hole: float

    @classmethod
    def of(cls, workspace: EllipticWorkspace) -> Self:
        """The numbers of a workspace."""
        return cls(*(getattr(workspace, name) for name in cls._fields))


class LineBounds(NamedTuple):
    """Bounds of release points in the throws' vertical planes, relative to the picks (N,) [m].

    ``near`` may be 0; ``far``, ``low`` and ``high`` may be infinite.
    """

    near: Floats
    far: Floats
    low: Floats
    high: Floats


@final
@dataclass(frozen=True)
class EllipticWorkspace:
    """Workspace that is an ellipse in top view (Hassan et al. 2022, section IV-A), perhaps with a round hole.

    The paper prints no size; the default semi-axes are ours, and hold every point at which the paper's hand is. An arm
    that stands on the ground does not reach its own base: a circle with a hole is a ring.

    Attributes:
        semi_x: semi-axis along x [m].
        semi_y: semi-axis along y [m].
        z_min: lowest height [m].
        z_max: greatest height [m].
        x: place of the centre [m].
        y: see x.
        hole: radius of the hole about the centre, 0 for none [m].

    Raises:
        ValueError: if a semi-axis is not positive and finite, a height is NaN, z_min is not below z_max, the centre is
            not finite, or the hole leaves no room.
    """

    semi_x: float = 0.45
    semi_y: float = 0.80
    z_min: float = -math.inf
    z_max: float = math.inf
    x: float = 0.0
    y: float = 0.0
    hole: float = 0.0

    def __post_init__(self) -> None:
        # The two semi-axes; heights may be infinite.
        for item in fields(self)[:2]:
            value = number(getattr(self, item.name), item.name)
            if not (math.isfinite(value) and value > 0.0):
                raise PlanningError(f"{item.name} must be positive and finite [m], got {value}")
        if not number(self.z_min, "z_min") < number(self.z_max, "z_max"):
            raise PlanningError(f"z_min must lie below z_max [m], got {self.z_min} and {self.z_max}")
        for name in ("x", "y"):
            if not math.isfinite(number(getattr(self, name), name)):
                raise PlanningError(f"{name} must be finite [m], got {getattr(self, name)}")
        narrowest = min(self.semi_x, self.semi_y)
        if not 0.0 <= number(self.hole, "hole") < narrowest:
            raise PlanningError(f"hole must be at least 0 and below {narrowest} m, got {self.hole}")

    def contains(self, points: ArrayLike) -> Bools:
        """Return whether points (..., 3) [m] lie inside or on the border, shape (...,)."""
        return self.margin(points) >= 0.0

    def margin(self, points: ArrayLike) -> Floats:
        """Return the distance [m] of points (..., 3) to the border, shape (...,); positive inside, negative outside.

        The horizontal part, (1 - |q|) min(semi-axes) with q the point in units of the semi-axes, is a lower
        bound of the distance to the ellipse for points inside the ellipse; the sign is exact everywhere. q is taken
        from the centre.
        """
        places = tuples(points, "points")
        return kernel.margins(*in_order(places.reshape(-1, 3)), Space.of(self)).reshape(places.shape[:-1])

    def line_bounds(self, points: Floats, cosine: Floats, sine: Floats) -> LineBounds:
        """Return the workspace within the vertical half-planes from ``points`` (N, 3) at azimuth (cosine, sine).

        Distances are horizontal from the point, heights relative to the point. Where the half-plane misses the
        workspace, near is greater than far. Where it meets the hole, the bounds end there: a hand on a straight line
        does not cross the hole.
        """
        # |p + s d|^2 = 1 in units of the semi-axes: s^2 |d|^2 + 2 s p.d + |p|^2 - 1 = 0.
        east, north = points[:, 0] - self.x, points[:, 1] - self.y
        x, y = east / self.semi_x, north / self.semi_y
        dx, dy = cosine / self.semi_x, sine / self.semi_y
        square, half = dx * dx + dy * dy, x * dx + y * dy
        discriminant = half * half - square * (x * x + y * y - 1.0)
        root = np.sqrt(np.maximum(discriminant, 0.0))
        # A line that misses the ellipse has an empty interval, from 1 to -1.
        hit = discriminant >= 0.0
        near = np.where(hit, np.maximum((-half - root) / square, 0.0), 1.0)
        far = np.where(hit, (-half + root) / square, -1.0)
        if self.hole > 0.0:
            toward = -(east * cosine + north * sine)
            inside = self.hole**2 - (east**2 + north**2 - toward**2)
            entry = toward - np.sqrt(np.maximum(inside, 0.0))
            far = np.where((inside > 0.0) & (toward > 0.0), np.minimum(far, entry), far)
        return LineBounds(near, far, self.z_min - points[:, 2], self.z_max - points[:, 2])
