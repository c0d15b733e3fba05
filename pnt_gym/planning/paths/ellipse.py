"""The ellipse of Choe et al. 2023: centred between two points at which the ellipse has vertical tangents.

All centred ellipses with vertical tangents at (-l, -h) and (l, h) are x = l cos t, y = h cos t + w sin t, with a
parameter w > 0. The greatest height is Y = sqrt(h^2 + w^2), the natural way to choose an ellipse. The paper
chooses by the angle phi of the major axis, with tan 2 phi = 2 l h / (l^2 - Y^2), and a rule for phi that works
for some h only.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple, TypeAlias, final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats, number, numbers
from pnt_gym.errors import PlanningError

Vector: TypeAlias = tuple[float, float]
# A critical angle this close to a whole degree [deg] counts as a whole degree: the ellipse would be a line.
WHOLE_DEGREE = 1e-9
MOST_NODES = 100_000
SIZES = (1e-30, 1e30)
"""Range of an ellipse's lengths [m]: powers of lengths outside would be rounded to 0 or infinity."""
AXES = (1e-100, 1e100)
"""Range of semi-axes for the circumference [m], for the same reason; a flat ellipse has a short semi-axis."""


class Derivatives(NamedTuple):
    """Position [m] and its first three derivatives by the parameter, each (M, 2)."""

    position: Floats
    first: Floats
    second: Floats
    third: Floats


@final
@dataclass(frozen=True)
class EllipseArc:
    """Part of an ellipse, centre + p cos t + q sin t with t from ``first`` to ``last`` [rad].

    Attributes:
        centre: centre of the ellipse [m].
        p: half of a diameter [m].
        q: half of the conjugate diameter [m].
        first: t at the start.
        last: t at the end.
    """

    centre: Vector
    p: Vector
    q: Vector
    first: float
    last: float
    straight: bool = field(default=False, init=False)

    def derivatives(self, u: Floats) -> Derivatives:
        """Return position and derivatives by u at ``u`` (M,), each (M, 2)."""
        rate = self.last - self.first
        t = self.first + rate * u[:, None]
        p, q = np.array(self.p), np.array(self.q)
        offset = p * np.cos(t) + q * np.sin(t)
        tangent = q * np.cos(t) - p * np.sin(t)
        return Derivatives(np.array(self.centre) + offset, rate * tangent, -(rate**2) * offset, -(rate**3) * tangent)


@final
@dataclass(frozen=True, eq=False)
class NodeList:
    """Nodes of the paper's speed law: steps of the polar angle in proportion to the radius of curvature.

    Attributes:
        theta: polar angles in the frame of the axes, from T1 down to T2 (n,) [rad].
        points: positions from the centre (n, 2) [m].
        steps: lengths of the chords between the points (n - 1,) [m] (Eq. 55).
    """

    theta: Floats
    points: Floats
    steps: Floats


@final
@dataclass(frozen=True)
class EllipsePath:
    """The upper half of an ellipse from T1 = (-l, -h) to T2 = (l, h), vertical at both ends (Choe et al. 2023).

    ``paper``, ``with_top`` and ``with_angle`` construct paths. Coordinates are x to the side of T2 and y upwards
    from the centre, which lies half-way between T1 and T2.

    Attributes:
        half_width: l [m].
        half_rise: h [m], negative where T2 is the lower end.
        top_height: Y, greatest height above the centre [m].

    Raises:
        ValueError: if half_width or top_height is not from 1e-30 to 1e30 m, or |half_rise| is not below top_height.
    """

    half_width: float
    half_rise: float
    top_height: float

    def __post_init__(self) -> None:
        _check_within(self.half_width, SIZES, "half_width")
        _check_finite(self.half_rise, "half_rise")
        _check_within(self.top_height, SIZES, "top")
        if not abs(self.half_rise) < self.top_height:
            raise PlanningError(
                f"top must lie above both ends, more than |half_rise| = {abs(self.half_rise)} m above the centre, "
                f"got {self.top_height}"
            )

    @classmethod
    def with_top(cls, half_width: float, half_rise: float, top: float) -> EllipsePath:
        """Return the ellipse whose highest point lies ``top`` [m] above its centre.

        The ellipse exists for any rise with |half_rise| < top, also for level and falling paths.

        Raises:
            ValueError: as the class.
        """
        return cls(number(half_width, "half_width"), number(half_rise, "half_rise"), number(top, "top"))

    @classmethod
    def with_angle(cls, half_width: float, half_rise: float, angle: float) -> EllipsePath:
        """Return the ellipse whose major axis is inclined by ``angle`` [rad] (Eqs. 21, 23).

        Raises:
            ValueError: if half_width or |half_rise| is not from 1e-30 to 1e30 m (with a rise of 0 every angle but 0
                and 90 degrees gives the same circle), or the angle does not lie between arctan(h / l) and 90 degrees.
        """
        _check_within(half_width, SIZES, "half_width")
        _check_finite(half_rise, "half_rise")
        if half_rise == 0.0:
            raise PlanningError("half_rise must not be 0: the angle does not choose a level ellipse; use with_top")
        _check_within(abs(half_rise), SIZES, "|half_rise|")
        _check_finite(angle, "angle")
        critical = math.atan(half_rise / half_width)
        if not abs(critical) < angle * math.copysign(1.0, half_rise) < 0.5 * math.pi:
            low, high = sorted((math.degrees(critical), math.copysign(90.0, half_rise)))
            raise PlanningError(f"angle must lie between {low:.9g} and {high:.9g} degrees, got {math.degrees(angle)}")
        # w^2 = a^2 b^2 / l^2 with the squares of Eqs. 21 and 23 in closed form.
        ratio, slope = half_rise / half_width, math.tan(angle)
        chord = half_width**2 * (1.0 + ratio * slope) * (1.0 - ratio / slope)
        return cls(float(half_width), float(half_rise), math.sqrt(half_rise**2 + max(chord, 0.0)))

    @classmethod
    def paper(cls, half_width: float, half_rise: float) -> EllipsePath:
        """Return the paper's "optimal" ellipse, whose angle is arctan(h / l) rounded up to a whole degree (Eq. 29).

        The length falls with the angle down to the critical arctan(h / l), where the ellipse is a line; the whole
        degree is the step of the paper's plot. Where the critical angle is a whole degree, or h <= 0, the rule gives
        no ellipse.

        Raises:
            ValueError: if half_width is not from 1e-30 to 1e30 m, half_rise not positive and finite, or arctan(h / l)
                a whole degree or above 89 degrees.
        """
        _check_within(half_width, SIZES, "half_width")
        if not 0.0 < number(half_rise, "half_rise") < math.inf:
            raise PlanningError(f"the paper's rule needs a half_rise above 0 [m], got {half_rise}; use with_top")
        critical = math.degrees(math.atan(half_rise / half_width))
        if abs(critical - round(critical)) < WHOLE_DEGREE or critical > 89.0:
            raise PlanningError(
                f"the paper's rule has no ellipse for half_width {half_width} and half_rise {half_rise} m: the "
                f"critical angle is {critical:.9g} degrees, and it must not be whole or above 89; use with_top"
            )
        return cls.with_angle(half_width, half_rise, math.radians(math.ceil(critical)))

    @property
    def half_chord(self) -> float:
        """w: half the vertical diameter of the ellipse through its centre [m]."""
        rise = abs(self.half_rise)
        return math.sqrt((self.top_height - rise) * (self.top_height + rise))

    @property
    def angle(self) -> float:
        """Inclination phi of the major axis [rad], in [-pi/2, pi/2]; 0 for a circle."""
        square = (self.half_width - self.top_height) * (self.half_width + self.top_height)
        # tan 2 phi = 2 l h / (l^2 - Y^2); the product of sum and difference keeps its digits where Y is near l.
        return 0.5 * math.atan2(2.0 * self.half_width * self.half_rise, square)

    @property
    def semi_major(self) -> float:
        """Length a of the semi-major axis [m]."""
        square = (self.half_width - self.top_height) * (self.half_width + self.top_height)
        # a^2 + b^2 = l^2 + Y^2 and a^2 - b^2 = hypot(l^2 - Y^2, 2 l h).
        difference = math.hypot(square, 2.0 * self.half_width * self.half_rise)
        return math.sqrt(0.5 * (self.half_width**2 + self.top_height**2 + difference))

    @property
    def semi_minor(self) -> float:
        """Length b of the semi-minor axis [m], from the area a b = l w."""
        # The bound keeps b from exceeding a by a rounding in a circle.
        return min(self.half_width * self.half_chord / self.semi_major, self.semi_major)

    @property
    def length(self) -> float:
        """Exact length of the path [m]: half the circumference, a complete elliptic integral of the second kind."""
        return half_circumference(self.semi_major, self.semi_minor)

    @property
    def approximate_length(self) -> float:
        """The paper's approximation of the length [m] (Eq. 27): up to 5.2 % short for a flat ellipse."""
        return float(approximate_half_circumference(self.semi_major, self.semi_minor))

    @property
    def top(self) -> tuple[float, float]:
        """Highest point (x, y) from the centre [m] (Eq. 37)."""
        return self.half_width * self.half_rise / self.top_height, self.top_height

    @property
    def height(self) -> float:
        """H*, height of the top above T1 [m]: Eq. 38 as printed lacks the half rise."""
        return self.top_height + self.half_rise

    @property
    def theta_t2(self) -> float:
        """Polar angle of the end T2 in the frame of the axes [rad] (Eq. 41); the paper's results swap T2 and T1."""
        cos, sin = math.cos(self.angle), math.sin(self.angle)
        along = self.half_width * cos + self.half_rise * sin
        across = self.half_rise * cos - self.half_width * sin
        return math.atan2(across / self.semi_minor, along / self.semi_major)

    @property
    def theta_t1(self) -> float:
        """Polar angle of the start T1 in the frame of the axes [rad] (Eq. 42); along the path the angle decreases."""
        return self.theta_t2 + math.pi

    def point(self, theta: ArrayLike) -> Floats:
        """Return the points (..., 2) [m] from the centre at polar angles ``theta`` (...) [rad] (Eq. 43)."""
        turn = numbers(theta, "theta")
        along, across = self.semi_major * np.cos(turn), self.semi_minor * np.sin(turn)
        cos, sin = math.cos(self.angle), math.sin(self.angle)
        return np.stack([along * cos - across * sin, along * sin + across * cos], axis=-1)

    def radius_of_curvature(self, theta: ArrayLike) -> Floats:
        """Return rho (...) [m] at polar angles ``theta`` (...) [rad] (Eq. 51)."""
        turn = numbers(theta, "theta")
        major, minor = self.semi_major, self.semi_minor
        return ((major * np.sin(turn)) ** 2 + (minor * np.cos(turn)) ** 2) ** 1.5 / (major * minor)

    def nodes(self, rate: float, *, clip: bool = True) -> NodeList:
        """Return the paper's node list: steps of ``rate`` times rho [rad] from T1 until T2 is reached (Eqs. 52-55).

        Args:
            rate: the paper's r [rad/m].
            clip: whether the list ends at T2; if not, the last step runs past T2, as in the paper's steps 6 and 7.

        Raises:
            ValueError: if the rate is not positive and finite, or so small that more than 100 000 nodes result.
        """
        _check_positive(rate, "rate")
        # No radius of curvature is smaller than b^2 / a, so each step turns by at least pi / MOST_NODES.
        slowest = math.pi / MOST_NODES * self.semi_major / self.semi_minor**2
        if rate < slowest:
            raise PlanningError(f"rate must be at least {slowest:.3g} rad/m, got {rate}")
        end = self.theta_t2
        theta = [self.theta_t1]
        while theta[-1] > end:
            theta.append(theta[-1] - rate * float(self.radius_of_curvature(theta[-1])))
        if clip:
            theta[-1] = end
        points = self.point(theta)
        way = np.diff(points, axis=0)
        return NodeList(np.array(theta), points, np.hypot(way[:, 0], way[:, 1]))

    def arc(self, centre: Vector = (0.0, 0.0)) -> EllipseArc:
        """Return the path from T1 to T2 as a curve about ``centre`` [m]."""
        return EllipseArc(centre, (self.half_width, self.half_rise), (0.0, self.half_chord), math.pi, 0.0)


def half_circumference(semi_major: float, semi_minor: float) -> float:
    """Return half the circumference of an ellipse [m], exact, by the arithmetic-geometric mean of Gauss.

    Raises:
        ValueError: if an axis is not from 1e-100 to 1e100 m.
    """
    _check_within(semi_major, AXES, "semi_major")
    _check_within(semi_minor, AXES, "semi_minor")
    a, b, weight = semi_major, semi_minor, 1.0
    mean_square = 0.5 * (a * a + b * b)
    # Each step more than halves the gap and doubles the number of correct digits; a and b may differ by a rounding.
    while abs(a - b) > 4.0 * math.ulp(a):
        gap = 0.5 * (a - b)
        a, b = 0.5 * (a + b), math.sqrt(a * b)
        mean_square -= weight * gap * gap
        weight *= 2.0
    return math.pi * mean_square / a


def approximate_half_circumference(semi_major: ArrayLike, semi_minor: ArrayLike) -> Floats:
    """Return the paper's approximation of half the circumference (Eq. 27), shaped as the axes [m]."""
    a, b = numbers(semi_major, "semi_major"), numbers(semi_minor, "semi_minor")
    return 0.25 * np.pi * (a + b) + 0.25 * np.pi * np.sqrt(2.0 * (a * a + b * b))


def _check_positive(value: float, name: str) -> None:
    if not 0.0 < number(value, name) < math.inf:
        raise PlanningError(f"{name} must be positive and finite, got {value}")


def _check_within(value: float, bounds: tuple[float, float], name: str) -> None:
    _check_positive(value, name)
    if not bounds[0] <= value <= bounds[1]:
        raise PlanningError(f"{name} must be from {bounds[0]:g} to {bounds[1]:g} m, got {value}")


def _check_finite(value: float, name: str) -> None:
    if not math.isfinite(number(value, name)):
        raise PlanningError(f"{name} must be finite, got {value}")
