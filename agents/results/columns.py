"""Columns of the rows of a result, as arrays of a file: an entry for each throw or work shift.

Letters stand as letters, and numbers as whole ones in units of the last decimal that the head gives for the column.
Rows with the same columns are a group, and a column of a group stands in one array: what its rows share is stored once.
Earlier versions wrote a table for each row, which is read too.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pnt_gym.errors import one_sentence

from ..ground.cli import UsageError
from ..ground.files import jsonable

GROUPS: Final = "groups"
"""Array with the group of each row; the array `GROUP NAME` holds a column of the group's rows (rows, entries, ...)."""
TABLES: Final = rf"{GROUPS}|\d+( .+)?"
"""Names of the arrays that hold columns; a number alone is a table of an earlier version."""
MOST_VALUES: Final = 2**24
"""Values in all tables of a result: as many numbers take half a gigabyte of memory."""
MOST_DECIMALS: Final = 6
"""Decimals up to which numbers are stored as whole ones."""


def with_columns(
    file: Path, heads: Sequence[dict[str, Any]], tables: Mapping[str, NDArray[Any]], decimals: Mapping[str, int]
) -> list[dict[str, Any]]:
    """Rows with the columns that the arrays of a file hold.

    Raises:
        UsageError: a column is missing or of another form.
    """
    rows: list[dict[str, Any]] = []
    left = MOST_VALUES
    split = _split if GROUPS in tables else _split_tables
    for head, stored in zip(heads, split(file, tables, len(heads)), strict=True):
        left -= sum(column.size for column in stored.values())
        if left < 0:
            raise UsageError(f"{str(file)!r} holds more than {MOST_VALUES:,} values")
        columns = {name: _values(file, name, column, decimals.get(name)) for name, column in stored.items()}
        rows.append({**head, "columns": {**head["columns"], **columns}})
    return rows


def _split(file: Path, tables: Mapping[str, NDArray[Any]], count: int) -> Iterator[dict[str, NDArray[Any]]]:
    """The stored columns of each row by name, from those of the groups.

    Raises:
        UsageError: the arrays are not of as many rows.
    """
    groups = tables[GROUPS]
    if groups.dtype.kind not in "iu" or groups.shape != (count,):
        raise UsageError(f"{str(file)!r} must name the group of each of the {count} rows")
    stored: list[dict[str, NDArray[Any]]] = [{} for _ in range(count)]
    for key, column in tables.items():
        if key == GROUPS:
            continue
        group, _, name = key.partition(" ")
        members = np.flatnonzero(groups == int(group))
        if not name or column.ndim < 2 or len(column) != len(members):
            raise UsageError(f"{str(file)!r}: {one_sentence(repr(key), 60)} does not hold {len(members)} rows")
        for row, values in zip(members, column, strict=True):
            stored[row][name] = values
    yield from stored


def _split_tables(file: Path, tables: Mapping[str, NDArray[Any]], count: int) -> Iterator[dict[str, NDArray[Any]]]:
    """The stored columns of each row by name, from tables of an earlier version.

    Raises:
        UsageError: a table is missing or of another form.
    """
    if tables.keys() != {str(number) for number in range(count)}:
        raise UsageError(f"{str(file)!r} must hold one table for each of the {count} rows")
    for number in range(count):
        table = tables[str(number)]
        names = table.dtype.names
        if names is None or table.ndim != 1 or not table.dtype.itemsize:
            raise UsageError(f"{str(file)!r}: {number} is no table")
        yield {name: table[name] for name in names}


def _values(file: Path, name: str, column: NDArray[Any], decimals: int | None) -> Any:
    """A column of a table as JSON values: a text, or a list of numbers in which None is a missing one."""
    kind = column.dtype.kind
    if column.dtype == np.dtype("S1") and column.ndim == 1:
        return column.tobytes().decode("latin-1")
    if kind not in "bif" or column.ndim > 2:
        raise UsageError(f"{str(file)!r}: column {one_sentence(repr(name), 60)} holds neither letters nor numbers")
    if kind != "i" or decimals is None:
        return jsonable(column)
    return jsonable(np.where(column == np.iinfo(column.dtype).min, np.nan, column / 10**decimals))


# Writing


def without_columns(
    results: Sequence[dict[str, Any]],
) -> tuple[list[dict[str, Any]], dict[str, int], dict[str, NDArray[Any]]]:
    """Rows without what arrays hold of them; the decimals of columns; and the arrays by name."""
    found = [_arrays(row["columns"]) for row in results]
    decimals = _decimals(found)
    forms = [tuple((name, array.dtype.kind, array.shape) for name, array in arrays.items()) for arrays in found]
    groups = list(dict.fromkeys(forms))
    tables = {GROUPS: np.array([groups.index(form) for form in forms], dtype=np.uint16)}
    for group, columns in enumerate(groups):
        members = [arrays for arrays, form in zip(found, forms, strict=True) if form == columns]
        for name, *_ in columns:
            whole = np.stack([arrays[name] for arrays in members])
            tables[f"{group} {name}"] = _stored(whole, decimals.get(name))
    rows: list[dict[str, Any]] = []
    for row, arrays in zip(results, found, strict=True):
        rest = {name: value for name, value in row["columns"].items() if name not in arrays}
        rows.append({**row, "columns": rest})
    return rows, decimals, tables


def _arrays(columns: Mapping[str, Any]) -> dict[str, NDArray[Any]]:
    """The columns with an entry for each throw or shift, as arrays; names, totals and other values stay in the head."""
    found: dict[str, NDArray[Any]] = {}
    for name, values in columns.items():
        array = _array(values) if isinstance(values, list | str) else None
        if array is not None and len(array) == len(next(iter(found.values()), array)):
            found[name] = array
    return found


def _array(values: list[Any] | str) -> NDArray[Any] | None:
    """Letters, or numbers of which None is NaN; None where there are other values, or lists of several lengths."""
    if isinstance(values, str):
        return np.array([*values], dtype="S1") if values.isascii() else None
    try:
        array = np.array(values)
    except ValueError:
        return None
    if array.dtype.kind == "O" and all(value is None or type(value) in (int, float) for value in array.flat):
        array = array.astype(np.float64)
    return array if array.dtype.kind in "bif" and array.ndim <= 2 and array.size else None


def _decimals(found: Sequence[Mapping[str, NDArray[Any]]]) -> dict[str, int]:
    """The decimals of a column's numbers, by column; without columns that whole numbers cannot hold."""
    columns: dict[str, list[NDArray[Any]]] = {}
    for name, array in (entry for arrays in found for entry in arrays.items()):
        columns.setdefault(name, []).append(array)
    exact: dict[str, int] = {}
    for name, arrays in columns.items():
        if any(array.dtype.kind == "f" for array in arrays):
            decimals = next((d for d in range(MOST_DECIMALS + 1) if _fits(arrays, d)), None)
            exact |= {} if decimals is None else {name: decimals}
    return exact


def _fits(arrays: Sequence[NDArray[Any]], decimals: int) -> bool:
    """Whether numbers can be stored as whole ones, in units of a decimal."""
    for array in arrays:
        numbers = array[np.isfinite(array)]
        units = np.round(numbers * 10.0**decimals)
        if np.any(np.abs(units) >= 2.0**53) or np.any(units / 10**decimals != numbers):
            return False
    return True


def _stored(array: NDArray[Any], decimals: int | None) -> NDArray[Any]:
    """A column in the smallest whole numbers that hold it; letters, and numbers of more decimals, as they are."""
    if array.dtype.kind not in "if" or (array.dtype.kind == "f" and decimals is None):
        return array
    is_missing = ~np.isfinite(array)
    units = np.where(is_missing, 0, np.round(array * 10 ** (decimals or 0))).astype(np.int64)
    low, high = units.min(), units.max()
    kind = next(k for k in (np.int8, np.int16, np.int32, np.int64) if np.iinfo(k).min < low and high <= np.iinfo(k).max)
    return np.where(is_missing, np.iinfo(kind).min, units).astype(kind)
