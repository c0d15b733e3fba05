"""Typed rows: what a record of numbers holds, with unit and meaning beside each field.

A kind of rows is a class, and its rows stand in NumPy's structured arrays. Compiled functions take and return these
arrays, and read a row's fields by their names. `array["lift"]` is the column of a field, a view.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import (
    TYPE_CHECKING,
    Annotated,
    Any,
    ClassVar,
    Generic,
    NamedTuple,
    Self,
    TypeAlias,
    TypeVar,
    cast,
    get_type_hints,
)

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, Ints

RowT = TypeVar("RowT")
ArrayT = TypeVar("ArrayT", bound=NDArray[Any])


class Form(NamedTuple):
    """Form of an array, for compiled functions, which take arrays in C's order alone."""

    axes: int
    dtype: Any = None
    """Type of the entries; None for rows."""


Floats1: TypeAlias = Annotated[Floats, Form(1, np.float64)]
Floats2: TypeAlias = Annotated[Floats, Form(2, np.float64)]
Floats3: TypeAlias = Annotated[Floats, Form(3, np.float64)]
Ints1: TypeAlias = Annotated[Ints, Form(1, np.int64)]
Ints2: TypeAlias = Annotated[Ints, Form(2, np.int64)]
Ints3: TypeAlias = Annotated[Ints, Form(3, np.int64)]
Bools1: TypeAlias = Annotated[Bools, Form(1, np.bool_)]
Bools2: TypeAlias = Annotated[Bools, Form(2, np.bool_)]
Singles2: TypeAlias = Annotated[NDArray[np.float32], Form(2, np.float32)]
Keys1: TypeAlias = Annotated[NDArray[np.uint64], Form(1, np.uint64)]
Keys2: TypeAlias = Annotated[NDArray[np.uint64], Form(2, np.uint64)]
Bytes4: TypeAlias = Annotated[NDArray[np.uint8], Form(4, np.uint8)]
Pair: TypeAlias = Annotated[Floats, 2]
Triple: TypeAlias = Annotated[Floats, 3]
Quadruple: TypeAlias = Annotated[Floats, 4]


@dataclass(frozen=True)
class Field:
    """A field of a row."""

    unit: str
    """Unit of its values; "-" for none."""
    meaning: str
    """What the values tell."""


def field(unit: str, meaning: str) -> Any:
    """Unit and meaning of a field, which stand as its value in a row class."""
    return Field(unit, meaning)


class Row:
    """Base of the kinds of rows; a subclass has fields of the types float, int, bool, `Pair`, `Triple`, `Quadruple`.

    `dtype` is the type of the rows in arrays; each row takes a whole number of doubles.
    """

    dtype: ClassVar[np.dtype[np.void]]
    fields: ClassVar[dict[str, Field]]

    def __init_subclass__(cls) -> None:
        hints = get_type_hints(cls, include_extras=True)
        cls.fields = {name: value for name, value in vars(cls).items() if isinstance(value, Field)}
        cls.dtype = np.dtype([(name, *_column_type(hints[name])) for name in cls.fields], align=True)

    @classmethod
    def empty(cls, *shape: int) -> Rows[Self]:
        """Rows whose values are arbitrary."""
        return cast("Rows[Self]", np.empty(shape, cls.dtype))

    @classmethod
    def zeros(cls, *shape: int, **values: Any) -> Rows[Self]:
        """Rows of zeros, but for the given columns."""
        rows = np.zeros(shape, cls.dtype)
        for name, value in values.items():
            rows[name] = value
        return cast("Rows[Self]", rows)


def _column_type(hint: Any) -> tuple[Any, ...]:
    """NumPy's type of a field, and the shape of its values."""
    if hint in (float, int, bool):
        return (np.dtype(hint),)
    return np.dtype(np.float64), (hint.__metadata__[0],)


if TYPE_CHECKING:

    class Rows(NDArray[np.void], Generic[RowT]):
        """An array of rows of one kind."""

        def __getitem__(self, index: Any, /) -> Any: ...
else:

    class Rows(Generic[RowT]):
        """An array of rows of one kind; only type checkers and `pnt_gym.compiled` read this class."""


Rows1: TypeAlias = Annotated[Rows[RowT], Form(1)]
Rows2: TypeAlias = Annotated[Rows[RowT], Form(2)]


def _words(rows: NDArray[Any], axes: int) -> Floats:
    """The rows as doubles, with one more axis; NumPy copies rows of many fields one field after the other."""
    width = rows.dtype.itemsize // 8
    return rows.view(np.float64).reshape(*rows.shape[:axes], width)


def take(rows: ArrayT, index: Any) -> ArrayT:
    """A copy of the rows at an index of arrays."""
    if rows.dtype.names is None:
        return cast("ArrayT", rows[index])
    taken = np.ascontiguousarray(_words(rows, rows.ndim)[index])
    return cast("ArrayT", taken.view(rows.dtype)[..., 0])


def join(rows: Sequence[Rows[RowT]]) -> Rows[RowT]:
    """The rows of all arrays, one after the other."""
    return cast("Rows[RowT]", np.concatenate(rows))


def put(rows: NDArray[Any], index: Any, source: NDArray[Any]) -> None:
    """Write rows at an index of arrays, in place."""
    if rows.dtype.names is None:
        rows[index] = source
    else:
        _words(rows, rows.ndim)[index] = _words(source, source.ndim)
