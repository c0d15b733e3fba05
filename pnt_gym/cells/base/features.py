"""Tables of features: every number of an observation with unit, centre and scale, and their encoding and decoding.

Hidden values of a throw, which no observation has, are described here too, by name and unit.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, Self, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pnt_gym.arrays import Floats, tuples
from pnt_gym.rows import Field, Row

CLIP: Final = 5.0
"""Bound of every entry of an observation."""


@dataclass(frozen=True)
class ObservationEntry:
    """One entry of an observation: (value - centre) / scale, clipped to [-CLIP, CLIP]."""

    name: str
    unit: str
    centre: float
    scale: float
    meaning: str


@final
@dataclass(frozen=True)
class ScaledField(Field):
    """A field of a row whose values an observation has; a field of several values has one entry for each."""

    centre: float
    scale: float

    def entries(self, name: str, shape: tuple[int, ...]) -> Iterator[ObservationEntry]:
        """The entries of the field; "{k}" in its meaning stands for the number of each of several values."""
        for k in range(*shape or (1,)):
            numbered, meaning = f"{name}_{k}" if shape else name, self.meaning.format(k=k)
            yield ObservationEntry(numbered, self.unit, self.centre, self.scale, meaning)


def scaled(unit: str, centre: float, scale: float, meaning: str) -> Any:
    """A field of a row class with unit, centre, scale and meaning, which stands as its value in the class."""
    return ScaledField(unit, meaning, centre, scale)


@final
@dataclass(frozen=True)
class Feature(ObservationEntry):
    """An entry with its physical value."""

    value: Callable[[Any], Floats]
    """Function from the coming throws to the physical values (N,)."""


@final
@dataclass(frozen=True)
class Quantity:
    """One hidden value of a coming throw: a true number that no observation has."""

    name: str
    unit: str
    meaning: str
    value: Callable[[Any], Floats]
    """Function from the coming throws to the values (N,)."""


def merge_numbered(quantities: Sequence[Quantity]) -> list[Quantity]:
    """Quantities as a table lists them: names that differ only in a last number become one, with K for the number."""
    listed: dict[str, Quantity] = {}
    for quantity in quantities:
        name = re.sub(r"_\d+$", "_K", quantity.name)
        listed.setdefault(name, replace(quantity, name=name))
    return [*listed.values()]


class EntryTable:
    """The entries of one kind of observation.

    Args:
        entries: the entries in the order of the observation.
    """

    def __init__(self, entries: Sequence[ObservationEntry]) -> None:
        self._entries = tuple(entries)
        self._centre = np.array([entry.centre for entry in entries])
        self._scale = np.array([entry.scale for entry in entries])
        self.scaling: Floats = np.stack([self._centre, self._scale])
        """Centre and scale of each entry (2, D)."""

    @classmethod
    def of(cls, kind: type[Row]) -> Self:
        """The entries of rows whose fields are all scaled; each row is as many doubles in the order of the entries."""
        fields = [(name, field) for name, field in kind.fields.items() if isinstance(field, ScaledField)]
        return cls([entry for name, field in fields for entry in field.entries(name, kind.dtype[name].shape)])

    def __len__(self) -> int:
        return len(self._entries)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the entries."""
        return tuple(entry.name for entry in self._entries)

    def decode(self, observation: ArrayLike) -> dict[str, Floats]:
        """Physical values by feature name from observations (..., D); clipped entries stay clipped.

        Raises:
            ValueError: the observations have another number of entries.
        """
        values = tuples(observation, "observation", len(self)) * self._scale + self._centre
        return {entry.name: values[..., i] for i, entry in enumerate(self._entries)}

    def markdown(self) -> str:
        """The table in an environment's manual, one row per entry."""
        head = "| Num | Observation | Unit | Meaning | Centre | Scale | Min | Max |"
        rows = [head, "|---:" + "|---" * 3 + "|---:" * 4 + "|"]
        for i, entry in enumerate(self._entries):
            numbers = f"{entry.centre:g} | {entry.scale:g} | {-CLIP:g} | {CLIP:g}"
            rows.append(f"| {i} | {entry.name} | {entry.unit} | {entry.meaning} | {numbers} |")
        return "\n".join(rows)


def encoded(value: Any, centre: Any, scale: Any) -> Any:
    """Entries of observations within [-CLIP, CLIP], of numbers or of arrays; compiled functions call it, too."""
    return np.minimum(np.maximum((value - centre) / scale, -CLIP), CLIP)


@final
class FeatureTable(EntryTable):
    """The entries of one kind of observation, which it computes from coming throws.

    Args:
        features: the entries in the order of the observation.
    """

    def __init__(self, features: Sequence[Feature]) -> None:
        super().__init__(features)
        self._features = tuple(features)

    def encode(self, throws: Any) -> NDArray[np.float32]:
        """Observations (N, D) of coming throws, float32 within [-CLIP, CLIP]."""
        columns = [feature.value(throws) for feature in self._features]
        values = np.concatenate(columns, dtype=np.float64).reshape(len(columns), *columns[0].shape)
        return encoded(values.transpose(*range(1, values.ndim), 0), self._centre, self._scale).astype(np.float32)
