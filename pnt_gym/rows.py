"""Rows of frozen dataclasses whose fields are arrays with the same leading shape."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from typing import Any, TypeVar, cast

import numpy as np

RecordT = TypeVar("RecordT")


def take(record: RecordT, index: Any) -> RecordT:
    """The record at a numpy index of the leading shape; fields that are neither arrays nor records stay.

    Args:
        record: a dataclass of arrays, other such dataclasses and plain values.
        index: any numpy index.
    """
    values: dict[str, Any] = {}
    for field in fields(cast(Any, record)):
        value: Any = getattr(record, field.name)
        if is_dataclass(value):
            values[field.name] = take(value, index)
        else:
            values[field.name] = cast(Any, value)[index] if isinstance(value, np.ndarray) else value
    return type(record)(**values)


def put(record: RecordT, index: Any, other: RecordT) -> None:
    """Overwrite the record's arrays at a numpy index in place with those of another record."""
    for field in fields(cast(Any, record)):
        value, new = getattr(record, field.name), getattr(other, field.name)
        if isinstance(value, np.ndarray):
            value[index] = new
        elif is_dataclass(value):
            put(value, index, new)
