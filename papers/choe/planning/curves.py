"""Smooth curves in a plane, and the arc length along them.

A curve gives its position and three derivatives by a parameter u in [0, 1]. Arc length, curvature and the derivative
of the curvature follow from position and derivatives in the same way for every curve.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol, final

import numpy as np

from pnt_gym.arrays import Floats
from pnt_gym.planning.paths.ellipse import Derivatives, Vector

# Cells of the arc-length table and Gauss points in each: half an ellipse of b / a = 1e-3 is exact to 1e-12.
CELLS = 512
NODES, WEIGHTS = np.polynomial.legendre.leggauss(8)


class CurvePoints(NamedTuple):
    """Points along a curve, all by arc length.

    Attributes:
        position: (M, 2) [m].
        tangent: unit vectors (M, 2) in the direction of travel.
        curvature: (M,) [1/m], positive where the curve turns to the left.
        slope: derivative of the curvature by arc length (M,) [1/m2].
    """

    position: Floats
    tangent: Floats
    curvature: Floats
    slope: Floats


class PlaneCurve(Protocol):
    """A smooth curve in a plane from its start at u = 0 to its end at u = 1."""

    @property
    def straight(self) -> bool:
        """Whether the curve is a straight line."""
        ...

    def derivatives(self, u: Floats) -> Derivatives:
        """Return position and derivatives by u at ``u`` (M,), each (M, 2)."""
        ...


@final
@dataclass(frozen=True)
class Line:
    """The straight way from ``start`` to ``end`` [m]."""

    start: Vector
    end: Vector
    straight: bool = field(default=True, init=False)

    def derivatives(self, u: Floats) -> Derivatives:
        """Return position and derivatives by u at ``u`` (M,), each (M, 2)."""
        start, way = np.array(self.start), np.subtract(self.end, self.start)
        zeros = np.zeros((u.size, 2))
        return Derivatives(start + u[:, None] * way, zeros + way, zeros, zeros)


@final
@dataclass(frozen=True)
class LameCorner:
    """A quarter of the Lamé curve |x/p|^m + |y/q|^m = 1 from the end of p to the end of q.

    The parameter is the polar angle of (x/p, y/q), in which the quarter has no singular point. For m >= 3 the
    curvature is zero at both ends and its derivative finite, so that lines join with continuous curvature.

    Attributes:
        centre: centre of the Lamé curve, opposite to the corner [m].
        p: vector from the centre to the start [m].
        q: vector from the centre to the end [m].
        exponent: m, at least 3.
    """

    centre: Vector
    p: Vector
    q: Vector
    exponent: float
    straight: bool = field(default=False, init=False)

    def derivatives(self, u: Floats) -> Derivatives:
        """Return position and derivatives by u at ``u`` (M,), each (M, 2)."""
        rate = 0.5 * math.pi
        along = _lame(rate * u, self.exponent)
        across = _lame(rate * (1.0 - u), self.exponent)
        centre, p, q = np.array(self.centre), np.array(self.p), np.array(self.q)
        parts: list[Floats] = []
        for order in range(4):
            flip = (-1.0) ** order
            parts.append(rate**order * (along[order][:, None] * p + flip * across[order][:, None] * q))
        return Derivatives(centre + parts[0], parts[1], parts[2], parts[3])


def _lame(t: Floats, m: float) -> tuple[Floats, Floats, Floats, Floats]:
    """Cos t / (cos^m t + sin^m t)^(1/m) and its first three derivatives for 0 <= t <= pi/2."""
    c, s = np.maximum(np.cos(t), 0.0), np.maximum(np.sin(t), 0.0)
    q = c**m + s**m
    q1 = m * (s ** (m - 1) * c - c ** (m - 1) * s)
    q2 = m * ((m - 1) * (c ** (m - 2) * s**2 + s ** (m - 2) * c**2) - q)
    third = (m - 1) * (m - 2) * (s ** (m - 3) * c**3 - c ** (m - 3) * s**3)
    q3 = m * (third + (3 * m - 2) * (c ** (m - 1) * s - s ** (m - 1) * c))
    # l1, l2, l3: derivatives of the logarithm of f = q^(-1/m), by which those of f and of f cos t follow.
    r1, r2, r3 = q1 / q, q2 / q, q3 / q
    l1, l2, l3 = -r1 / m, -(r2 - r1**2) / m, -(r3 - 3.0 * r1 * r2 + 2.0 * r1**3) / m
    f = q ** (-1.0 / m)
    f1, f2, f3 = f * l1, f * (l2 + l1**2), f * (l3 + 3.0 * l1 * l2 + l1**3)
    return (
        c * f,
        c * f1 - s * f,
        c * f2 - 2.0 * s * f1 - c * f,
        c * f3 - 3.0 * s * f2 - 3.0 * c * f1 + s * f,
    )


@final
class MeasuredCurve:
    """A plane curve that is read by arc length.

    Attributes:
        curve: the curve by its parameter u.
        length: whole length of the curve [m].
    """

    def __init__(self, curve: PlaneCurve) -> None:
        self.curve = curve
        edges = np.linspace(0.0, 1.0, CELLS + 1)
        self._sums = np.concatenate([[0.0], np.cumsum(self._arc_length(edges[:-1], edges[1:]))])
        self.length = float(self._sums[-1])

    def parameter(self, s: Floats) -> Floats:
        """Return u (M,) at the arc lengths ``s`` (M,) [m], which are clipped to the curve."""
        s = np.clip(s, 0.0, self.length)
        cell = np.clip(np.searchsorted(self._sums, s, side="right") - 1, 0, CELLS - 1)
        start = cell / CELLS
        remainder = s - self._sums[cell]
        u = start + remainder / (self._sums[cell + 1] - self._sums[cell]) / CELLS
        if self.curve.straight:
            return u
        # Newton; speed varies by a few per cent within a cell, so three steps reach rounding.
        for _ in range(3):
            u = u + (remainder - self._arc_length(start, u)) / self._speed(u)
        return np.clip(u, 0.0, 1.0)

    def at(self, s: Floats) -> CurvePoints:
        """Return the points at the arc lengths ``s`` (M,) [m], which are clipped to the curve."""
        return curve_points(self.curve.derivatives(self.parameter(s)))

    def _speed(self, u: Floats) -> Floats:
        first = self.curve.derivatives(u).first
        return np.hypot(first[:, 0], first[:, 1])

    def _arc_length(self, low: Floats, high: Floats) -> Floats:
        """Arc length from ``low`` to ``high``, each (M,), by Gauss-Legendre."""
        u = 0.5 * (low + high)[:, None] + 0.5 * (high - low)[:, None] * NODES
        return 0.5 * (high - low) * (self._speed(u.ravel()).reshape(u.shape) @ WEIGHTS)


def curve_points(d: Derivatives) -> CurvePoints:
    """Return position, unit tangent, curvature and its derivative by arc length from derivatives by u."""
    speed = np.hypot(d.first[:, 0], d.first[:, 1])
    curvature = _cross(d.first, d.second) / speed**3
    along = (d.first * d.second).sum(axis=1) / speed**2
    slope = (_cross(d.first, d.third) / speed**3 - 3.0 * curvature * along) / speed
    return CurvePoints(d.position, d.first / speed[:, None], curvature, slope)


def _cross(a: Floats, b: Floats) -> Floats:
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
