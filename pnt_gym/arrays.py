"""Array aliases, shape checks of plans, and functions that take, replace and concatenate rows of records of arrays."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import fields, is_dataclass
from functools import cache
from operator import attrgetter, itemgetter
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pnt_gym.errors import PlanningError

Floats: TypeAlias = NDArray[np.float64]
Bools: TypeAlias = NDArray[np.bool_]
Ints: TypeAlias = NDArray[np.int64]
Point: TypeAlias = Sequence[float] | Floats

RecordT = TypeVar("RecordT")


def finite_points(values: ArrayLike, name: str, count: int | None = None) -> Floats:
    """Return ``values`` as a contiguous float64 array of shape (N, 3) [m], with N = ``count`` unless ``count`` is None.

    Raises:
        ValueError: if the shape differs or a coordinate is NaN or infinite.
    """
    points = np.ascontiguousarray(values, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3 or count not in (None, len(points)):
        wanted = "(N, 3)" if count is None else f"({count}, 3), one row each"
        raise PlanningError(f"{name} must have shape {wanted}, got {points.shape}")
    if not np.isfinite(points).all():
        raise not_finite(points, name)
    return points


def finite_rows(values: ArrayLike, count: int, name: str) -> Floats:
    """Return ``values``, one number or (N,), as a contiguous float64 array of shape (count,).

    Raises:
        ValueError: if the shape is neither () nor (count,), or a value is NaN or infinite.
    """
    rows = np.asarray(values, dtype=np.float64)
    if rows.shape not in ((), (count,)):
        raise PlanningError(f"{name} must be one number or have shape ({count},), got {rows.shape}")
    if not np.isfinite(rows).all():
        raise not_finite(rows, name)
    return np.ascontiguousarray(np.broadcast_to(rows, (count,)))


def vector(value: Point, name: str) -> Floats:
    """Return ``value`` as a float64 array of shape (3,).

    Raises:
        ValueError: if ``value`` is not three finite numbers.
    """
    array = np.asarray(value, dtype=np.float64)
    if array.shape != (3,) or not np.isfinite(array).all():
        raise PlanningError(f"{name} must be three finite numbers, got {value!r}")
    return array


def length(vectors: Floats) -> Floats:
    """Return the Euclidean length (...,) of vectors (..., 3).

    The sum is written out so that a row gives the same bits whatever the batch size is.
    """
    x, y, z = vectors[..., 0], vectors[..., 1], vectors[..., 2]
    return np.sqrt(x * x + y * y + z * z)


def dot(one: Floats, other: Floats) -> Floats:
    """Return the scalar product (...,) of vectors (..., 3), written out as in `length`."""
    return one[..., 0] * other[..., 0] + one[..., 1] * other[..., 1] + one[..., 2] * other[..., 2]


def take(record: RecordT, index: Any) -> RecordT:
    """The record whose arrays are indexed along their leading shape; fields that are neither arrays nor records stay.

    Args:
        record: a dataclass, a NamedTuple or a dict of arrays, nested records and plain values.
        index: any numpy index.
    """
    return _each(itemgetter(index), record)


def replaced(record: RecordT, index: Any, other: RecordT) -> RecordT:
    """A copy of the record in which another record's arrays overwrite the rows at a numpy index."""

    def overwritten(values: Floats, new: Floats) -> Floats:
        mixed = values.copy()
        mixed[index] = new
        return mixed

    return _each(overwritten, record, other)


def made_anew(record: RecordT, which: Bools, make: Callable[..., RecordT], *given: Any) -> RecordT:
    """A copy of the record in which the masked rows are computed again; the record itself where the mask is empty.

    Args:
        record: N rows.
        which: True for the rows to compute (N,).
        make: computes the record of the masked rows from the masked rows of ``given``.
        given: arguments of ``make``: records and arrays of N rows, and plain values.
    """
    rows = np.flatnonzero(which)
    return replaced(record, rows, make(*(take(one, rows) for one in given))) if rows.size > 0 else record


def either(which: Bools, make: Callable[..., RecordT], other: Callable[..., RecordT], *given: Any) -> RecordT:
    """A record of N rows: one function computes the masked rows, another function the unmasked rows.

    Args:
        which: True for the rows that ``make`` computes (N,).
        make: computes the record of the masked rows from the masked rows of ``given``.
        other: computes the record of the unmasked rows from the unmasked rows of ``given``.
        given: arguments of both functions: records and arrays of N rows, and plain values.
    """
    if which.all():
        return make(*given)
    if not which.any():
        return other(*given)
    ways = (np.flatnonzero(which), make), (np.flatnonzero(~which), other)
    both = joined([way(*(take(one, rows) for one in given)) for rows, way in ways])
    return take(both, np.argsort(np.concatenate([rows for rows, _ in ways])))


def joined(records: Sequence[RecordT], axis: int = 0) -> RecordT:
    """The rows of all records, concatenated along an axis; plain values come from the first record."""

    def one_after_the_other(*values: Floats) -> Floats:
        return np.concatenate(values, axis=axis)

    return _each(one_after_the_other, *records)


def _each(change: Callable[..., Any], first: Any, *others: Any) -> Any:
    """A record of the same type, each array computed by ``change`` from the records' arrays of that name."""
    if isinstance(first, np.ndarray):
        return change(first, *others)
    if first.__class__ is dict:
        return {name: _each(change, *(record[name] for record in (first, *others))) for name in first}
    made: dict[str, Any] = {}
    for name in _columns(first.__class__):
        made[name] = _each(change, *map(attrgetter(name), (first, *others)))
    return first.__class__(**made) if made else first


@cache
def _columns(kind: Any) -> tuple[str, ...]:
    """Names of the constructor fields of a record type; empty for any other type."""
    if is_dataclass(kind):
        return tuple(field.name for field in fields(kind) if field.init)
    return getattr(kind, "_fields", ())


def not_finite(values: Floats, name: str) -> PlanningError:
    """The error that names the first NaN or infinite value and its index."""
    bad = ~np.isfinite(values)
    where = tuple(int(i) for i in np.argwhere(bad)[0])
    return PlanningError(f"{name} must be finite, got {values[bad][0]} at index {where}")
