"""Positions that the platform reaches at an angle of its halves, and the range of tau over positions (section V)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Bools, Floats, Ints
from pnt_gym.errors import ConfigError
from pnt_gym.robots.gripper.closure import Arms, solve_arms
from pnt_gym.robots.gripper.geometry import PROTOTYPE, Dimensions
from pnt_gym.robots.gripper.indices import arms_tau
from pnt_gym.robots.gripper.kinematics import within_strokes
from pnt_gym.robots.gripper.pose import CHUNK, PoseError, columns, pieces, pose_rows


@final
@dataclass(frozen=True, eq=False)
class Workspace:
    """The positions of a grid that the robot reaches."""

    positions: Floats
    """Positions x, y, z of the platform's middle (M, 3) [m]; multiples of the step, by x, then y, then z."""
    theta: float
    """Angle of the halves [rad]."""
    step: float
    """Spacing of the grid [m]."""

    @property
    def volume(self) -> float:
        """Number of positions times the volume of a grid cell [m3]."""
        return len(self.positions) * self.step**3

    @property
    def extent(self) -> Floats:
        """Smallest and largest x, y, z [m], (2, 3); NaN for a workspace without positions."""
        if not len(self.positions):
            return np.full((2, 3), np.nan)
        return np.stack([self.positions.min(axis=0), self.positions.max(axis=0)])

    @property
    def poses(self) -> Floats:
        """Poses (M, 4): positions and theta."""
        return np.column_stack([self.positions, np.full(len(self.positions), self.theta)])


@final
@dataclass(frozen=True, eq=False)
class TauHull:
    """Smallest and largest tau over many positions, for each of T angles (Fig. 6); (T,) each."""

    theta: Floats
    """Angles of the halves [rad]."""
    low: Floats
    """Smallest tau; NaN where the robot reaches no position."""
    high: Floats
    """Largest tau; NaN where the robot reaches no position."""
    count: Ints
    """Number of positions that the robot reaches at each angle."""


def scan_workspace(
    step: float = 0.005,
    theta: float | None = None,
    dimensions: Dimensions = PROTOTYPE,
    *,
    reduced: bool = True,
) -> Workspace:
    """Return the reachable part of a grid below the base (section V-A).

    Args:
        step: spacing in x, y and z [m]; the grid passes through the origin.
        theta: angle of the halves [rad]; home's angle when not given.
        dimensions: dimensions of the robot.
        reduced: whether the motors' strokes count (the paper's reduced workspace), or only Eq. 7 (full workspace).

    Raises:
        ConfigError: (a ValueError) the step or the angle is not finite, or the step is not positive.
    """
    angle = dimensions.home_theta if theta is None else theta
    if not (np.isfinite(step) and step > 0.0):
        raise ConfigError(f"step is {step} m; the spacing of the grid must be positive and finite")
    if not np.isfinite(angle):
        raise ConfigError(f"theta is {angle}; it must be finite")
    x, y, z = _axes(step, dimensions)
    parts: list[Floats] = []
    # Whole columns of z at a time, so that the whole grid is never in memory.
    for piece in pieces(x.size * y.size, max(1, CHUNK // z.size)):
        i, j = np.divmod(np.arange(piece.start, piece.stop, dtype=np.int64), y.size)
        position = np.stack([np.repeat(x[i], z.size), np.repeat(y[j], z.size), np.tile(z, i.size)])
        inside = _is_reachable(_arms(position, angle, dimensions), dimensions, reduced)
        parts.append(position[:, inside].T)
    return Workspace(np.concatenate(parts), float(angle), float(step))


def tau_hull(
    positions: ArrayLike,
    theta: ArrayLike | None = None,
    dimensions: Dimensions = PROTOTYPE,
    *,
    reduced: bool = True,
) -> TauHull:
    """Return the range of tau over the positions, angle by angle (section V-D, Fig. 6).

    Args:
        positions: positions of the platform's middle (M, 3) [m].
        theta: angles (T,) [rad]; 101 angles from -pi/2 to pi/2 as in the paper when not given.
        dimensions: dimensions of the robot.
        reduced: whether positions beyond the strokes at an angle are left out at that angle.

    Raises:
        PoseError: (a ValueError) the shape of an argument is wrong, or a number is not finite.
    """
    shape, rows = pose_rows(positions, "positions", 3)
    if len(shape) != 1:
        raise PoseError(f"positions must have shape (M, 3), got {(*shape, 3)}")
    angles = np.linspace(-np.pi / 2, np.pi / 2, 101) if theta is None else np.asarray(theta, dtype=np.float64)
    if angles.ndim != 1 or not np.isfinite(angles).all():
        raise PoseError(f"theta must be finite angles of shape (T,), got shape {angles.shape}")
    low, high = np.full(angles.size, np.inf), np.full(angles.size, -np.inf)
    count = np.zeros(angles.size, dtype=np.int64)
    for piece in pieces(rows.shape[0]):
        position = columns(rows[piece])
        for t, angle in enumerate(angles):
            arms = _arms(position, float(angle), dimensions)
            inside = _is_reachable(arms, dimensions, reduced)
            values = arms_tau(arms)
            low[t] = min(low[t], np.min(values, where=inside, initial=np.inf))
            high[t] = max(high[t], np.max(values, where=inside, initial=-np.inf))
            count[t] += np.count_nonzero(inside)
    empty = count == 0
    low[empty] = high[empty] = np.nan
    return TauHull(angles, low, high, count)


def _axes(step: float, dims: Dimensions) -> tuple[Floats, Floats, Floats]:
    """Multiples of the step along x, y, z that bound all reachable positions; a forearm reaches its length sideways."""
    side = int(dims.l / step)
    across = step * np.arange(-side, side + 1, dtype=np.float64)
    return across, across, step * np.arange(-int((dims.r + dims.l) / step), 1, dtype=np.float64)


def _arms(position: Floats, theta: float, dims: Dimensions) -> Arms:
    return solve_arms(np.concatenate([position, np.full((1, position.shape[1]), theta)]), dims)


def _is_reachable(arms: Arms, dims: Dimensions, reduced: bool) -> Bools:
    """Whether the robot reaches each position, within the motors' strokes if ``reduced``."""
    if reduced:
        return within_strokes(np.arctan2(arms.sin, arms.cos), dims)
    return ~np.isnan(arms.sin.sum(axis=0))
