"""Estimates of flights and arrival states from camera measurements (Miyashita et al., section 5.2, appendix)."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Bools, Floats, numbers
from pnt_gym.constants import GRAVITY
from pnt_gym.errors import PlanningError

SCALES: Final = (1.0, 1.0, 0.1, 0.1)
"""Diagonal of T for x, y [1/m], phi [1/rad] and dy [s/m]; the paper gives no values."""
POLISHES: Final = 3


class FittedFlight(NamedTuple):
    """N ballistic flights by their position, angle and velocities at time zero, each (N,) [m, m/s, rad, rad/s]."""

    x: Floats
    y: Floats
    phi: Floats
    vx: Floats
    vy: Floats
    spin: Floats

    def state(self, time: Floats) -> Floats:
        """Return the landing states (N, 4) = x, y, phi, dy at ``time`` (N,) [s]."""
        return np.stack(
            [
                self.x + self.vx * time,
                self.y + time * (self.vy - 0.5 * GRAVITY * time),
                self.phi + self.spin * time,
                self.vy - GRAVITY * time,
            ],
            axis=1,
        )


class Arrival(NamedTuple):
    """Landing states z (N, 4) of N flights and the times of these states (N,) [s]."""

    z: Floats
    time: Floats


def fit_flight(
    times: ArrayLike, x: ArrayLike, y: ArrayLike, phi: ArrayLike, mask: ArrayLike | None = None
) -> FittedFlight:
    """Return the ballistic flights that fit measured positions and angles best in the least-squares sense.

    Args:
        times: times of the pictures [s], (M,) for all rows or (N, M).
        x: measured positions (N, M) [m].
        y: measured heights (N, M) [m].
        phi: measured angles (N, M), unwrapped [rad].
        mask: whether each sample counts (N, M); by default every sample counts. Other samples may hold NaN.

    Raises:
        ValueError: shapes disagree, a sample that counts is not finite, or a row has fewer than two distinct times.
    """
    columns = [numbers(value, name) for value, name in ((x, "x"), (y, "y"), (phi, "phi"))]
    shape = columns[0].shape
    if len(shape) != 2 or any(column.shape != shape for column in columns):
        raise PlanningError(f"x, y and phi must have one shape (N, M), got {[column.shape for column in columns]}")
    counts = np.ones(shape, dtype=np.bool_) if mask is None else np.asarray(mask, dtype=np.bool_)
    if counts.shape != shape:
        raise PlanningError(f"mask must have shape {shape}, got {counts.shape}")
    time = numbers(times, "times")
    if time.shape not in (shape, shape[1:]):
        raise PlanningError(f"times must have shape ({shape[1]},) or {shape}, got {time.shape}")
    time = np.broadcast_to(time, shape)
    for name, column in (("times", time), ("x", columns[0]), ("y", columns[1]), ("phi", columns[2])):
        if not np.isfinite(column[counts]).all():
            raise PlanningError(f"{name} must be finite where the mask counts it")
    time = np.where(counts, time, 0.0)
    # Without gravity's share the height is a straight line over time, like x and phi.
    columns[1] = columns[1] + 0.5 * GRAVITY * time * time
    (x0, vx), (y0, vy), (phi0, spin) = _line_fits(time, columns, counts)
    return FittedFlight(x0, y0, phi0, vx, vy, spin)


def arrival(
    flight: FittedFlight, goal: ArrayLike, scales: ArrayLike = SCALES, earliest: ArrayLike | None = None
) -> Arrival:
    """Return the states of the flights that are nearest to their goals (appendix, Eq. 35).

    The derivative of the squared distance is a cubic in time, whose inflection is the apex of the flight. The cubic has
    three real roots only where the goal lies within the parabola.

    Args:
        flight: N flights.
        goal: landing states (N, 4).
        scales: diagonal of T (4,) [1/m, 1/m, 1/rad, s/m]; the scale of y must be positive, or there is no cubic.
        earliest: time before which no state counts (N,) [s], such as the release; the whole parabola when not given.

    Raises:
        ValueError: a scale is negative or not finite, the scale of y is 0, or the goals have the wrong shape.
    """
    diagonal, target = numbers(scales, "scales"), numbers(goal, "goal")
    if diagonal.shape != (4,) or not np.isfinite(diagonal).all() or (diagonal < 0.0).any():
        raise PlanningError(f"scales must be four finite numbers of at least 0, got {scales!r}")
    if diagonal[1] == 0.0:
        raise PlanningError("the scale of y is 0; it must be positive, or no point of the flight is nearest")
    if target.shape != (flight.x.size, 4):
        raise PlanningError(f"goal must have shape ({flight.x.size}, 4), got {target.shape}")
    weights = diagonal * diagonal
    candidates = _nearest_times(flight, target, weights)
    if earliest is not None:
        candidates = np.maximum(candidates, np.broadcast_to(numbers(earliest, "earliest"), flight.x.shape))
    errors = [flight.state(time) - target for time in candidates]
    squares = [weights * error * error for error in errors]
    distance = np.stack([square[:, 0] + square[:, 1] + square[:, 2] + square[:, 3] for square in squares])
    time = candidates[distance.argmin(axis=0), np.arange(flight.x.size)]
    return Arrival(flight.state(time), time)


def _line_fits(time: Floats, columns: list[Floats], counts: Bools) -> list[tuple[Floats, Floats]]:
    """Intercept and slope (N,) of the least-squares straight line of each column over time."""
    number = counts.sum(axis=1)
    middle = time.sum(axis=1) / np.maximum(number, 1)
    away = np.where(counts, time - middle[:, None], 0.0)
    spread = (away * away).sum(axis=1)
    short = (number < 2) | (spread <= 0.0)
    if short.any():
        row = int(np.argmax(short))
        raise PlanningError(f"row {row} has {number[row]} samples at fewer than two distinct times; a line needs two")
    fits: list[tuple[Floats, Floats]] = []
    for column in columns:
        value = np.where(counts, column, 0.0)
        mean = value.sum(axis=1) / number
        slope = (away * (value - mean[:, None])).sum(axis=1) / spread
        fits.append((mean - slope * middle, slope))
    return fits


def _nearest_times(flight: FittedFlight, goal: Floats, weights: Floats) -> Floats:
    """Candidate times (3, N): real roots of s^3 + p s + q = 0, s counted from the apex; a single root is repeated."""
    apex = flight.vy / GRAVITY
    top = flight.state(apex)
    wx, wy, wp, wd = weights
    # The weighted squared distance to the goal is a quartic of s; its derivative is the cubic. The height alone is
    # quadratic in s, so the height alone gives s^3.
    unit = wy * 0.5 * GRAVITY * GRAVITY
    drop = goal[:, 1] - top[:, 1]
    linear = (wx * flight.vx**2 + wp * flight.spin**2 + wd * GRAVITY**2 + wy * GRAVITY * drop) / unit
    constant = wx * flight.vx * (top[:, 0] - goal[:, 0]) + wp * flight.spin * (top[:, 2] - goal[:, 2])
    constant = (constant + wd * GRAVITY * goal[:, 3]) / unit
    return apex + _cubic_roots(linear, constant)


def _cubic_roots(p: Floats, q: Floats) -> Floats:
    """Real roots (3, N) of s^3 + p s + q by Cardano's and Viete's formulas, polished by Newton's method."""
    third, half = p / 3.0, 0.5 * q
    inside = half * half + third**3
    # A single root: the larger of the two cube roots first, the smaller from their product, without cancellation.
    large = -np.where(half < 0.0, -1.0, 1.0) * np.cbrt(np.abs(half) + np.sqrt(np.maximum(inside, 0.0)))
    single = large - third / np.where(large == 0.0, 1.0, large)
    radius = np.sqrt(np.maximum(-third, 0.0))
    cube = np.where(radius > 0.0, radius**3, 1.0)
    angle = np.arccos(np.clip(-half / cube, -1.0, 1.0)) / 3.0
    turns = 2.0 * np.pi / 3.0 * np.arange(3.0)[:, None]
    roots = np.where(inside > 0.0, single, 2.0 * radius * np.cos(angle - turns))
    for _ in range(POLISHES):
        value, slope = (roots * roots + p) * roots + q, 3.0 * roots * roots + p
        better = roots - value / np.where(slope == 0.0, 1.0, slope)
        gain = np.abs((better * better + p) * better + q) < np.abs(value)
        roots = np.where(gain, better, roots)
    return roots
