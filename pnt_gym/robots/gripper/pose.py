"""Poses as arrays: what every function of the robot asks of them, and how they are cut into pieces for the cache."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats
from pnt_gym.errors import PntGymError

CHUNK = 2048
"""Rows worked on at once: an array of four arms is then 64 KiB, small enough for the cache and for cheap reuse."""


class PoseError(PntGymError):
    """A pose the robot cannot take, or an array that holds no poses."""


def pose_rows(pose: ArrayLike, name: str = "pose", width: int = 4) -> tuple[tuple[int, ...], Floats]:
    """Return the leading shape and the (M, width) rows of ``pose`` (..., width).

    Raises:
        PoseError: the last axis is not of that width, or a number is NaN or infinite.
    """
    shape, rows = any_rows(pose, name, width)
    bad = ~np.isfinite(rows)
    if bad.any():
        raise PoseError(f"{name} must be finite, got {rows[bad][0]} in {rows[bad.any(axis=1)][0].tolist()}")
    return shape, rows


def any_rows(values: ArrayLike, name: str, width: int) -> tuple[tuple[int, ...], Floats]:
    """``pose_rows`` that lets NaN and infinity through."""
    array = np.asarray(values, dtype=np.float64)
    if array.ndim == 0 or array.shape[-1] != width:
        raise PoseError(f"{name} must have shape (..., {width}), got {array.shape}")
    return array.shape[:-1], array.reshape(-1, width)


def pieces(count: int, size: int = CHUNK) -> Iterator[slice]:
    """Yield the slices that cut ``count`` rows into pieces of ``size``; at least one, which may be empty."""
    for start in range(0, max(count, 1), size):
        yield slice(start, min(start + size, count))


def in_pieces(of: Callable[[Floats], Floats], rows: Floats) -> Floats:
    """Return what ``of`` makes (M, ...) of the components (K, M) of rows (M, K), worked out piece by piece."""
    return np.concatenate([np.ascontiguousarray(of(columns(rows[piece]))) for piece in pieces(len(rows))])


def columns(rows: Floats) -> Floats:
    """Return (M, K) rows as (K, M) components, each contiguous."""
    return np.ascontiguousarray(rows.T)


def pose_pairs(start: ArrayLike, end: ArrayLike) -> tuple[tuple[int, ...], Floats, Floats]:
    """Two arrays of poses as rows (N, 4), with the shape (...,) that they share.

    Raises:
        PoseError: the shapes differ or are wrong, or a number is not finite.
    """
    shape, first = pose_rows(start, "start")
    other, last = pose_rows(end, "end")
    if shape != other:
        raise PoseError(f"start has shape {(*shape, 4)} but end has {(*other, 4)}; give one row each")
    return shape, first, last
