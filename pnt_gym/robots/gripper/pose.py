"""Arrays of poses: shape checks for every function of the robot, and work in pieces that fit the cache."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats, numbers
from pnt_gym.errors import PntGymError

CHUNK = 2048
"""Rows of a piece: an array of four arms is then 64 KiB, small enough for the cache and for cheap reuse."""


class PoseError(PntGymError):
    """A pose that the robot cannot take, or an array of the wrong shape for poses."""


def pose_rows(pose: ArrayLike, name: str = "pose", width: int = 4) -> tuple[tuple[int, ...], Floats]:
    """Return the leading shape and the (M, width) rows of ``pose`` (..., width).

    Raises:
        PoseError: the last axis does not have the width, or a number is NaN or infinite.
    """
    shape, rows = as_rows(pose, name, width)
    bad = ~np.isfinite(rows)
    if bad.any():
        raise PoseError(f"{name} must be finite, got {rows[bad][0]} in {rows[bad.any(axis=1)][0].tolist()}")
    return shape, rows


def as_rows(values: ArrayLike, name: str, width: int) -> tuple[tuple[int, ...], Floats]:
    """Return the leading shape and the rows as ``pose_rows``; NaN and infinity pass."""
    array = numbers(values, name)
    if array.ndim == 0 or array.shape[-1] != width:
        raise PoseError(f"{name} must have shape (..., {width}), got {array.shape}")
    return array.shape[:-1], array.reshape(-1, width)


def pieces(count: int, size: int = CHUNK) -> Iterator[slice]:
    """Yield slices of at most ``size`` that cover ``count`` rows; at least one slice, empty for no rows."""
    for start in range(0, max(count, 1), size):
        yield slice(start, min(start + size, count))


def map_pieces(function: Callable[[Floats], Floats], rows: Floats) -> Floats:
    """Return values (M, ...) of rows (M, K), piece by piece; ``function`` computes values from components (K, M)."""
    return np.concatenate([np.ascontiguousarray(function(columns(rows[piece]))) for piece in pieces(len(rows))])


def columns(rows: Floats) -> Floats:
    """Return (M, K) rows as (K, M) components, each contiguous."""
    return np.ascontiguousarray(rows.T)


def pose_pairs(start: ArrayLike, end: ArrayLike) -> tuple[tuple[int, ...], Floats, Floats]:
    """Return the leading shape (...,) that two arrays of poses share, and both arrays as rows (N, 4).

    Raises:
        PoseError: the shapes differ or are wrong, or a number is not finite.
    """
    shape, first = pose_rows(start, "start")
    end_shape, last = pose_rows(end, "end")
    if shape != end_shape:
        raise PoseError(f"start has shape {(*shape, 4)} but end has {(*end_shape, 4)}; give one row each")
    return shape, first, last
