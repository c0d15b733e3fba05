"""Machine code for loops over numbers; the one place that imports numba.

Loading numba takes a fifth of a second, so a module of compiled functions is imported where they are first called. It
holds all that its functions compute with: what is kept on disk is made anew when the text of that one file changes, and
constants of other modules are frozen into it.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from functools import cache, partial
from typing import Any, Final, TypeVar

import numba

FunctionT = TypeVar("FunctionT", bound=Callable[..., Any])

_NJIT: Final[Any] = partial(numba.njit, error_model="numpy")
"""Divisions as in numpy, inf and NaN instead of exceptions. No `fastmath`: every operation is rounded as written."""


def part(function: FunctionT) -> FunctionT:
    """A function that compiled ones call, and Python does not; it is compiled as a part of them."""
    return _NJIT(no_cpython_wrapper=True, no_cfunc_wrapper=True)(function)


def compiled(signature: str) -> Callable[[FunctionT], FunctionT]:
    """Compile a function for one set of types, when its module is imported, and keep the machine code on disk.

    It is kept in the folder `NUMBA_CACHE_DIR`, or beside the module, or where the user's caches lie: the first that can
    be written. Where none can, or what lies there cannot be read, every process compiles for itself, with a warning.

    Args:
        signature: types of result and arguments, as numba writes them.
    """

    def made(function: FunctionT) -> FunctionT:
        try:
            return _NJIT(signature, cache=True)(function)
        except Exception:  # whatever can be wrong with a folder; what is wrong with the code is so again below
            _warn()
            return _NJIT(signature)(function)

    return made


@cache
def _warn() -> None:
    """Once: how to get rid of seconds at the start of every process."""
    warnings.warn(
        "machine code cannot be kept or read, so every process makes it anew, which takes seconds; "
        "set NUMBA_CACHE_DIR to an empty folder that can be written",
        stacklevel=3,
    )
