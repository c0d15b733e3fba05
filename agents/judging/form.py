"""Form of the columns that a benchmark keeps of a row: which there are, in what ranges, and one entry for each unit."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, ClassVar, Final, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError, ValidationInfo, model_validator

from pnt_gym.cells.base.problems import list_problems

from ..ground.cli import UsageError

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
    def _check_lengths(self, info: ValidationInfo) -> Self:
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
