"""Records of arrays whose columns are computed, copied or unpacked from a block when they are first read."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import fields
from functools import cache
from typing import TYPE_CHECKING, Any, Final, Generic, NamedTuple, Self, TypeVar, get_type_hints

import numpy as np
from numpy.typing import NDArray

RecordT = TypeVar("RecordT")

ValueT = TypeVar("ValueT")

MOST_UNREAD: Final = 8
"""Longest chain of records of which each waits for columns of the next; a longer chain would keep old rows alive."""


class BlockColumn(NamedTuple):
    """Place of a record's column in the rows of a block."""

    columns: slice
    shape: tuple[int, ...]
    dtype: Any
    place: tuple[Any, ...]
    """Index of the column in a block."""


class Layout(NamedTuple):
    """Places of a record's columns in the rows of a block, by name; a `Layout` for a record in the record."""

    kind: type[Any]
    parts: dict[str, Any]


class computed(Generic[ValueT]):
    """A value that is computed when it is first read of an object, and kept there.

    It is `functools.cached_property` without the lock that this takes before Python 3.12.
    """

    def __init__(self, compute: Callable[[Any], ValueT]) -> None:
        self._compute, self.__doc__ = compute, compute.__doc__

    def __set_name__(self, _: type[Any], name: str) -> None:
        self._name = name

    def __get__(self, record: Any, _: Any = None) -> ValueT:
        if record is None:
            return self  # pyright: ignore[reportReturnType] - of the class, for those who read its documentation
        value = record.__dict__[self._name] = self._compute(record)
        return value


class Record:
    """Base of frozen dataclasses of arrays, whose columns are computed or copied when they are first read.

    A record of objects has forty columns, and most callers read few columns of the rows that they take. So `take`,
    `replace_rows` and `concatenate_records` give records whose columns are not read yet. A packed record (`pack`) has
    all columns in one block S + (C,), which these functions index, copy and join as one array. The arrays of a record
    are never overwritten, so it does not matter when a column is read. A subclass has no defaults and no
    `__post_init__`.
    """

    if not TYPE_CHECKING:  # A type checker would accept any name.

        def __getattr__(self, name: str) -> Any:
            state = self.__dict__
            if "_block" in state and name in state["_layout"].parts:
                column = _unpack(state["_block"], state["_layout"].parts[name])
            elif "_read" in state and name in _column_names(self.__class__):
                column = state["_read"](name)
            else:
                raise AttributeError(f"{type(self).__name__!r} has no attribute {name!r}", name=name, obj=self)
            state[name] = column
            return column

    def pack(self) -> Self:
        """The record with all columns in one block; the first column has one number for each row."""
        arrays: list[NDArray[Any]] = []
        _collect_arrays(self, arrays)
        shape = arrays[0].shape
        layout = _lay_out(self.__class__, tuple([(array.shape[len(shape) :], array.dtype.str) for array in arrays]))
        return packed_record(
            self.__class__, np.concatenate([array.reshape(*shape, -1) for array in arrays], axis=-1), layout
        )

    @classmethod
    def unread(cls, read: Callable[[str], Any], depth: int) -> Self:
        """A record whose columns ``read`` computes by name, at the end of a chain of ``depth`` unread records."""
        record = object.__new__(cls)
        if depth > MOST_UNREAD:
            record.__dict__.update((name, read(name)) for name in _column_names(cls))
        else:
            record.__dict__.update(_read=read, _depth=depth)
        return record

    def replace(self, **columns: Any) -> Self:
        """The record with other columns by name; columns that were not read yet stay unread."""
        names, before = _column_names(self.__class__), self.__dict__
        assert columns.keys() <= names.keys(), f"{type(self).__name__} has no {sorted(columns.keys() - names.keys())}"
        result = object.__new__(self.__class__)
        result.__dict__.update(
            {name: value for name, value in before.items() if name in names or name in _UNREAD_STATE}, **columns
        )
        return result

    def overwrite(self, rows: Any, source: Self) -> None:
        """Write rows of all columns, in place; only for a record of which no unread record was taken.

        Args:
            rows: a numpy index.
            source: the rows; packed if this record is packed.
        """
        state = self.__dict__
        if "_block" in state:
            state["_block"][rows] = source.__dict__["_block"]
        for name in _column_names(self.__class__):
            if "_block" in state and name not in state:
                continue
            column = getattr(self, name)
            if isinstance(column, Record):
                column.overwrite(rows, getattr(source, name))
            else:
                column[rows] = getattr(source, name)

    def __getstate__(self) -> tuple[dict[str, Any], bool]:
        return {name: getattr(self, name) for name in _column_names(self.__class__)}, "_is_packed" in self.__dict__

    def __setstate__(self, state: tuple[dict[str, Any], bool]) -> None:
        self.__dict__.update(state[0])
        if state[1]:
            packed = self.pack()
            self.__dict__.clear()  # a record in the record is in this block again, and in none of its own
            self.__dict__.update(packed.__dict__)


_UNREAD_STATE: Final = frozenset(("_block", "_layout", "_read", "_depth"))


def packed_record(kind: type[RecordT], block: NDArray[Any], layout: Layout) -> RecordT:
    """The record whose columns lie in a block; none of them is read yet."""
    record = object.__new__(kind)
    record.__dict__.update(_block=block, _layout=layout, _is_packed=True)
    return record


def _collect_arrays(record: Record, arrays: list[NDArray[Any]]) -> None:
    """Append the columns of a record and of the records in the record, in their order."""
    for name, kind in _column_names(record.__class__).items():
        if isinstance(kind, type):
            _collect_arrays(getattr(record, name), arrays)
        else:
            arrays.append(getattr(record, name))


@cache
def _lay_out(kind: type[Record], columns: tuple[tuple[tuple[int, ...], str], ...]) -> Layout:
    """The layout of a record type whose columns have these shapes, behind that of the rows, and these types."""
    remaining = iter(columns)
    begin = 0

    def lay_out(kind: type[Record]) -> Layout:
        nonlocal begin
        parts: dict[str, Any] = {}
        for name, inner in _column_names(kind).items():
            if isinstance(inner, type):
                parts[name] = lay_out(inner)
            else:
                shape, dtype = next(remaining)
                columns = slice(begin, begin + math.prod(shape))
                parts[name] = BlockColumn(columns, shape, np.dtype(dtype), (..., columns if shape else begin))
                begin = columns.stop
        return Layout(kind, parts)

    return lay_out(kind)


def _unpack(block: NDArray[Any], part: Any) -> Any:
    """A copy of a column, or the record in the record."""
    if part.__class__ is Layout:
        return packed_record(part.kind, block, part)
    column = block[part.place].astype(part.dtype)
    return column.reshape(block.shape[:-1] + part.shape) if part.shape[1:] else column


@cache
def _column_names(kind: Any) -> dict[str, Any]:
    """Names of the columns of a record type in their order, with the type of a column that is a `Record`; else None."""
    types = get_type_hints(kind)
    records = {name: type_ for name, type_ in types.items() if isinstance(type_, type) and issubclass(type_, Record)}
    return {field.name: records.get(field.name) for field in fields(kind)}
