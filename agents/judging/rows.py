"""Rows of records: columns of numbers by name, for several seeds and units."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Self, TypeAlias, final

import numpy as np
from numpy.typing import ArrayLike

from pnt_gym.arrays import Floats
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
