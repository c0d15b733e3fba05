"""Compiled functions that run as the Python text they are: with `NUMBA_DISABLE_JIT=1`, for debuggers and prints."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any, Final, final

import numpy as np

_THREAD: Final = threading.local()
"""Whether a function of `as_python` runs in this thread: `is_inner`."""


@final
class PythonRows:
    """Rows whose fields Python reads and writes as attributes, as machine code does; one row has no axis.

    Args:
        array: the rows; what is written here is written there.
    """

    __slots__ = ("array",)
    array: Any

    def __init__(self, array: Any) -> None:
        object.__setattr__(self, "array", array)

    def __getattr__(self, name: str) -> Any:
        array = self.array
        is_field = name in array.dtype.names and (array.ndim == 0 or not hasattr(array, name))
        return _for_python(array[name] if is_field else getattr(array, name))

    def __setattr__(self, name: str, value: Any) -> None:
        self.array[name] = _from_python(value)

    def __getitem__(self, index: Any) -> Any:
        return _for_python(self.array[(*index, ...) if isinstance(index, tuple) else (index, ...)])

    def __setitem__(self, index: Any, value: Any) -> None:
        self.array[index] = _from_python(value)

    def __len__(self) -> int:
        return len(self.array)


def as_python(function: Callable[..., Any]) -> Callable[..., Any]:
    """The text of a compiled function as a function that takes and gives what its machine code does."""

    def call(*arguments: Any) -> Any:
        is_inner, _THREAD.is_inner = getattr(_THREAD, "is_inner", False), True
        try:
            result = function(*map(_for_python, arguments))
        finally:
            _THREAD.is_inner = is_inner
        return result if is_inner else _from_python(result)

    # Machine code never warns of a sum that wraps around or of a division by zero.
    return np.errstate(all="ignore")(call)


def _for_python(value: Any) -> Any:
    """A value as the text of a compiled function reads it: rows with attributes, numbers out of their arrays."""
    if hasattr(value, "_fields"):
        return value._make(map(_for_python, value))
    if value.__class__ is not np.ndarray:
        return value
    return PythonRows(value) if value.dtype.names else value if value.ndim else value[()]


def _from_python(value: Any) -> Any:
    """A value of the text of a compiled function as arrays keep it and as machine code returns it."""
    if hasattr(value, "_fields"):
        return value._make(map(_from_python, value))
    if value.__class__ is tuple:
        return tuple(map(_from_python, value))
    return value.array if isinstance(value, PythonRows) else value
