"""Rows of records, and the form of the columns that a benchmark keeps of a row."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, ClassVar, Final, Self, TypeAlias, final

import numpy as np
from numpy.typing import ArrayLike
from pydantic import BaseModel, ConfigDict, Field, ValidationError, ValidationInfo, model_validator

from pnt_gym.arrays import Floats
from pnt_gym.cells.base.problems import list_problems
from pnt_gym.errors import one_sentence

from ..ground.cli import UsageError

Values: TypeAlias = ArrayLike | Sequence[float | None]
"""Numbers or truth values of units; None where a unit has none."""


@final
@dataclass(frozen=True)
class Rows:
    """Columns of S seeds and U units: (S, U), or (S, U, K) by item or robot; NaN where a unit has no value.

    Columns of parts of units, such as decisions, and of totals have lengths of their own.
    """

    columns: Mapping[str, Floats]
    length: int = 1
    """Number of units, one after the other in a cell, that depend on one another."""
    side: int = 1
    """Number of cells side by side, in whose order units follow each other."""

    @classmethod
    def of(cls, columns: Mapping[str, Values], length: int = 1, side: int = 1) -> Self:
        """Rows of one seed from columns (U,) or (U, K); None is NaN."""
        return cls({name: np.array(values, dtype=np.float64)[None] for name, values in columns.items()}, length, side)

    @classmethod
    def join(cls, parts: Sequence[Self]) -> Self:
        """Rows of several seeds, of which all have the same columns and units."""
        first = parts[0]
        columns = {name: np.concatenate([part.columns[name] for part in parts]) for name in first.columns}
        return cls(columns, first.length, first.side)

    def __contains__(self, name: str) -> bool:
        return name in self.columns

    def __getitem__(self, name: str) -> Floats:
        return self.columns[name]

    def runs(self, name: str) -> Floats:
        """A column by runs of units that depend on one another (S, length, R)."""
        column = self.columns[name]
        if self.length == 1:
            return column[:, None]
        by_run = column.reshape(len(column), -1, self.length, self.side).swapaxes(1, 2)
        return by_run.reshape(len(column), self.length, -1)


def numbers(owner: str, columns: Mapping[str, Values], needed: Sequence[str]) -> dict[str, Floats]:
    """Columns (U,) of a record as floats: true is 1, false 0, and None NaN.

    Args:
        owner: name of the record, for errors.
        columns: numbers or truth values by name.
        needed: columns that must be there.

    Raises:
        UsageError: a column is missing, is empty, holds other than numbers, or has another length than the others.
    """
    found: dict[str, Floats] = {}
    for name, values in columns.items():
        try:
            column = np.asarray(values)
            column = column.astype(np.float64) if column.dtype.kind in "biufO" else None
        except (TypeError, ValueError):
            column = None
        if column is None or column.ndim != 1 or not len(column):
            text = one_sentence(repr(values), 60)
            raise UsageError(f"column {name!r} of {owner} is {text}; it must be a list of numbers, one for each unit")
        found[name] = column
        length = len(next(iter(found.values())))
        if len(column) != length:
            raise UsageError(
                f"column {name!r} of {owner} has {len(column)} entries; {next(iter(found))!r} has {length}"
            )
    for name in needed:
        if name not in found:
            raise UsageError(f"{owner} has no column {name!r}, from which a figure is computed")
    return found


LARGEST: Final = 1e9
"""Largest absolute value of a number in a column, in SI units: sums of such numbers stay finite."""
Number = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]
Amount = Annotated[float, Field(ge=0.0, le=LARGEST)]
Count = Annotated[int, Field(ge=0, le=int(LARGEST))]


class Columns(BaseModel):
    """Columns of a row: every list, and every text with a letter for each unit, has one entry for each unit."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True)

    names: ClassVar[frozenset[str]] = frozenset()
    """Columns that list names, and not units."""

    @model_validator(mode="after")
    def _check(self, info: ValidationInfo) -> Self:
        count: int = (info.context or {})["count"]
        for name, column in self.given():
            if name not in self.names and isinstance(column, list | str) and len(column) != count:
                raise ValueError(f"{name} has {len(column)} entries; the plan asks for {count}")
        return self

    def given(self) -> list[tuple[str, Any]]:
        """Names and values of the columns that the row has."""
        return [(name, getattr(self, name)) for name in sorted(self.model_fields_set)]


class FigureColumns(Columns):
    """Columns of a kind of trial that keeps its figures alone, or further columns of its own."""

    model_config = ConfigDict(extra="allow")

    figures: ClassVar[frozenset[str]] = frozenset()
    """Figures that every row has."""

    @model_validator(mode="after")
    def _check_figures(self) -> Self:
        for name in sorted(self.figures):
            if not isinstance(getattr(self, name, None), list):
                raise ValueError(f"the list {name!r} is missing")
        return self


def check_model(path: Path, form: type[BaseModel], data: Any) -> None:
    """Make sure that the data of a file have a form.

    Raises:
        UsageError: the data have another one.
    """
    try:
        form.model_validate(data)
    except ValidationError as error:
        raise UsageError(*list_problems(f"{str(path)!r}", error, form)) from None
