"""Machine code for loops over numbers; the only module that imports numba.

Loading numba takes a fifth of a second, so a module of compiled functions is imported where they are first called.
A compiled function may call compiled functions and read constants of other modules: the machine code on disk is renewed
when any of these changes.
"""

from __future__ import annotations

import gc
import hashlib
import inspect
import sys
import warnings
from collections.abc import Callable, Generator
from contextlib import contextmanager
from functools import cache, partial
from pathlib import Path
from types import FunctionType
from typing import Annotated, Any, Final, TypeVar, cast, get_args, get_origin, get_type_hints

import numba
import numpy as np
from numba.core import boxing, dispatcher, pythonapi, serialize
from numba.np import arrayobj

from pnt_gym.uncompiled import PythonRows, as_python

FunctionT = TypeVar("FunctionT", bound=Callable[..., Any])

_ARRAYS: Final[Any] = arrayobj
_BOXING: Final[Any] = boxing
_API: Final[Any] = pythonapi
_SERIALIZE: Final[Any] = serialize
_TUPLE: Final[Any] = tuple
_TYPES: Final[Any] = numba.types
_NJIT: Final[Any] = partial(numba.njit, error_model="numpy", nogil=True)
"""Divisions as in numpy, inf and NaN instead of exceptions; other threads go on meanwhile.

No `fastmath`: every operation is rounded as written."""

_DISPATCHER: Final[Any] = dispatcher.Dispatcher
"""What numba makes of a function."""

_CONSTANT: Final[Any] = (bool, int, float, tuple, np.generic, np.dtype)
"""What numba freezes into machine code where a function reads a global name."""


def _box(kind: Any, value: Any, given: Any) -> Any:
    """Code that makes a NamedTuple of a compiled function's result, without a call of its class, which is Python."""
    api, parts = given.pyapi, _BOXING.box_tuple(kind, value, given)
    make, of = map(api.unserialize, map(api.serialize_object, (_TUPLE.__new__, kind.instance_class)))
    made = api.call_function_objargs(make, (of, parts))
    for done in (parts, make, of):
        api.decref(done)
    return made


# Python handles signals where Python code begins. Numba calls Python code for every array and NamedTuple that compiled
# code returns, and goes on without it where Ctrl-C ended that code: the process would end by a fault of memory.
_SERIALIZE._numba_unpickle = cache(_SERIALIZE._numba_unpickle)
_API._boxers.functions |= dict.fromkeys((_TYPES.NamedTuple, _TYPES.NamedUniTuple), _box)


def kernel_part(function: FunctionT) -> FunctionT:
    """Compile a function that only compiled functions call, not Python; numba makes it a part of its callers."""
    part = _NJIT(no_cpython_wrapper=True, no_cfunc_wrapper=True)(function)
    if isinstance(part, _DISPATCHER):  # not so under NUMBA_DISABLE_JIT
        part.get_call_template = partial(_find_call, part.get_call_template)
    return part


def _find_call(find: Callable[..., Any], arguments: Any, keywords: Any) -> Any:
    """The version of a part for types of arguments; a number that a caller writes out brings no version of its own."""
    return find([_TYPES.unliteral(kind) for kind in arguments], keywords)


@kernel_part
def empty_rows(shape: Any, dtype: Any) -> Any:
    """Rows of a type whose values are arbitrary, in a compiled function."""
    return np.empty(shape, dtype)


@kernel_part
def _refuse_shapes(_: Any, __: Any) -> None:
    """Refuse to assign an array to a place of another shape."""
    raise ValueError("an array is assigned to a place of another shape")


if not isinstance(empty_rows, _DISPATCHER):  # under NUMBA_DISABLE_JIT

    def empty_rows(shape: Any, dtype: Any) -> Any:
        """Rows of a type whose values are arbitrary, with fields that Python reads as attributes."""
        return PythonRows(np.empty(shape, dtype))


def kernel(function: FunctionT) -> FunctionT:
    """Compile a function for the types of its annotations, when its module is imported, and keep the machine code.

    An annotation is float, int, bool, np.uint64, an array of `pnt_gym.rows` such as `Floats2` or `Rows1[Robot]`, or a
    NamedTuple of these. The machine code lies in the folder `NUMBA_CACHE_DIR`, next to the module, or in the user's
    cache: the first of these folders that can be written. Where no folder can be written, or the stored code cannot be
    read, every process compiles for itself, with a warning.
    """
    hints = get_type_hints(function, include_extras=True)
    names = function.__code__.co_varnames[: function.__code__.co_argcount]
    signature = tuple([_numba_type(hints[name]) for name in names])
    try:
        compiled = _NJIT(function)
        if not isinstance(compiled, _DISPATCHER):  # under NUMBA_DISABLE_JIT
            return cast("FunctionT", as_python(function))
        compiled.enable_caching()
        # Machine code on disk is stale when this stamp differs; numba's own is of the function's file alone.
        kept = compiled._cache._cache_file
        kept._source_stamp = digest(function)
        if not _is_kept(kept):
            _announce()
        with _quick_compilation():
            compiled.compile(signature)
        compiled.disable_compile()
        return compiled
    except Exception:  # any error of the cache folder; an error of the code is raised again below
        _warn()
        return _NJIT(signature)(function)


@contextmanager
def _quick_compilation() -> Generator[None]:
    """Compilation without what takes a sixth of its time: collecting garbage, and machine code for texts of shapes.

    Numba would compile such a text for its refusal to assign an array to a place of another shape.
    """
    is_collecting, refuse = gc.isenabled(), _ARRAYS.raise_with_shape_context
    gc.disable()
    _ARRAYS.raise_with_shape_context = _refuse_shapes
    try:
        yield
    finally:
        _ARRAYS.raise_with_shape_context = refuse
        if is_collecting:
            gc.enable()


def _numba_type(hint: Any) -> Any:
    """Numba's type of an annotation."""
    if get_origin(hint) is Annotated:
        kind, form = get_args(hint)
        return _TYPES.Array(numba.from_dtype(form.dtype or get_args(kind)[0].dtype), form.axes, "C")
    if hasattr(hint, "_fields"):
        parts = get_type_hints(hint, include_extras=True).values()
        return _TYPES.BaseTuple.from_types([_numba_type(part) for part in parts], hint)
    return {float: numba.float64, int: numba.int64, bool: numba.boolean, np.uint64: numba.uint64}[hint]


def _is_kept(file: Any) -> bool:
    """Whether there is machine code in numba's index; an index that cannot be read is removed.

    An index of an earlier version may name classes that are gone.
    """
    try:
        return bool(file._load_index())
    except Exception:  # whatever unpickling raises
        Path(file._index_path).unlink(missing_ok=True)
        return False


def digest(function: FunctionType) -> str:
    """The digest of what the machine code of a function is made from.

    This is the text of this file, of the files that hold the function and every compiled function that it calls, at any
    depth, and the value of every constant that these functions read.
    """
    functions: list[FunctionType] = [function]
    constants: set[tuple[str, str]] = set()
    for caller in functions:
        for name in caller.__code__.co_names:
            value: Any = caller.__globals__.get(name)
            if isinstance(value, _DISPATCHER) and value.py_func not in functions:
                functions.append(value.py_func)
            elif isinstance(value, _CONSTANT):
                constants.add((f"{caller.__module__}.{name}", repr(value)))
    texts = sorted({_text(file) for file in (__file__, *map(inspect.getfile, functions))})
    return hashlib.sha256(repr((texts, sorted(constants))).encode()).hexdigest()


@cache
def _text(file: str) -> str:
    return Path(file).read_text(encoding="utf-8")


@cache
def _announce() -> None:
    """Say once, to somebody who watches a terminal or a notebook, why the first steps take longer."""
    if sys.stderr.isatty() or "ipykernel" in sys.modules:
        print("pnt_gym makes machine code, once after an installation: about a minute", file=sys.stderr, flush=True)


@cache
def _warn() -> None:
    """Warn once that every process compiles anew, and say how to avoid that."""
    warnings.warn(
        "machine code cannot be kept or read, so every process makes it anew, which takes seconds; "
        "set NUMBA_CACHE_DIR to an empty folder that can be written",
        stacklevel=3,
    )
