"""Typed rows: what a record of numbers holds, with unit and meaning beside each field.

A kind of rows is a class, and its rows stand in NumPy's structured arrays. Compiled functions take and return these
arrays, and read a row's fields by their names. `array["lift"]` is the column of a field, a view. A kind of rows that is
a subclass of `Columns` gives objects whose columns are attributes: `objects.mass`.
"""

from __future__ import annotations

import dataclasses
from typing import (
    TYPE_CHECKING,
    Annotated,
    Any,
    ClassVar,
    Final,
    Generic,
    NamedTuple,
    Self,
    TypeAlias,
    TypeVar,
    get_args,
    get_type_hints,
)

import numpy as np
from numpy.typing import NDArray

from pnt_gym.arrays import Bools, Floats, Ints, copy_rows, recast
from pnt_gym.errors import PntGymError

RowT = TypeVar("RowT")


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
Shorts1: TypeAlias = Annotated[NDArray[np.int32], Form(1, np.int32)]
Shorts2: TypeAlias = Annotated[NDArray[np.int32], Form(2, np.int32)]
Bools1: TypeAlias = Annotated[Bools, Form(1, np.bool_)]
Bools2: TypeAlias = Annotated[Bools, Form(2, np.bool_)]
Singles2: TypeAlias = Annotated[NDArray[np.float32], Form(2, np.float32)]
Keys1: TypeAlias = Annotated[NDArray[np.uint64], Form(1, np.uint64)]
Keys2: TypeAlias = Annotated[NDArray[np.uint64], Form(2, np.uint64)]
Bytes4: TypeAlias = Annotated[NDArray[np.uint8], Form(4, np.uint8)]
Pair: TypeAlias = Annotated[Floats, 2]
Triple: TypeAlias = Annotated[Floats, 3]
Quadruple: TypeAlias = Annotated[Floats, 4]


@dataclasses.dataclass(frozen=True)
class Field:
    """A field of a row."""

    unit: str
    """Unit of its values; "-" for none."""
    meaning: str
    """What the values tell."""
    name: str = dataclasses.field(default="", init=False)
    """Name in the class of rows, which sets it."""
    kind: type[Columns] | None = dataclasses.field(default=None, init=False)
    """Kind of the rows that are the values, which the class of rows sets; None for numbers."""

    def __set_name__(self, _: type[Any], name: str) -> None:
        self.__dict__["name"] = name

    def __get__(self, columns: Columns | None, _: Any = None) -> Any:
        """A copy of the column, which the object then keeps; of the class, the field itself."""
        if columns is None:
            return self
        column: Any = columns.rows[self.name]
        column = column.copy() if self.kind is None else self.kind(copy_rows(column))
        columns.__dict__[self.name] = column
        return column


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
        rows: Any = np.empty(shape, cls.dtype)
        return rows

    @classmethod
    def zeros(cls, *shape: int, **values: Any) -> Rows[Self]:
        """Rows of zeros, but for the given columns."""
        rows: Any = np.zeros(shape, cls.dtype)
        for name, value in values.items():
            rows[name] = value
        return rows


class Columns(Row):
    """Base of the kinds of rows whose columns are attributes of an object, which holds the rows.

    A subclass has fields of the types `Floats`, `Ints`, `Bools`, `Pair`, `Triple`, `Quadruple`, or of another kind of
    `Columns`. A column is a copy in C's order, made when the column is first read; so `put` alone overwrites rows.
    """

    _fields: ClassVar[tuple[str, ...]] = ("rows",)
    """Arrays of the object, as `arrays.take` takes them."""

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        hints = get_type_hints(cls)
        for name, of in cls.fields.items():
            if isinstance(hints[name], type) and issubclass(hints[name], Columns):
                of.__dict__["kind"] = hints[name]

    def __init__(self, rows: Any) -> None:
        self.rows: Any = rows

    @classmethod
    def of(cls, *shape: int, **columns: Any) -> Self:
        """The object of rows whose columns are zero, but for the given columns."""
        return cls(cls.zeros(*shape, **columns))

    def replace(self, **columns: Any) -> Self:
        """The object with other columns by name."""
        rows, fields = copy_rows(self.rows), self.fields
        parts = [columns.pop(name) if name in columns else getattr(self, name) for name in self._fields[1:]]
        for name, values in columns.items():
            rows[name] = values if fields[name].kind is None else values.rows
        return self.__class__(rows, *parts)

    def put(self, index: Any, source: Self) -> None:
        """Write rows at an index of arrays, in place; columns that were read are read again."""
        parts = {name: getattr(self, name) for name in self._fields}
        for name, array in parts.items():
            put(array, index, getattr(source, name))
        self.__dict__.clear()
        self.__dict__.update(parts)

    def __reduce__(self) -> tuple[Any, ...]:
        return self.__class__, tuple([getattr(self, name) for name in self._fields])

    def __setstate__(self, state: object) -> None:
        raise PntGymError(
            f"this pickle holds {type(self).__name__} of an older version of pnt_gym, which cannot be read; "
            "load the pickle with that version, and store seeds and actions instead, from which this version continues"
        )


_TYPES: Final[list[tuple[Any, Any]]] = [
    (float, np.float64), (int, np.int64), (bool, np.bool_), (Floats, np.float64), (Ints, np.int64), (Bools, np.bool_)
]  # fmt: skip
"""Types of fields with one number a row, and NumPy's types."""


def _column_type(hint: Any) -> tuple[Any, ...]:
    """NumPy's type of a field, and the shape of its values."""
    for kind, dtype in _TYPES:
        if hint == kind:
            return (dtype,)
    if isinstance(hint, type) and issubclass(hint, Row):
        return (hint.dtype,)
    return np.float64, get_args(hint)[1]


if TYPE_CHECKING:

    class Rows(NDArray[np.void], Generic[RowT]):
        """An array of rows of one kind."""

        def __getitem__(self, index: Any, /) -> Any: ...
else:

    class Rows(Generic[RowT]):
        """An array of rows of one kind; only type checkers and `pnt_gym.compiled` read this class."""


Rows1: TypeAlias = Annotated[Rows[RowT], Form(1)]
Rows2: TypeAlias = Annotated[Rows[RowT], Form(2)]


def put(rows: NDArray[Any], index: Any, source: NDArray[Any]) -> None:
    """Write rows at an index of arrays, in place."""
    if rows.dtype.names is None:
        rows[index] = source
    else:
        recast(rows)[index] = recast(source)
