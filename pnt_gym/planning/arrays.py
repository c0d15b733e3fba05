"""Array aliases and the shape checks shared by the planning room."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats: TypeAlias = NDArray[np.float64]
Bools: TypeAlias = NDArray[np.bool_]
Ints: TypeAlias = NDArray[np.int64]
Point: TypeAlias = Sequence[float] | Floats


def finite_points(values: ArrayLike, name: str) -> Floats:
    """Return ``values`` as a contiguous float64 array of shape (N, 3) [m].

    Raises:
        ValueError: if the shape is not (N, 3) or a coordinate is NaN or infinite.
    """
    points = np.ascontiguousarray(values, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3:
        raise ValueError(f"{name} must have shape (N, 3), got {points.shape}")
    _require_finite(points, name)
    return points


def finite_rows(values: ArrayLike, count: int, name: str) -> Floats:
    """Return ``values``, one number or (N,), as a contiguous float64 array of shape (count,).

    Raises:
        ValueError: if the shape is neither () nor (count,), or a value is NaN or infinite.
    """
    rows = np.asarray(values, dtype=np.float64)
    if rows.shape not in ((), (count,)):
        raise ValueError(f"{name} must be one number or have shape ({count},), got {rows.shape}")
    _require_finite(rows, name)
    return np.ascontiguousarray(np.broadcast_to(rows, (count,)))


def vector(value: Point, name: str) -> Floats:
    """Return ``value`` as a float64 array of shape (3,).

    Raises:
        ValueError: if it is not three finite numbers.
    """
    array = np.asarray(value, dtype=np.float64)
    if array.shape != (3,) or not np.isfinite(array).all():
        raise ValueError(f"{name} must be three finite numbers, got {value!r}")
    return array


def same_count(name: str, rows: int, other: str, other_rows: int) -> None:
    """Raise ValueError unless two arrays hold the same number of rows."""
    if rows != other_rows:
        raise ValueError(f"{name} has {rows} rows but {other} has {other_rows}; give one row each")


def length(vectors: Floats) -> Floats:
    """Return the Euclidean length (...,) of vectors (..., 3).

    The sum is written out so that a row gives the same bits whatever the batch size is.
    """
    x, y, z = vectors[..., 0], vectors[..., 1], vectors[..., 2]
    return np.sqrt(x * x + y * y + z * z)


def _require_finite(values: Floats, name: str) -> None:
    bad = ~np.isfinite(values)
    if bad.any():
        where = tuple(int(i) for i in np.argwhere(bad)[0])
        raise ValueError(f"{name} must be finite, got {values[bad][0]} at index {where}")
