"""Machine code for loops over numbers; the only module that imports numba.

Loading numba takes a fifth of a second, so a module of compiled functions is imported where they are first called. Such
a module defines every function and constant that it compiles: numba renews the code on disk only when the text of that
file changes, and constants of other modules are frozen into the code.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from functools import cache, partial
from typing import Any, Final, TypeVar

import numba

FunctionT = TypeVar("FunctionT", bound=Callable[..., Any])

_NJIT: Final[Any] = partial(numba.njit, error_model="numpy", nogil=True)
"""Divisions as in numpy, inf and NaN instead of exceptions; other threads go on meanwhile.

No `fastmath`: every operation is rounded as written."""


def kernel_part(function: FunctionT) -> FunctionT:
    """Compile a function that only compiled functions call, not Python; numba makes it a part of its callers."""
    return _NJIT(no_cpython_wrapper=True, no_cfunc_wrapper=True)(function)


def compile_for(signature: str) -> Callable[[FunctionT], FunctionT]:
    """Compile a function for one set of types, when its module is imported, and keep the machine code on disk.

    The machine code lies in the folder `NUMBA_CACHE_DIR`, next to the module, or in the user's cache: the first of
    these folders that can be written. Where no folder can be written, or the stored code cannot be read, every process
    compiles for itself, with a warning.

    Args:
        signature: types of result and arguments, in numba's notation.
    """

    def decorate(function: FunctionT) -> FunctionT:
        try:
            return _NJIT(signature, cache=True)(function)
        except Exception:  # any error of the cache folder; an error of the code is raised again below
            _warn()
            return _NJIT(signature)(function)

    return decorate


@cache
def _warn() -> None:
    """Warn once that every process compiles anew, and say how to avoid that."""
    warnings.warn(
        "machine code cannot be kept or read, so every process makes it anew, which takes seconds; "
        "set NUMBA_CACHE_DIR to an empty folder that can be written",
        stacklevel=3,
    )
