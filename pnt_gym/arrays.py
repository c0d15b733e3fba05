"""Array aliases, shape checks of plans, and functions that take, replace and concatenate rows of records of arrays."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import fields, is_dataclass
from functools import cache
from operator import attrgetter, itemgetter, methodcaller
from typing import Any, TypeAlias, TypeVar, TypeVarTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pnt_gym.errors import PlanningError, one_sentence

Floats: TypeAlias = NDArray[np.float64]
Bools: TypeAlias = NDArray[np.bool_]
Ints: TypeAlias = NDArray[np.int64]
Point: TypeAlias = Sequence[float] | Floats

ArraysT = TypeVarTuple("ArraysT")
RecordT = TypeVar("RecordT")
KindT = TypeVar("KindT")


def numbers(values: ArrayLike, name: str) -> Floats:
    """Return ``values`` as a float64 array, of any shape.

    Raises:
        ValueError: if the values are no numbers, or rows of different lengths.
    """
    try:
        return np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise PlanningError(f"{name} must be numbers, got {one_sentence(repr(values), 80)}") from None


def number(value: ArrayLike, name: str) -> float:
    """Return ``value`` as a float.

    Raises:
        ValueError: if the value is not one number.
    """
    array = numbers(value, name)
    if array.ndim:
        raise PlanningError(f"{name} must be one number, got shape {array.shape}")
    return array.item()


def of_kind(value: object, kind: type[KindT], name: str) -> KindT:
    """Return ``value``, which must be a ``kind``.

    Raises:
        ValueError: if the value is something else.
    """
    if not isinstance(value, kind):
        raise PlanningError(f"{name} must be of the class {kind.__name__}, got {one_sentence(repr(value), 80)}")
    return value


def column(values: ArrayLike, name: str) -> Floats:
    """Return ``values`` as a float64 array of shape (N,).

    Raises:
        ValueError: if the shape differs.
    """
    array = numbers(values, name)
    if array.ndim != 1:
        raise PlanningError(f"{name} must have shape (N,), got {array.shape}")
    return array


def tuples(values: ArrayLike, name: str, width: int = 3) -> Floats:
    """Return ``values`` as a float64 array of shape (..., width).

    Raises:
        ValueError: if the shape differs.
    """
    array = numbers(values, name)
    if array.shape[-1:] != (width,):
        raise PlanningError(f"{name} must have shape (..., {width}), got {array.shape}")
    return array


def rows_of_three(values: ArrayLike, name: str, count: int | None = None) -> Floats:
    """Return ``values`` as a contiguous float64 array of shape (N, 3) [m], with N = ``count`` unless ``count`` is None.

    Raises:
        ValueError: if the shape differs.
    """
    rows = np.ascontiguousarray(numbers(values, name))
    if rows.ndim != 2 or rows.shape[1] != 3 or count not in (None, len(rows)):
        shape = "(N, 3)" if count is None else f"({count}, 3), one row each"
        raise PlanningError(f"{name} must have shape {shape}, got {rows.shape}")
    return rows


def finite_points(values: ArrayLike, name: str, count: int | None = None) -> Floats:
    """Return ``values`` as `rows_of_three`.

    Raises:
        ValueError: if the shape differs or a coordinate is NaN or infinite.
    """
    points = rows_of_three(values, name, count)
    if not np.isfinite(points).all():
        raise not_finite_error(points, name)
    return points


def finite_rows(values: ArrayLike, count: int, name: str) -> Floats:
    """Return ``values``, one number or (N,), as a contiguous float64 array of shape (count,).

    Raises:
        ValueError: if the shape is neither () nor (count,), or a value is NaN or infinite.
    """
    rows = numbers(values, name)
    if rows.shape not in ((), (count,)):
        raise PlanningError(f"{name} must be one number or have shape ({count},), got {rows.shape}")
    if not np.isfinite(rows).all():
        raise not_finite_error(rows, name)
    return np.full(count, rows) if rows.ndim == 0 else np.ascontiguousarray(rows)


def vector(value: Point, name: str) -> Floats:
    """Return ``value`` as a float64 array of shape (3,).

    Raises:
        ValueError: if ``value`` is not three finite numbers.
    """
    array = numbers(value, name)
    if array.shape != (3,) or not np.isfinite(array).all():
        raise PlanningError(f"{name} must be three finite numbers, got {value!r}")
    return array


def length(vectors: Floats) -> Floats:
    """Return the Euclidean length (...,) of vectors (..., 3).

    The sum is written out so that a row gives the same bits whatever the batch size is.
    """
    x, y, z = vectors[..., 0], vectors[..., 1], vectors[..., 2]
    return np.sqrt(x * x + y * y + z * z)


def dot(first: Floats, second: Floats) -> Floats:
    """Return the scalar product (...,) of vectors (..., 3), written out as in `length`."""
    return first[..., 0] * second[..., 0] + first[..., 1] * second[..., 1] + first[..., 2] * second[..., 2]


def in_order(*arrays: *ArraysT) -> tuple[*ArraysT]:
    """The arrays as compiled functions take them: copies of those that are views across rows, or read only."""
    columns: Any = arrays
    ordered: Any = tuple([array if array.flags.carray else array.copy() for array in columns])
    return ordered


def join_columns(first: Floats, *columns: Floats | float) -> Floats:
    """Arrays S, or single numbers, as the last axis of an array S + (K,): `np.stack` in a fifth of its time."""
    result = np.empty((*first.shape, 1 + len(columns)))
    result[..., 0] = first
    for k, column in enumerate(columns, 1):
        result[..., k] = column
    return result


def words(rows: NDArray[Any]) -> Floats:
    """The rows as doubles, with one more axis: a view."""
    return rows[..., None].view(np.float64)


def rows_of_words(doubles: Floats, dtype: np.dtype[np.void]) -> Any:
    """The rows that `words` gives as doubles."""
    return np.ndarray(doubles.shape[:-1], dtype, np.ascontiguousarray(doubles))


def recast(rows: NDArray[Any], dtype: np.dtype[np.void] | None = None) -> NDArray[np.void]:
    """The rows as rows of another type of their size: a view, in a third of the time of `ndarray.view`.

    None stands for values without fields: NumPy copies rows of many fields one field after the other.
    """
    dtype = _without_fields(rows.itemsize) if dtype is None else dtype
    return np.ndarray(rows.shape, dtype, rows) if rows.flags.c_contiguous else rows.view(dtype)


def copy_rows(rows: NDArray[Any]) -> Any:
    """A copy of rows, in C's order, without a way through their fields."""
    return recast(recast(rows).copy(), rows.dtype)


@cache
def _without_fields(size: int) -> np.dtype[np.void]:
    return np.dtype((np.void, size))


def take(record: RecordT, index: Any) -> RecordT:
    """The record whose arrays are indexed along their leading shape; fields that are neither arrays nor records stay.

    Args:
        record: an array, also of rows; or `Columns`, a dataclass, tuple or dict of arrays, records and plain values.
        index: any numpy index.
    """
    is_list = index.__class__ is np.ndarray and index.dtype == np.int64
    # `ndarray.take` needs a quarter of the time.
    return _map_arrays(methodcaller("take", index, 0) if is_list else itemgetter(index), record)


def take_rows(record: RecordT, rows: Ints, count: int) -> RecordT:
    """The record of some rows in ascending order; the record itself where these are all of its `count` rows."""
    return record if len(rows) == count else take(record, rows)


def stand_ins(rows: Ints, count: int) -> Ints:
    """Positions of the rows 0 to N - 1 among some rows (K,); the first one stands in for a row that is not there.

    Args:
        rows: at least one row.
        count: number of rows N.
    """
    places = np.zeros(count, dtype=np.int64)
    places[rows] = np.arange(len(rows))
    return places


def replace_rows(record: RecordT, index: Any, source: RecordT) -> RecordT:
    """A copy of the record in which another record's arrays overwrite the rows at a numpy index."""

    def overwrite(values: Floats, new: Floats) -> Floats:
        result = values.copy()
        result[index] = new
        return result

    return _map_arrays(overwrite, record, source)


def put_rows(record: RecordT, rows: Ints, source: RecordT, count: int) -> RecordT:
    """The record with some of its `count` rows, in ascending order, from a source; without a copy for all or none."""
    if len(rows) == count:
        return source
    return replace_rows(record, rows, source) if len(rows) > 0 else record


def concatenate_records(records: Sequence[RecordT], axis: int = 0) -> RecordT:
    """The rows of all records, concatenated along an axis; plain values come from the first record."""

    def concatenate(*values: Floats) -> Floats:
        return np.concatenate(values, axis=axis)

    return _map_arrays(concatenate, *records)


def recompute_rows(record: RecordT, mask: Bools, make: Callable[..., RecordT], *inputs: Any) -> RecordT:
    """A copy of the record in which the masked rows are computed again; the record itself where the mask is empty.

    Args:
        record: N rows.
        mask: True for the rows to compute (N,).
        make: computes the record of the masked rows from the masked rows of ``inputs``.
        inputs: arguments of ``make``: records and arrays of N rows, and plain values.
    """
    rows = mask.nonzero()[0]
    return replace_rows(record, rows, make(*take(inputs, rows))) if rows.size > 0 else record


def compute_by_mask(
    mask: Bools, make_masked: Callable[..., RecordT], make_unmasked: Callable[..., RecordT], *inputs: Any
) -> RecordT:
    """A record of N rows: one function computes the masked rows, another function the unmasked rows.

    Args:
        mask: True for the rows that ``make_masked`` computes (N,).
        make_masked: computes the record of the masked rows from the masked rows of ``inputs``.
        make_unmasked: computes the record of the unmasked rows from the unmasked rows of ``inputs``.
        inputs: arguments of both functions: records and arrays of N rows, and plain values.
    """
    rows, others = mask.nonzero()[0], (~mask).nonzero()[0]
    if len(others) == 0:
        return make_masked(*inputs)
    if len(rows) == 0:
        return make_unmasked(*inputs)
    record = concatenate_records([make_masked(*take(inputs, rows)), make_unmasked(*take(inputs, others))])
    return take(record, np.argsort(np.concatenate([rows, others])))


def _map_arrays(change: Callable[..., Any], *records: Any) -> Any:
    """A record of the same type, each array computed by ``change`` from the records' arrays of that name."""
    first = records[0]
    kind: Any = first.__class__
    if kind is np.ndarray:
        if first.dtype.names is None:
            return change(*records)
        return recast(np.asarray(change(*map(recast, records)), order="C"), first.dtype)
    if kind is tuple:  # and no NamedTuple
        return tuple([_map_arrays(change, *column) for column in zip(*records, strict=True)])
    if kind is dict:
        return {name: _map_arrays(change, *map(itemgetter(name), records)) for name in first}
    readers = _readers(kind)
    return kind(*[_map_arrays(change, *map(reader, records)) for reader in readers]) if readers else first


@cache
def _readers(kind: Any) -> tuple[Callable[[Any], Any], ...]:
    """What reads the constructor fields of a record type, in their order; nothing for any other type."""
    if is_dataclass(kind):
        return tuple([attrgetter(field.name) for field in fields(kind) if field.init])
    return tuple(map(attrgetter, getattr(kind, "_fields", ())))


def not_finite_error(values: Floats, name: str) -> PlanningError:
    """The error that names the first NaN or infinite value and its index."""
    bad = ~np.isfinite(values)
    index = tuple(int(i) for i in np.argwhere(bad)[0])
    return PlanningError(f"{name} must be finite, got {values[bad][0]} at index {index}")
