"""Paths of the hand in a vertical plane, made of smooth pieces, and their place in space.

A path starts at (0, 0); x runs towards the place, y upwards. The joints of the pieces decide how the hand passes. At a
corner the direction jumps, so the hand must stop. Where only the curvature jumps, the hand must stop or accept a step
of its acceleration. Where the curvature is continuous, the hand passes without either.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from typing import final

import numpy as np

from pnt_gym.arrays import Bools, Floats, Ints, Point, vector
from pnt_gym.errors import PlanningError
from pnt_gym.planning.paths.ellipse import EllipseArc, EllipsePath, Vector

from .curves import CurvePoints, LameCorner, Line, MeasuredCurve, PlaneCurve

# Gaps and turns below these count as rounding.
GAP = 1e-9
TURN = 1e-9
CURVATURE = 1e-6


class Joint(Enum):
    """How two pieces of a path meet."""

    CORNER = "the direction jumps"
    TANGENT = "the direction is continuous, the curvature jumps"
    CURVED = "the curvature is continuous"


@final
class PlanePath:
    """A path in a vertical plane.

    Attributes:
        pieces: smooth pieces in order, each with its arc length.
        joints: how neighbouring pieces meet (len(pieces) - 1).
        borders: arc length at the start of each piece and at the end (len(pieces) + 1,) [m].
        length: whole length [m].

    Raises:
        ValueError: if there is no piece, a piece has no length, or two pieces do not meet.
    """

    def __init__(self, curves: tuple[PlaneCurve, ...]) -> None:
        if not curves:
            raise PlanningError("a path needs at least one piece, got none")
        self.pieces = tuple(MeasuredCurve(curve) for curve in curves)
        lengths = [piece.length for piece in self.pieces]
        if not min(lengths) > 0.0:
            raise PlanningError(f"every piece of a path needs a length above 0 [m], got {min(lengths)}")
        self.joints = tuple(_joint_kind(a, b) for a, b in zip(self.pieces[:-1], self.pieces[1:], strict=True))
        self.borders: Floats = np.concatenate([[0.0], np.cumsum(lengths)])
        self.length = float(self.borders[-1])

    @property
    def end(self) -> Floats:
        """Last point (2,) [m]."""
        return self.pieces[-1].at(np.array([self.pieces[-1].length])).position[0]

    @property
    def start(self) -> Floats:
        """First point (2,) [m]."""
        return self.pieces[0].at(np.zeros(1)).position[0]

    @property
    def top(self) -> float:
        """Greatest height above the start [m], read at 2001 points of each piece."""
        heights = [piece.at(np.linspace(0.0, piece.length, 2001)).position[:, 1].max() for piece in self.pieces]
        return float(max(heights) - self.start[1])

    def piece_at(self, s: Floats) -> Ints:
        """Return the index of the piece at the arc lengths ``s`` (M,) [m]; at a joint the later piece."""
        index = np.searchsorted(self.borders, s, side="right") - 1
        return np.clip(index, 0, len(self.pieces) - 1).astype(np.int64)

    def at(self, s: Floats, piece: Ints | None = None) -> CurvePoints:
        """Return the points at the arc lengths ``s`` (M,) [m].

        Args:
            s: arc lengths from the start of the path, clipped to the piece.
            piece: index of the piece to read at each arc length (M,), which chooses the side at a joint; the later
                piece if not given.
        """
        index = self.piece_at(s) if piece is None else piece
        result = CurvePoints(np.zeros((s.size, 2)), np.zeros((s.size, 2)), np.zeros(s.size), np.zeros(s.size))
        for k in np.unique(index):
            rows: Bools = index == k
            points = self.pieces[int(k)].at(s[rows] - self.borders[k])
            for column, values in zip(result, points, strict=True):
                column[rows] = values
        return result

    def points(self, count: int = 400) -> Floats:
        """Return ``count`` points (count, 2) [m] evenly along the path."""
        return self.at(np.linspace(0.0, self.length, count)).position


@final
@dataclass(frozen=True, eq=False)
class SpacePath:
    """A plane path in space.

    Attributes:
        path: the path in its vertical plane.
        origin: position of the plane's (0, 0) in space (3,) [m].
        heading: horizontal direction of the plane's x, a unit vector (3,).
    """

    path: PlanePath
    origin: Floats
    heading: Floats

    @classmethod
    def between(cls, path: PlanePath, pick: Point, place: Point) -> SpacePath:
        """Return ``path`` laid from ``pick`` to ``place``, each (3,) [m].

        Raises:
            ValueError: if a point is not finite, pick and place lie on one vertical line, or the ends of the path
                are not as far apart as pick and place, horizontally or vertically.
        """
        first, last = vector(pick, "pick"), vector(place, "place")
        way = last - first
        run = math.hypot(way[0], way[1])
        if run == 0.0:
            raise PlanningError("the place lies straight above or below the pick: there is no plane to move in")
        span = path.end - path.start
        if abs(span[0] - run) > 1e-6 or abs(span[1] - way[2]) > 1e-6:
            raise PlanningError(
                f"the path spans {span[0]:.6f} m by {span[1]:.6f} m, but pick and place lie {run:.6f} m and "
                f"{way[2]:.6f} m apart"
            )
        heading = np.array([way[0] / run, way[1] / run, 0.0])
        return cls(path, first - _lift_to_space(path.start[None], heading)[0], heading)

    def vectors(self, plane: Floats) -> Floats:
        """Return plane vectors (M, 2) as vectors in space (M, 3)."""
        return _lift_to_space(plane, self.heading)

    def positions(self, plane: Floats) -> Floats:
        """Return plane points (M, 2) as points in space (M, 3) [m]."""
        return self.origin + _lift_to_space(plane, self.heading)


def rectangle(width: float, lift: float, drop: float) -> PlanePath:
    """Return the path straight up by ``lift``, level over ``width``, straight down by ``drop`` [m].

    Raises:
        ValueError: if the width is not positive and finite, or lift or drop is negative or not finite.
    """
    _check_lengths(width, lift, drop)
    return _chain(lift, Line((0.0, lift), (width, lift)), end=(width, lift), drop=drop)


def line_ellipse_line(ellipse: EllipsePath, lift: float, drop: float) -> PlanePath:
    """Return the paper's whole path: straight up by ``lift`` to T1, the ellipse, straight down by ``drop`` from T2 [m].

    With a level ellipse the path is the symmetric path of the paper's comparison.

    Raises:
        ValueError: if lift or drop is negative or not finite.
    """
    width, rise = 2.0 * ellipse.half_width, 2.0 * ellipse.half_rise
    _check_lengths(width, lift, drop)
    arc = ellipse.arc((ellipse.half_width, lift + ellipse.half_rise))
    return _chain(lift, arc, end=(width, lift + rise), drop=drop)


def lame_path(width: float, lift: float, drop: float, corner: Vector, exponent: float = 3.0) -> PlanePath:
    """Return the path straight up by ``lift``, round a Lamé corner, level, round a second, straight down by ``drop``.

    The exponent 2 makes the corners quarters of an ellipse, at whose ends the curvature jumps. Between 2 and 3 the
    derivative of the curvature is infinite where a corner meets a line, so that no motion keeps a jerk limit.

    Args:
        width: from pick to place [m].
        lift: vertical part at the pick [m].
        drop: vertical part at the place [m].
        corner: width d and height e of a corner [m].
        exponent: m of |x/d|^m + |y/e|^m = 1: 2, or at least 3.

    Raises:
        ValueError: if a length is negative or not finite, a corner has no width or height, both do not fit into
            the width, or the exponent is neither 2 nor at least 3 and finite.
    """
    _check_lengths(width, lift, drop)
    d, e = corner
    if not (min(d, e) > 0.0 and math.isfinite(e) and 2.0 * d <= width * (1.0 + GAP)):
        raise PlanningError(f"corners need a width and a height above 0 and must fit into {width} m, got {(d, e)}")
    if not (exponent == 2.0 or 3.0 <= exponent < math.inf):
        raise PlanningError(f"exponent must be 2 or at least 3, got {exponent}")
    top, far = lift + e, width - d
    return _chain(
        lift,
        _corner((d, lift), (-d, 0.0), (0.0, e), exponent),
        Line((d, top), (max(far, d), top)),
        _corner((far, top - e), (0.0, e), (d, 0.0), exponent),
        end=(width, top - e),
        drop=drop,
    )


def _corner(centre: Vector, p: Vector, q: Vector, exponent: float) -> PlaneCurve:
    if exponent == 2.0:
        return EllipseArc(centre, p, q, 0.0, 0.5 * math.pi)
    return LameCorner(centre, p, q, exponent)


def _chain(lift: float, *middle: PlaneCurve, end: Vector, drop: float) -> PlanePath:
    """The path straight up by ``lift``, through ``middle`` to ``end``, straight down by ``drop``; no empty lines."""
    last = Line(end, (end[0], end[1] - drop))
    curves = Line((0.0, 0.0), (0.0, lift)), *middle, last
    real = [c for c in curves if not isinstance(c, Line) or math.dist(c.start, c.end) > GAP]
    return PlanePath(tuple(real))


def _check_lengths(width: float, lift: float, drop: float) -> None:
    if not (math.isfinite(width) and width > 0.0):
        raise PlanningError(f"width must be positive and finite [m], got {width}")
    for name, value in (("lift", lift), ("drop", drop)):
        if not (math.isfinite(value) and value >= 0.0):
            raise PlanningError(f"{name} must be finite and not negative [m], got {value}")


def _joint_kind(before: MeasuredCurve, after: MeasuredCurve) -> Joint:
    last, first = before.at(np.array([before.length])), after.at(np.zeros(1))
    gap = float(np.abs(last.position - first.position).max())
    if gap > GAP:
        raise PlanningError(f"the pieces of a path must meet, got a gap of {gap:.3g} m")
    if float(np.abs(last.tangent - first.tangent).max()) > TURN:
        return Joint.CORNER
    jump = abs(float(first.curvature[0] - last.curvature[0]))
    return Joint.TANGENT if jump * min(before.length, after.length) > CURVATURE else Joint.CURVED


def _lift_to_space(plane: Floats, heading: Floats) -> Floats:
    up = np.array([0.0, 0.0, 1.0])
    return plane[:, :1] * heading + plane[:, 1:] * up
